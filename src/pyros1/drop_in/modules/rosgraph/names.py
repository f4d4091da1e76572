"""Names of the graph (https://wiki.ros.org/Names)."""

from __future__ import annotations

import os
import random
import socket
import sys

from pyros1.ground import names
from pyros1.ground.names import canonicalize_name, is_global, is_legal_base_name, is_legal_name, is_private, ns_join
from rosgraph.rosenv import ROS_NAMESPACE

SEP = GLOBALNS = "/"
PRIV_NAME = "~"
REMAP = ":="
ANYTYPE = "*"
MSG_EXT, SRV_EXT = ".msg", ".srv"

__all__ = [
    "canonicalize_name",
    "is_global",
    "is_legal_base_name",
    "is_legal_name",
    "is_private",
    "ns_join",
]


def namespace(name: str) -> str:
    """Return the namespace of a name, with a slash at its end."""
    if name is None:
        raise ValueError("name")
    if not isinstance(name, str):
        raise TypeError("name")
    if not name:
        return SEP
    name = name[:-1] if name[-1] == SEP else name
    return name[: name.rfind(SEP) + 1] or SEP


def make_global_ns(name: str) -> str:
    """Return a name as a full namespace."""
    if is_private(name):
        raise ValueError(f"cannot turn [{name}] into a global name")
    return canonicalize_name(f"/{name}/").rstrip("/") + "/"


def get_ros_namespace(env: dict[str, str] | None = None, argv: list[str] | None = None) -> str:
    """Return the namespace of the command line or the environment."""
    special = names.parse_arguments(list(sys.argv if argv is None else argv)).special
    return make_global_ns(special.get("__ns") or (os.environ if env is None else env).get(ROS_NAMESPACE, "/"))


def resolve_name(name: str, namespace_: str, remappings: dict[str, str] | None = None) -> str:
    """Return the full name that a name stands for in a node."""
    if not name:
        return namespace(namespace_)
    full = names.resolve_name(str(name), namespace_)
    return (remappings or {}).get(full, full)


def script_resolve_name(script_name: str, name: str) -> str:
    """Return the full name that a name stands for in a script."""
    if not name:
        return get_ros_namespace()
    if is_global(name):
        return name
    if is_private(name):
        return ns_join(make_caller_id(script_name), name[1:])
    return get_ros_namespace() + name


def make_caller_id(name: str) -> str:
    """Return the full name of a script."""
    return make_global_ns(ns_join(get_ros_namespace(), name))[:-1]


def anonymous_name(id: str) -> str:
    """Return a name that nobody else has."""
    return f"{id}_{socket.gethostname()}_{os.getpid()}_{random.randint(0, sys.maxsize)}".translate(
        {ord(c): "_" for c in ".-:"}
    )


def load_mappings(argv: list[str]) -> dict[str, str]:
    """Return the name remappings of a command line."""
    return dict(names.parse_arguments(argv).remappings)
