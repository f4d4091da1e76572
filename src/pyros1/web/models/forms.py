"""Prepares forms in which messages are edited on the page (no I/O, except for finding definitions)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from pyros1.ground.errors import MessageError
from pyros1.msgs import Message
from pyros1.msgs.json_form import to_json
from pyros1.msgs.spec import Constant, parse_message
from pyros1.values.writing import dump

_MAX_DEPTH = 12
_MAX_SAFE_INTEGER = 1 << 53
_INTEGER_TYPES = frozenset(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)) | {"byte", "char"}
_COUNTER_FIELDS = frozenset({"id", "seq"})
"""Names of fields that count something, so no constants belong to them."""


def form(cls: type[Message]) -> dict[str, Any]:
    """Return the data for a form in which a message is edited.

    Returns:
        - type: the type's name
        - text: the type's definition
        - fields: for each field, its name, its type, its nested fields or null, and its choices (pairs of name and
          value) or null
        - default: a message with default values, as JSON; orientations have no rotation
    """
    return {"type": cls._type, "text": cls._full_text, "fields": _fields(cls, 0), "default": _default_value(cls)}


def _default_value(cls: type[Message]) -> dict[str, Any]:
    value: dict[str, Any] = to_json(cls())
    if cls._type == "geometry_msgs/Quaternion":
        value["w"] = 1.0  # all zeros is not an orientation, and programs reject it
    for name, field_type in zip(cls.__slots__, cls._slot_types, strict=True):
        if (nested := cls._classes.get(field_type)) is not None:
            value[name] = _default_value(nested)
    return value


def numeric_paths(cls: type[Message], path: str, depth: int = 0) -> Iterator[str]:
    """Yield the paths of a message's numeric fields; in arrays, only those of the first element."""
    for name, field_type in zip(cls.__slots__, cls._slot_types, strict=True):
        base_type, bracket, _ = field_type.partition("[")
        field_path = f"{path}/{name}[0]" if bracket else f"{path}/{name}"
        if "/" not in base_type:
            if base_type != "string":
                yield field_path
        elif depth < _MAX_DEPTH:
            yield from numeric_paths(cls._classes[base_type], field_path, depth + 1)


def to_yaml(value: Mapping[str, Any]) -> str:
    """Return a message as YAML text, as accepted by ``pyros1 topic pub``.

    Args:
        value: the message as `pyros1.msgs.json_form.to_json` returns it; bytes are base64 in both forms.
    """

    def is_short(part: Any) -> bool:
        children = part.values() if isinstance(part, Mapping) else part
        return not any(isinstance(each, (list, dict)) for each in children) and (
            isinstance(part, list) or part.keys() == {"secs", "nsecs"}
        )

    return dump(value, is_inline=is_short, ordered=True)


def from_yaml(cls: type[Message], value: Any) -> Any:
    """Complete a message that was loaded from YAML text, so that every field has a value; return it as JSON.

    Raises:
        MessageError: a field does not exist, or the value is not a message.
    """
    if value is None:
        value = {}
    if not isinstance(value, dict):
        raise MessageError(f"a message must be written as fields with values, not as {_to_json(value)!r}")
    message: dict[str, Any] = to_json(cls())
    field_types = dict(zip(cls.__slots__, cls._slot_types, strict=True))
    for name, field_value in value.items():
        if name not in field_types:
            raise MessageError(f"{cls._type} has no field {str(name)[:100]!r}")
        nested = cls._classes.get(field_types[name].partition("[")[0])
        if nested is not None and "[" not in field_types[name] and isinstance(field_value, dict):
            message[name] = from_yaml(nested, field_value)
        elif nested is not None and isinstance(field_value, list):
            message[name] = [from_yaml(nested, each) for each in field_value]
        else:
            message[name] = _to_json(field_value)
    return message


def _to_json(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else f"{'-' * (value < 0)}Infinity"
    if isinstance(value, dict):
        return {str(key): _to_json(child) for key, child in value.items()}
    if isinstance(value, (list, tuple)):
        return [_to_json(child) for child in value]
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    return value if isinstance(value, (str, int, float, bool)) or value is None else str(value)


def to_page_json(value: Any) -> Any:
    """Return a value for a page. Integers that JavaScript would round and non-finite floats become strings."""
    if isinstance(value, dict):
        return {name: to_page_json(child) for name, child in value.items()}
    if isinstance(value, list):
        return [to_page_json(child) for child in value]
    if isinstance(value, float):
        return _to_json(value)
    return str(value) if isinstance(value, int) and not -_MAX_SAFE_INTEGER < value < _MAX_SAFE_INTEGER else value


def choices(cls: type[Message]) -> dict[str, list[list[Any]]]:
    """Return field name -> the constants that are possible values of the field, each as name and value.

    A definition does not specify which fields its constants belong to. Constants whose names begin with a field's name
    are assigned to that field; others to the fields of the constants' type or, if there are none and the type is an
    integer type, to all integer fields. If there are as many runs of values as such fields, each field gets one run;
    otherwise, each gets all.
    """
    try:
        constants = parse_message(cls._type, cls._full_text.split("\n" + "=" * 10, 1)[0]).constants
    except MessageError:
        return {}
    fields = [pair for pair in zip(cls.__slots__, cls._slot_types, strict=True) if pair[0] not in _COUNTER_FIELDS]
    choices_by_field: dict[str, list[list[Any]]] = {}
    unassigned: list[Constant] = []
    for constant in constants:
        owners = [
            name
            for name, field_type in fields
            if constant.name.upper().startswith(f"{name.upper()}_")
            and (field_type == constant.type or {field_type, constant.type} <= _INTEGER_TYPES)
        ]
        if owners:
            choices_by_field.setdefault(max(owners, key=len), []).append([constant.name, to_page_json(constant.value)])
        else:
            unassigned.append(constant)
    for field_type in dict.fromkeys(constant.type for constant in unassigned):
        names = [name for name, other_type in fields if other_type == field_type]
        if not names and field_type in _INTEGER_TYPES:
            names = [name for name, other_type in fields if other_type in _INTEGER_TYPES]
        runs = _runs([constant for constant in unassigned if constant.type == field_type])
        for number, name in enumerate(names):
            field_runs = [runs[number]] if len(runs) == len(names) else runs
            choices_by_field.setdefault(name, []).extend(
                [each.name, to_page_json(each.value)] for run in field_runs for each in run
            )
    return choices_by_field


def _runs(constants: list[Constant]) -> list[list[Constant]]:
    """Split constants into runs, in each of which the values do not decrease.

    Authors often list one group of constants per field, in the order of the fields.
    """
    runs: list[list[Constant]] = []
    for constant in constants:
        previous = runs[-1][-1].value if runs else None
        if previous is None or (
            not isinstance(previous, str) and not isinstance(constant.value, str) and constant.value < previous
        ):
            runs.append([])
        runs[-1].append(constant)
    return runs


def _fields(cls: type[Message], depth: int) -> list[list[Any]]:
    field_choices = choices(cls)
    slots = zip(cls.__slots__, cls._slot_types, strict=True)
    return [
        [name, field_type, _nested_fields(cls, field_type, depth), field_choices.get(name)]
        for name, field_type in slots
    ]


def _nested_fields(cls: type[Message], field_type: str, depth: int) -> list[list[Any]] | None:
    nested = cls._classes.get(field_type.partition("[")[0])
    return None if nested is None or depth >= _MAX_DEPTH else _fields(nested, depth + 1)
