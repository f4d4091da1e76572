"""Describes configurations in Python: parameters in groups. This module has no side effects."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from pyros1.reconfigure.values import INT_RANGE

_INFINITY = float("inf")
_DEFAULTS_BY_TYPE: dict[str, tuple[type, Any, Any, Any]] = {
    "int": (int, 0, INT_RANGE[0], INT_RANGE[-1]),
    "double": (float, 0.0, -_INFINITY, _INFINITY),
    "str": (str, "", "", ""),
    "bool": (bool, False, False, True),
}
"""For each type name, the Python type, and the default, minimum and maximum to use if none are given."""
_TYPE_NAMES = {bool: "bool", int: "int", float: "double", str: "str"}


class Group:
    """A group of parameters and other groups; created by `Parameters.group`.

    Attributes:
        name, type, state, id: see `pyros1.reconfigure.encoding`.
        parent: the parent group; None for the outermost group.
        parameters: dictionaries that describe the parameters.
        groups: the groups directly in this one.
    """

    def __init__(self, name: str, type: str = "", state: bool = True, parent: Group | None = None, id: int = 0) -> None:
        self.name, self.type, self.state, self.id, self.parent = name, type, state, id, parent
        self.parameters: list[dict[str, Any]] = []
        self.groups: list[Group] = []

    def add(
        self,
        name: str,
        default: Any = None,
        description: str = "",
        *,
        type: str | None = None,
        minimum: Any = None,
        maximum: Any = None,
        level: int = 0,
        choices: Mapping[str, Any] | None = None,
        edit_method: str = "",
    ) -> dict[str, Any]:
        """Add a parameter. Return the dictionary that describes it.

        Args:
            name: the parameter's name: a letter, followed by letters, digits and ``_``.
            default: the initial value; None for 0, 0.0, False or an empty string.
            description: the text that tools display.
            type: "bool", "int", "double" or "str"; None for the type of the default.
            minimum, maximum: the limits of a number.
            level: bits that are passed to the callback when the parameter changes, to tell the callback what to do.
            choices: values by name, which tools offer for selection.
            edit_method: a string that is sent to tools instead of ``choices``.

        Raises:
            ValueError: the name is not legal.
            TypeError: a value has a different type than the parameter.
        """
        if not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII):
            raise ValueError(
                f"The name of field '{name}' does not follow the ROS naming conventions, "
                "see http://wiki.ros.org/ROS/Patterns/Conventions"
            )
        if not isinstance(description, str):
            raise TypeError(f"'{name}': the description must be a string, not {description!r}")
        type_name = type if type is not None else _TYPE_NAMES.get(default.__class__, "")
        if type_name not in _DEFAULTS_BY_TYPE:
            raise TypeError(f"'{name}' must have a default, or a type, of bool, int, double (float) or str")
        _, default_of_type, lowest, highest = _DEFAULTS_BY_TYPE[type_name]
        if choices:
            entries = [
                {"name": key, "type": type_name, "value": value, "description": ""} for key, value in choices.items()
            ]
            edit_method = repr({"enum": entries, "enum_description": description})
        parameter = {
            "name": name,
            "type": type_name,
            "default": check_type(name, type_name, "default", default_of_type if default is None else default),
            "level": level,
            "description": description,
            "min": check_type(name, type_name, "min", lowest if minimum is None else minimum),
            "max": check_type(name, type_name, "max", highest if maximum is None else maximum),
            "edit_method": edit_method,
        }
        self.parameters.append(parameter)
        return parameter

    def all_groups(self) -> Iterator[Group]:
        """Yield this group and all groups below it."""
        yield self
        for group in self.groups:
            yield from group.all_groups()

    def as_dict(self) -> dict[str, Any]:
        """Return the group as a description; see `pyros1.reconfigure.encoding`."""
        return {
            "name": self.name,
            "type": self.type,
            "state": self.state,
            "id": self.id,
            "parent": self.parent.id if self.parent is not None else 0,
            "parameters": self.parameters,
            "groups": [group.as_dict() for group in self.groups],
        }


class Parameters(Group):
    """The parameters that other nodes can change while a node is running.

    The object has the same attributes as the modules generated from the ``.cfg`` files of ROS packages:
    ``config_description``, ``min``, ``max``, ``defaults`` and ``level`` by parameter, and ``all_level``.
    """

    def __init__(self) -> None:
        super().__init__("Default")
        self._last_id = 0

    def group(self, name: str, type: str = "", state: bool = True, parent: Group | None = None) -> Group:
        """Add a group of parameters. Return the group.

        Args:
            name: the name that tools display.
            type: how tools display the group: "", "collapse", "tab", "hide" or "apply".
            state: whether the group is on initially.
            parent: the parent group; None for the outermost one.
        """
        parent_group = self if parent is None else parent
        self._last_id += 1
        parent_group.groups.append(Group(name, type, state, parent_group, self._last_id))
        return parent_group.groups[-1]

    @property
    def config_description(self) -> dict[str, Any]:
        """All groups and parameters; see `pyros1.reconfigure.encoding`."""
        return self.as_dict()

    def _field_of_each_parameter(self, field: str) -> dict[str, Any]:
        return {parameter["name"]: parameter[field] for group in self.all_groups() for parameter in group.parameters}

    @property
    def defaults(self) -> dict[str, Any]:
        """The default values by parameter."""
        return self._field_of_each_parameter("default")

    @property
    def min(self) -> dict[str, Any]:
        """The minimums by parameter."""
        return self._field_of_each_parameter("min")

    @property
    def max(self) -> dict[str, Any]:
        """The maximums by parameter."""
        return self._field_of_each_parameter("max")

    @property
    def level(self) -> dict[str, int]:
        """The level bits by parameter."""
        return self._field_of_each_parameter("level")

    @property
    def all_level(self) -> int:
        """The level bits of all parameters."""
        bits = 0
        for level in self.level.values():
            bits |= level
        return bits


def check_type(name: str, type_name: str, field: str, value: Any) -> Any:
    """Check and return the value of a parameter or constant. Integers for a double are converted to floats.

    Raises:
        TypeError: the value has a different type.
    """
    python_type = _DEFAULTS_BY_TYPE[type_name][0]
    is_instance = isinstance(value, (int, float) if python_type is float else python_type)
    if not is_instance or (python_type is not bool and isinstance(value, bool)):
        raise TypeError(f"'{name}' has type {type_name}, but {field} is {value!r}")
    return python_type(value)
