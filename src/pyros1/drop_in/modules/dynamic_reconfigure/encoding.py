"""Converts configurations and their descriptions to messages, and back."""

from __future__ import annotations

from typing import Any

import pyros1.reconfigure.config
from pyros1.msgs.dynamic_reconfigure.msg import (
    BoolParameter,
    DoubleParameter,
    GroupState,
    IntParameter,
    ParamDescription,
    StrParameter,
)
from pyros1.msgs.dynamic_reconfigure.msg import Config as ConfigMsg
from pyros1.msgs.dynamic_reconfigure.msg import ConfigDescription as ConfigDescrMsg
from pyros1.msgs.dynamic_reconfigure.msg import Group as GroupMsg
from pyros1.reconfigure import encoding as _encoding


class Config(pyros1.reconfigure.config.Config):
    """Values of parameters by name, also as attributes."""

    def __getstate__(self) -> list[Any]:
        return []

    def __setstate__(self, items: Any) -> None:
        """Do nothing: all values are in the dictionary."""


def encode_description(descr: Any) -> Any:
    """Convert the description in a module created from a ``.cfg`` file to a message."""
    return _encoding.encode_description(descr.config_description, descr.max, descr.min, descr.defaults)


def encode_groups(parent: Any, group: Any) -> list[Any]:
    """Convert a group and all groups below it to messages."""
    return [_encoding.encode_group(subgroup) for subgroup in _encoding.groups_of(group)]


def encode_config(config: Any, flat: bool = True) -> Any:
    """Convert a configuration to a message.

    Args:
        config: parameter -> value; ``groups`` is a tree of groups, or with ``flat=False`` a list of groups.
        flat: whether ``groups`` is a tree, which is flattened for the message.
    """
    if flat or "groups" not in config:
        return _encoding.encode(config)
    message = _encoding.encode({name: config[name] for name in config if name != "groups"})
    message.groups = [
        GroupState(group["name"], group["state"], group["id"], group["parent"]) for group in config["groups"]
    ]
    return message


def group_dict(group: Any) -> Config:
    """Convert a group in a message to a dictionary, without its parameters and the groups below it."""
    fields = {"id": group.id, "parent": group.parent, "name": group.name, "type": getattr(group, "type", "")}
    return Config(fields, state=getattr(group, "state", True), groups=Config(), parameters=Config())


def decode_description(msg: Any) -> Any:
    """Convert a ConfigDescription to a tree of groups, whose parameters are a list of dictionaries."""
    return _encoding.decode_description(msg, Config)


def get_tree(m: Any, group: Any = None) -> Any:
    """Return the tree of the groups in a Config or ConfigDescription, or the tree of the groups below ``group``."""
    root = _encoding.build_tree(m.groups, Config)
    if group is None:
        return root
    return next(
        (tree_group["groups"] for tree_group in _encoding.groups_of(root) if tree_group["id"] == group.id), Config()
    )


def initial_config(msg: Any, description: Any = None) -> Any:
    """Return the values in a Config.

    Args:
        msg: the Config.
        description: a description from a ``.cfg`` file. If ``msg`` has groups, the result includes the groups of the
            description, in the states that the description gives. None to leave out the groups.
    """
    values = _encoding.decode(msg, Config)
    if description is None or not any(group.id == 0 for group in msg.groups):
        return values
    return _encoding.initial_config(values, description, Config)


def decode_config(msg: Any, description: Any = None) -> Any:
    """Return the values in a Config and, if a description from `decode_description` is given, the groups."""
    values = _encoding.decode(msg, Config)
    if description is None:
        return values
    groups = _encoding.groups_of(description)
    names_by_group_id = {group["id"]: [parameter["name"] for parameter in group["parameters"]] for group in groups}
    return _encoding.with_groups(values, msg.groups, names_by_group_id, Config)


def extract_params(group: Any) -> list[Any]:
    """Return the parameters of a group and of all groups below it."""
    return _encoding.parameters_of(group)


def get_parents(group: Any, descriptions: Any) -> list[Any]:
    """Return the groups above a group, from the top.

    Args:
        group: a dictionary with the numbers ``id`` and ``parent``; the top is its own parent, or has none in the list.
        descriptions: a dictionary with the list ``group`` of all groups.
    """
    groups_by_id = {described_group["id"]: described_group for described_group in reversed(descriptions["group"])}
    parents: list[Any] = []
    while group["parent"] in groups_by_id and group["parent"] != group["id"] and len(parents) < len(groups_by_id):
        group = groups_by_id[group["parent"]]
        parents.insert(0, group)
    return parents


def __getattr__(name: str) -> Any:
    raise AttributeError(f"pyros1 has no dynamic_reconfigure.encoding.{name}")
