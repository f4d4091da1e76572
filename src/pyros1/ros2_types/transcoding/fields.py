"""Finds and matches the fields of a ROS 1 type and a ROS 2 type. No I/O."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple, TypeVar

from pyros1.ground.errors import DefinitionError
from pyros1.msgs import spec as ros1
from pyros1.ros2_types import model as ros2

_MAX_PARTS = 64
_MAX_NAMES = 8
_Flat = TypeVar("_Flat")


class Flat1(NamedTuple):
    """A field of a ROS 1 type or of one nested in it, and the name of the type that has it."""

    field: ros1.Field
    owner: str


class Flat2(NamedTuple):
    """A field of a ROS 2 type or of one nested in it."""

    field: ros2.Field


def ros1_fields(name: str | None, specs: Mapping[str, ros1.MessageSpec], paths: Iterable[str]) -> dict[str, Flat1]:
    """Return the fields of a type in their order.

    Args:
        name: its name, ``package/Type``; None if there is none.
        specs: the types.
        paths: the dotted paths of the requested fields. A message that contains one of them is replaced by its fields.

    Returns:
        Path -> field.

    Raises:
        DefinitionError: a type is unknown, or does not have such a field.
    """

    def fields_of(name: str) -> dict[str, Flat1]:
        if name not in specs:
            raise DefinitionError(f"the definition of {name:.200} is missing")
        return {field.name: Flat1(field, name) for field in specs[name].fields}

    def nested(flat: Flat1) -> str | None:
        return None if flat.field.is_builtin or flat.field.length is not None else flat.field.base

    return {} if name is None else _flatten(name, fields_of, nested, paths)


def ros2_fields(name: str | None, types: ros2.Types, paths: Iterable[str]) -> dict[str, Flat2]:
    """Return the fields of a type in their order; arguments, result and errors as for `ros1_fields`."""

    def fields_of(name: str) -> dict[str, Flat2]:
        if name not in types:
            raise DefinitionError(f"the definition of {name:.200} is missing")
        return {field.name: Flat2(field) for field in types[name].fields}

    def nested(flat: Flat2) -> str | None:
        type = flat.field.type
        return type.base if type.is_nested and type.length is ros2.Length.SINGLE else None

    return {} if name is None else _flatten(name, fields_of, nested, paths)


def partners(fields1: Mapping[str, object], fields2: Mapping[str, object]) -> dict[str, str]:
    """Match fields by name: return ROS 1 name -> ROS 2 name."""
    result = {name: name for name in fields1 if name in fields2}
    for name in fields1:
        lower_name = name.lower()
        if name not in result and lower_name in fields2 and lower_name not in result.values():
            result[name] = lower_name
    return result


def _flatten(
    name: str,
    fields_of: Callable[[str], dict[str, _Flat]],
    nested: Callable[[_Flat], str | None],
    paths: Iterable[str],
) -> dict[str, _Flat]:
    result = fields_of(name)
    wanted = [*paths]
    for path in wanted:
        parts = path.split(".", _MAX_PARTS)
        owner = name
        for index, part in enumerate(parts):
            prefix = ".".join(parts[:index])
            fields = fields_of(owner)
            if part not in fields:
                known = ", ".join([*fields][:_MAX_NAMES]) + (", ..." if len(fields) > _MAX_NAMES else "")
                raise DefinitionError(f"{owner} has no field {part!r:.100}; it has {known or 'none'}")
            if index + 1 == len(parts):
                break
            inner = nested(fields[part])
            if inner is None:
                raise DefinitionError(f"{part!r} of {owner} is not a single message, so {path!r:.200} cannot be used")
            if (whole := f"{prefix}.{part}".lstrip(".")) in wanted:
                raise DefinitionError(f"{whole!r} is already used as a whole, so {path!r:.200} cannot be used")
            if whole in result:
                inside = {f"{whole}.{key}": flat for key, flat in fields_of(inner).items()}
                result = {
                    key: flat
                    for outer, outer_flat in result.items()
                    for key, flat in (inside.items() if outer == whole else [(outer, outer_flat)])
                }
            owner = inner
    return result
