"""Converts plain values to the requests of dynamic_reconfigure (L200). This module has no side effects."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.suggest import did_you_mean

TYPE_CONVERTERS: dict[str, Callable[[Any], Any]] = {"bool": bool, "int": int, "str": str, "double": float}
"""For each type name in descriptions, the function that converts a value to this type."""
INT_RANGE = range(-(2**31), 2**31)
"""The integers that fit into messages of dynamic_reconfigure."""
FIELD_NAMES = {"bool": "bools", "int": "ints", "str": "strs", "double": "doubles"}
"""For each type name, the name of the field in dynamic_reconfigure/Config."""
_BOOLEANS = {
    **dict.fromkeys(("yes", "true", "t", "on", "1"), True),
    **dict.fromkeys(("no", "false", "f", "off", "0"), False),
}


class ParameterError(Error):
    """A configuration cannot be changed as requested.

    Args:
        text: the error message.
        hint: a suggestion to append to the message, or an empty string.
    """

    def __init__(self, text: str, hint: str = "") -> None:
        self.hint = hint
        super().__init__(text)


def encode_changes(changes: Mapping[str, Any], description: Any, config: Any = None) -> dict[str, Any]:
    """Return the fields of a dynamic_reconfigure/Config that requests changes.

    Args:
        changes: values by parameter. The key ``groups`` contains states by group, or a tree of groups from
            `decode_configuration`. A string is converted to the parameter's type, or is the name of one of its choices.
        description: the dynamic_reconfigure/ConfigDescription of the node.
        config: the node's dynamic_reconfigure/Config with the states of all groups; needed only for ``groups``.

    Raises:
        ParameterError: a parameter or group does not exist, or cannot have the value.
    """
    parameters = {parameter.name: parameter for group in description.groups for parameter in group.parameters}
    fields: dict[str, list[dict[str, Any]]] = {}
    for name, value in changes.items():
        if name == "groups":
            fields.update(_groups_field(value, description, config))
            continue
        if name not in parameters:
            raise ParameterError(f"don't know parameter: {name}", did_you_mean(str(name), parameters))
        type_name = parameters[name].type
        entry = {"name": name, "value": convert_value(value, parameters[name])}
        fields.setdefault(FIELD_NAMES[type_name], []).append(entry)
    return fields


def convert_value(value: Any, parameter: Any) -> Any:
    """Return a value converted to the type of a parameter.

    Args:
        value: a plain value.
        parameter: a dynamic_reconfigure/ParamDescription.

    Raises:
        ParameterError: the value does not fit the type.
    """
    name, python_type = parameter.name, TYPE_CONVERTERS.get(parameter.type)
    if python_type is None:
        raise ParameterError(f"parameter '{name}' has an unknown type: {parameter.type}")
    if isinstance(value, str):
        named_choices = parse_choices(parameter.edit_method)
        choices_by_lower_name = {choice.lower(): chosen_value for choice, chosen_value in named_choices.items()}
        lower_value = value.lower()
        if lower_value in choices_by_lower_name:
            value = choices_by_lower_name[lower_value]
        elif python_type is bool:
            if lower_value not in _BOOLEANS:
                raise ParameterError(
                    f"can't set parameter '{name}' of {python_type}: {value!r} is neither true nor false"
                )
            value = _BOOLEANS[lower_value]
        elif named_choices and python_type is not str and not _is_number(value):
            problem = f"{value!r} is not one of {', '.join(named_choices)}"
            raise ParameterError(
                f"can't set parameter '{name}' of {python_type}: {problem}", did_you_mean(value, named_choices)
            )
    try:
        result = python_type(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"can't set parameter '{name}' of {python_type}: {error}") from None
    if python_type is int and result not in INT_RANGE:
        raise ParameterError(f"can't set parameter '{name}' of {python_type}: {result} does not fit into 32 bits")
    return result


def parse_choices(edit_method: str) -> dict[str, Any]:
    """Return the values of a parameter's choices by name; empty if `edit_method` contains no valid list of choices."""
    try:
        constants = ast.literal_eval(edit_method)["enum"]
        return {str(constant["name"]): TYPE_CONVERTERS[constant["type"]](constant["value"]) for constant in constants}
    except (SyntaxError, ValueError, TypeError, LookupError, MemoryError, RecursionError):
        return {}


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _groups_field(requested: Any, description: Any, config: Any) -> dict[str, list[dict[str, Any]]]:
    """Return a dictionary with the field ``groups``.

    The dictionary is empty if no state changes, since stock's Python server does not accept groups.
    """
    states = {group.id: group.state for group in config.groups} if config is not None else {}
    if not isinstance(requested, Mapping):
        raise ParameterError(f"groups must be a dictionary of names and states, not {requested!r}")
    states_by_name = _states_in_tree(requested) if "id" in requested and "groups" in requested else dict(requested)
    group_names = [group.name for group in description.groups]
    for name, state in states_by_name.items():
        if name not in group_names:
            raise ParameterError(f"don't know group: {name}", did_you_mean(str(name), group_names))
        if not isinstance(state, bool):
            raise ParameterError(f"the state of group {name} must be true or false, not {state!r}")
    new_states = {group.id: states_by_name.get(group.name, states.get(group.id, True)) for group in description.groups}
    if new_states == states:
        return {}
    fields = [
        {"name": group.name, "state": new_states[group.id], "id": group.id, "parent": group.parent}
        for group in description.groups
    ]
    return {"groups": fields}


def _states_in_tree(tree: Mapping[str, Any]) -> dict[str, Any]:
    """Return the states of the groups in a tree, by name."""
    states = {str(tree.get("name")): tree.get("state")}
    children = tree.get("groups")
    for child in children.values() if isinstance(children, Mapping) else ():
        if isinstance(child, Mapping):
            states.update(_states_in_tree(child))
    return states
