"""Field paths after a topic's name: ``/pose/header/stamp``, ``/arr[2]``, ``/arr[1:5:2]/x`` (L60)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.timing import TVal
from pyros1.msgs import Message, load_message
from pyros1.msgs.spec import is_type_name

_STEP = re.compile(r"([A-Za-z_]\w*)(\[[^\[\]]*\])?\Z", re.ASCII)
_INTEGER = re.compile(r"[+-]?\d{1,18}\Z", re.ASCII)
_FIELD = r"[\w/]*(?:\[[-+\d:]*\][\w/]*)*"
# No match if the part after the colon is a list of field names, as in /topic/x:y and /topic/x[0]:y[0].
_TOPIC_WITH_EXPRESSION = re.compile(rf"\s*([\w/~]+)\s*:(?!{_FIELD}(?::{_FIELD})*\s*(?:,|\Z))\s*(.+?)\s*\Z", re.DOTALL)
_FIELD_SEPARATOR = re.compile(r":(?![^\[\]]*\])")
"""Matches a colon between fields, but not a colon in a slice."""
_TIME_PARTS = ("secs", "nsecs")


class FieldPathError(Error):
    """A field path is malformed or refers to a field that does not exist."""


def split_expression(text: str) -> tuple[str, str] | None:
    """Return the topic and the expression of a string such as ``/topic: m.x * 2``; None for other strings."""
    match = _TOPIC_WITH_EXPRESSION.match(text)
    return (match[1], match[2]) if match else None


def expand_fields(argument: str) -> list[str]:
    """Return the fields that an argument names: three in ``/t/x:y:z``, two in ``/t/x[0]:y[0]`` and in ``/t/x,/u/y``.

    An expression is returned unchanged.
    """
    if split_expression(argument):
        return [argument]
    fields = []
    for part in filter(None, argument.split(",")):
        first, *others = [part] if split_expression(part) else _FIELD_SEPARATOR.split(part)
        parent = first.rpartition("/")[0]
        fields += [first, *(f"{parent}/{other}" for other in others if other)]
    return fields


@dataclass(frozen=True)
class _Step:
    field: str
    subscript: int | slice | None


class FieldPath:
    """A path to a field of a message.

    Args:
        text: the part after the topic, which is empty or of the form ``/field[...]/field...``. An index selects an
            element; a slice applies the remaining path to each of its elements.

    Raises:
        FieldPathError: the path is malformed.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._steps = [_parse_step(part) for part in text.strip("/").split("/")] if text.strip("/") else []

    def get(self, message: Any) -> tuple[Any, str | None]:
        """Return the value at the path and the value's type.

        The type is None if the path is empty or its slices select no elements.

        Raises:
            FieldPathError: an index is out of range, or a field does not exist.
        """
        try:
            return _resolve(message, None, self._steps)
        except IndexError as error:
            raise FieldPathError(f"{error}: {self.text}") from None
        except AttributeError as error:
            raise FieldPathError(f"{error}: {self.text}") from None
        except TypeError as error:
            raise FieldPathError(f"{error}: {self.text}") from None

    def type_in(self, message_class: type[Message]) -> str:
        """Return the type of the field, such as ``geometry_msgs/Pose[]``.

        Raises:
            FieldPathError: a field does not exist.
        """
        type_name, is_list = message_class._type, False
        owner: type[Message] | None = message_class
        for step in self._steps:
            type_name = _field_type(type_name, owner, step.field)
            if step.subscript is not None:
                if "[" not in type_name and type_name != "string":
                    raise FieldPathError(f"field {step.field!r} of type {type_name} has no elements")
                if isinstance(step.subscript, int):
                    type_name = type_name.partition("[")[0]
                elif "[" in type_name:
                    type_name, is_list = type_name.partition("[")[0], True
            owner = None
        return type_name + "[]" if is_list else type_name


def _parse_step(part: str) -> _Step:
    match = _STEP.match(part)
    if match is None:
        raise FieldPathError(f"not a field: {part!r}")
    field, brackets = match.groups()
    if brackets is None:
        return _Step(field, None)
    subscript = brackets[1:-1]
    parts = subscript.split(":")
    prefix = f"field {field!r} has invalid slice argument {subscript!r}"
    if len(parts) > 3:
        raise FieldPathError(f"{prefix}: too many slice arguments")
    numbers: list[int | None] = []
    for number in map(str.strip, parts):
        if number and not _INTEGER.match(number):
            raise FieldPathError(f"{prefix}: non-integer array index step {number!r}")
        numbers.append(int(number) if number else None)
    if len(numbers) == 1:
        if numbers[0] is None:
            raise FieldPathError(f"{prefix}: an index is missing")
        return _Step(field, numbers[0])
    if len(numbers) == 3 and numbers[2] == 0:
        raise FieldPathError(f"{prefix}: the step must not be zero")
    return _Step(field, slice(*numbers))


def _resolve(value: Any, type_name: str | None, steps: Sequence[_Step]) -> tuple[Any, str | None]:
    for number, step in enumerate(steps):
        type_name = _slot_type(value, step.field)
        value = getattr(value, step.field)
        if step.subscript is None:
            continue
        value = value[step.subscript]
        if isinstance(step.subscript, int):
            type_name = type_name.partition("[")[0]
            continue
        remaining = steps[number + 1 :]
        if remaining:
            results = [_resolve(element, None, remaining) for element in value]
            type_name = f"{results[0][1]}[]" if results else None
            return [element for element, _ in results], type_name
    return value, type_name


def _slot_type(owner: Any, field: str) -> str:
    if isinstance(owner, TVal) and field in _TIME_PARTS:
        return "int32"
    if not isinstance(owner, Message) or field not in owner.__slots__:
        raise AttributeError(f"{type(owner).__name__!r} object has no field {field!r}")
    return owner._slot_types[list(owner.__slots__).index(field)]


def _field_type(type_name: str, owner: type[Message] | None, field: str) -> str:
    if type_name in ("time", "duration") and field in _TIME_PARTS:
        return "int32"
    if owner is None:
        if not is_type_name(type_name):
            raise FieldPathError(f"type {type_name} has no field {field!r}")
        owner = load_message(type_name)
    if field not in owner.__slots__:
        raise FieldPathError(f"type {type_name} has no field {field!r}")
    return owner._slot_types[list(owner.__slots__).index(field)]
