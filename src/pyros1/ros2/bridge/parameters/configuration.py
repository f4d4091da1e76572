"""The parameters of a ROS 2 node as a configuration of dynamic_reconfigure. No I/O.

dynamic_reconfigure has booleans, 32-bit integers, doubles and strings. Parameters of other types are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from pyros1.msgs.dynamic_reconfigure.msg import Config as ConfigMessage
from pyros1.msgs.dynamic_reconfigure.msg import GroupState
from pyros1.reconfigure.encoding import encode, encode_description
from pyros1.reconfigure.values import INT_RANGE, TYPE_CONVERTERS
from pyros1.ros2.bridge.parameters.messages import Descriptor, Value

MAX_STRING = 10_000
"""Maximum length of a string value in characters."""
MAX_TEXT = 1 << 20
"""Maximum total length in characters of a node's names, descriptions and strings."""
_MAX_NAME = 255
_MAX_DESCRIPTION = 1000
_ROOT = "Default"
_LIMITS: dict[str, tuple[Any, Any]] = {
    "bool": (False, True),
    "int": (INT_RANGE[0], INT_RANGE[-1]),
    "double": (-math.inf, math.inf),
    "str": ("", ""),
}
_TYPES: dict[type, str] = {bool: "bool", int: "int", float: "double", str: "str"}
Scalar = bool | int | float | str


class _Entry(NamedTuple):
    type: str
    description: str
    minimum: Any
    maximum: Any


class Configuration:
    """A node's parameters and their values. Not thread-safe.

    Args:
        descriptors: the node's descriptors of its parameters.
        values: the values of the parameters that have one.

    Attributes:
        left_out: the parameters that have no counterpart, and why.
    """

    def __init__(self, descriptors: Iterable[Descriptor], values: Mapping[str, Value]) -> None:
        self.left_out: dict[str, str] = {}
        self._entries: dict[str, _Entry] = {}
        self._values: dict[str, Scalar] = {}
        self._size = 0
        for descriptor in descriptors:
            name, value = descriptor.name, values.get(descriptor.name)
            entry = _entry(descriptor, value)
            if isinstance(entry, str):
                self.left_out[name] = entry
                continue
            size = len(name) + len(entry.description) + _size(value)
            if self._size + size > MAX_TEXT:
                self.left_out[name] = "the node has too much text"
                continue
            self._size += size
            self._entries[name] = entry
            self._values[name] = value  # type: ignore[assignment] # `_entry` allows only scalars

    @property
    def names(self) -> list[str]:
        """The names of the parameters in the configuration."""
        return [*self._entries]

    def description(self) -> Any:
        """Return the configuration as a dynamic_reconfigure/ConfigDescription, with the values as defaults."""
        parameters = [
            {"name": name, "type": entry.type, "level": 0, "description": entry.description, "edit_method": ""}
            for name, entry in self._entries.items()
        ]
        root = {"name": _ROOT, "type": "", "parent": 0, "id": 0, "parameters": parameters, "groups": []}
        maximum = {name: entry.maximum for name, entry in self._entries.items()}
        minimum = {name: entry.minimum for name, entry in self._entries.items()}
        return encode_description(root, maximum, minimum, self._values)

    def message(self) -> Any:
        """Return the values as a dynamic_reconfigure/Config."""
        message: ConfigMessage = encode(self._values, {name: entry.type for name, entry in self._entries.items()})
        message.groups = [GroupState(_ROOT, True, 0, 0)]
        return message

    def update(self, values: Mapping[str, Value | None]) -> bool:
        """Record new values, and return whether they fit: if not, the node must be queried again.

        Args:
            values: the new values; parameters that are not in the configuration are ignored.
        """
        fits = True
        for name, value in values.items():
            entry = self._entries.get(name)
            if entry is None:
                continue
            growth = _size(value) - _size(self._values[name])
            if _TYPES.get(type(value)) != entry.type or _problem(value) or self._size + growth > MAX_TEXT:
                fits = False
                continue
            self._size += growth
            self._values[name] = value  # type: ignore[assignment] # its type is known by now
        return fits

    def requested(self, config: Any) -> tuple[dict[str, Scalar], list[str]]:
        """Return the values in a dynamic_reconfigure/Config, clamped to their limits as by dynamic_reconfigure's
        servers, and messages about what cannot be set.
        """
        values: dict[str, Scalar] = {}
        problems = []
        for type_name, field in (("bool", "bools"), ("int", "ints"), ("str", "strs"), ("double", "doubles")):
            for each in getattr(config, field):
                entry = self._entries.get(each.name)
                if entry is None:
                    problems.append(f"there is no parameter {each.name:.100} that can be changed")
                elif type_name != entry.type and (type_name, entry.type) != ("int", "double"):
                    problems.append(f"parameter {each.name:.100} is of type {entry.type}, not {type_name}")
                else:
                    values[each.name] = _clamped(entry, TYPE_CONVERTERS[entry.type](each.value))
        return values, problems


def _size(value: object) -> int:
    return len(value) if isinstance(value, str) else 0


def _clamped(entry: _Entry, value: Any) -> Any:
    if entry.type not in ("int", "double"):
        return value
    return entry.minimum if value < entry.minimum else entry.maximum if value > entry.maximum else value


def _entry(descriptor: Descriptor, value: Value | None) -> _Entry | str:
    """Return a parameter's entry, or why it has no counterpart."""
    name = descriptor.name
    if not (0 < len(name) <= _MAX_NAME and name.isprintable() and " " not in name) or name == "groups":
        return "its name is not allowed"
    if descriptor.read_only:
        return "read-only"
    problem = _problem(value)
    if problem:
        return problem
    type_name = _TYPES[type(value)]
    lowest, highest = _LIMITS[type_name]
    limits: tuple[Any, Any] | None = {"int": descriptor.integers, "double": descriptor.doubles}.get(type_name)
    if limits is not None and limits[0] <= limits[1]:
        lowest, highest = max(lowest, limits[0]), min(highest, limits[1])
    return _Entry(type_name, descriptor.text[:_MAX_DESCRIPTION], lowest, highest)


def _problem(value: Value | None) -> str:
    """Return why dynamic_reconfigure cannot represent a value; empty if it can."""
    if value is None:
        return "without a value"
    if isinstance(value, list):
        return "an array"
    if isinstance(value, int) and value not in INT_RANGE:
        return "more than 32 bits"
    return "too long" if isinstance(value, str) and len(value) > MAX_STRING else ""
