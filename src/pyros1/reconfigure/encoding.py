"""Converts dynamic_reconfigure's descriptions and configurations between messages and plain dictionaries.

A description is a group: a dictionary with ``name``, ``type``, ``state`` (whether it is on), ``id``, ``parent`` (an
id), ``parameters`` and ``groups`` (both lists); a parameter has ``name``, ``type``, ``default``, ``min``, ``max``,
``level``, ``description`` and ``edit_method``. When decoded from messages, ``groups`` is a dictionary by name.

This module has no side effects. Trees are traversed without recursion, since they come from other nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from pyros1.msgs.dynamic_reconfigure.msg import (
    BoolParameter,
    ConfigDescription,
    DoubleParameter,
    Group,
    GroupState,
    IntParameter,
    ParamDescription,
    StrParameter,
)
from pyros1.msgs.dynamic_reconfigure.msg import Config as ConfigMessage
from pyros1.reconfigure.config import Config
from pyros1.reconfigure.values import FIELD_NAMES, INT_RANGE, TYPE_CONVERTERS

_MESSAGE_CLASSES = {"bool": BoolParameter, "int": IntParameter, "str": StrParameter, "double": DoubleParameter}
_TYPE_NAMES = ((bool, "bool"), (int, "int"), (str, "str"), (float, "double"))

Make = Callable[..., Any]
"""A function that creates a dictionary from the same arguments as ``dict``, such as the class `Config`."""


def groups_of(root: Mapping[str, Any]) -> Iterator[Any]:
    """Yield a group and all groups below it, parents first."""
    pending = [root]
    while pending:
        group = pending.pop()
        yield group
        children = group["groups"]
        pending.extend(reversed(list(children.values() if isinstance(children, Mapping) else children)))


def parameters_of(root: Mapping[str, Any]) -> list[Any]:
    """Return the parameters of a group and of all groups below it."""
    return [parameter for group in groups_of(root) for parameter in group["parameters"]]


# To messages ----------------------------------------------------------------------------------------------------------


def encode_description(
    root: Mapping[str, Any], maximum: Mapping[str, Any], minimum: Mapping[str, Any], defaults: Mapping[str, Any]
) -> Any:
    """Return a description as a dynamic_reconfigure/ConfigDescription.

    Args:
        root: the description.
        maximum, minimum, defaults: values by parameter.
    """
    types = {parameter["name"]: parameter["type"] for parameter in parameters_of(root)}
    return ConfigDescription(
        groups=[encode_group(group) for group in groups_of(root)],
        max=encode(maximum, types),
        min=encode(minimum, types),
        dflt=encode(defaults, types),
    )


def encode_group(group: Mapping[str, Any]) -> Any:
    """Return one group of a description as a dynamic_reconfigure/Group."""
    fields = ("name", "type", "level", "description", "edit_method")
    parameters = [ParamDescription(*(parameter[field] for field in fields)) for parameter in group["parameters"]]
    return Group(group["name"], group["type"], parameters, group["parent"], group["id"])


def encode(config: Mapping[str, Any], types: Mapping[str, str] | None = None) -> Any:
    """Return a configuration as a dynamic_reconfigure/Config. Values of types that the message cannot contain are left
    out.

    Args:
        config: values by parameter. The key ``groups`` contains a tree of groups.
        types: "bool", "int", "str" or "double" by parameter; None to use the types of the values.

    Raises:
        ValueError: an integer has more than 32 bits.
    """
    message = ConfigMessage()
    for name, value in config.items():
        if name == "groups":
            message.groups = [
                GroupState(group["name"], group["state"], group["id"], group["parent"]) for group in groups_of(value)
            ]
            continue
        type_name = (types or {}).get(name) or next(
            (type_name for cls, type_name in _TYPE_NAMES if isinstance(value, cls)), None
        )
        if type_name is not None:
            value = TYPE_CONVERTERS[type_name](value)  # noqa: PLW2901
            if type_name == "int" and value not in INT_RANGE:
                raise ValueError(f"parameter '{name}': {value} does not fit into 32 bits")
            getattr(message, FIELD_NAMES[type_name]).append(_MESSAGE_CLASSES[type_name](name, value))
    return message


# From messages --------------------------------------------------------------------------------------------------------


def decode(message: Any, make: Make = Config) -> Any:
    """Return the values in a dynamic_reconfigure/Config, without its groups."""
    values = make()
    for field in FIELD_NAMES.values():
        for parameter in getattr(message, field):
            values[parameter.name] = parameter.value
    return values


def build_tree(groups: Iterable[Any], make: Make = Config, parameters: Callable[[Any], Any] | None = None) -> Any:
    """Return the tree of the groups that messages describe; None if there is no group 0, which is the root.

    Args:
        groups: dynamic_reconfigure/Group or GroupState messages.
        make: called like ``dict`` to create each dictionary.
        parameters: called with each group; returns the value for its key ``parameters``. If this argument is None, the
            value is an empty dictionary.
    """
    nodes: dict[int, Any] = {}
    for group in groups:
        nodes[group.id] = node = make()
        node.update(
            id=group.id,
            parent=group.parent,
            name=group.name,
            type=getattr(group, "type", ""),
            state=getattr(group, "state", True),
            groups=make(),
            parameters=make() if parameters is None else parameters(group),
        )
    for node in nodes.values():
        if node["id"] != 0 and node["parent"] in nodes:
            nodes[node["parent"]]["groups"][node["name"]] = node
    return nodes.get(0)


def decode_description(message: Any, make: Make = Config) -> Any:
    """Return a dynamic_reconfigure/ConfigDescription as a tree of groups, with the parameters of each group as a list
    of dictionaries.

    Return None if there is no group 0.
    """
    limits = {key: decode(getattr(message, key), dict) for key in ("min", "max", "dflt")}

    def parameters(group: Any) -> list[dict[str, Any]]:
        return [
            {
                "name": parameter.name,
                "min": limits["min"].get(parameter.name),
                "max": limits["max"].get(parameter.name),
                "default": limits["dflt"].get(parameter.name),
                "type": parameter.type,
                "level": parameter.level,
                "description": parameter.description,
                "edit_method": parameter.edit_method,
            }
            for parameter in group.parameters
        ]

    return build_tree(message.groups, make, parameters)


def with_groups(
    values: Any, states: Iterable[Any], names_by_group_id: Mapping[int, Iterable[str]], make: Make = Config
) -> Any:
    """Add the tree of groups to a configuration under ``groups``, with the parameters' values in each group. Return the
    configuration.

    Args:
        values: values by parameter.
        states: dynamic_reconfigure/GroupState messages. If there is no group 0, there is no tree.
        names_by_group_id: the names of the parameters in each group, by the id of the group.
        make: called like ``dict`` to create each dictionary.
    """
    root = build_tree(states, make)
    if root is None:
        return values
    for group in groups_of(root):
        group.update({name: values[name] for name in names_by_group_id.get(group["id"], ()) if name in values})
    values["groups"] = root
    return values


def decode_configuration(config: Any, description: Any) -> Any:
    """Return the values of all parameters, and the tree of their groups under ``groups``.

    Args:
        config: a dynamic_reconfigure/Config.
        description: the dynamic_reconfigure/ConfigDescription of the same node.
    """
    names_by_group_id = {group.id: [parameter.name for parameter in group.parameters] for group in description.groups}
    return with_groups(decode(config, dict), config.groups, names_by_group_id, dict)


def initial_config(values: Any, root: Mapping[str, Any], make: Make = Config) -> Any:
    """Add the tree of groups, in the states given by a description, to a configuration. Return the configuration.

    Args:
        values: values by parameter.
        root: the description.
        make: called like ``dict`` to create each dictionary.
    """
    nodes: dict[int, Any] = {}
    for group in groups_of(root):
        nodes[group["id"]] = node = make()
        names = [parameter["name"] for parameter in group["parameters"]]
        node.update({key: group[key] for key in ("id", "parent", "name")}, type="", state=group["state"])
        node.update(groups=make(), parameters=make({name: values[name] for name in names if name in values}))
        if group["id"] != 0:
            nodes[group["parent"]]["groups"][group["name"]] = node
    values["groups"] = nodes[0]
    return values
