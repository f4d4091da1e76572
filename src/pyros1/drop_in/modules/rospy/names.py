"""Names, and the node's own (https://wiki.ros.org/Names)."""

from __future__ import annotations

import os
import sys
from typing import Any

from pyros1.drop_in.process import PROCESS
from pyros1.ground import names

SEP = GLOBALNS = "/"
REMAP = ":="
ANYTYPE = TOPIC_ANYTYPE = SERVICE_ANYTYPE = "*"

canonicalize_name = names.canonicalize_name
is_global = names.is_global
is_private = names.is_private
ns_join = names.ns_join


def namespace(name: str) -> str:
    """Return the namespace of a name, with a slash at its end."""
    if name is None:
        raise ValueError("name")
    if not isinstance(name, str):
        raise TypeError("name")
    if not name:
        return SEP
    name = name[:-1] if name[-1] == "/" else name
    return name[: name.rfind(SEP) + 1] or SEP


def get_caller_id() -> str:
    """Return the node's full name; ``/unnamed`` before there is a node."""
    return PROCESS.node.name if PROCESS.node is not None else get_namespace() + "unnamed"


get_name = get_caller_id


def get_namespace() -> str:
    """Return the node's namespace, with a slash at its end."""
    if PROCESS.node is not None:
        return namespace(PROCESS.node.name)
    given = names.parse_arguments(list(sys.argv[1:])).special.get("__ns") or os.environ.get("ROS_NAMESPACE", "")
    return names.canonicalize_name(f"/{given}/").rstrip("/") + "/"


def get_mappings() -> dict[str, str]:
    """Return the name remappings of the command line, as they were given."""
    return dict(names.parse_arguments(list(sys.argv[1:])).remappings)


def get_resolved_mappings() -> dict[str, str]:
    """Return the name remappings of the command line, with full names."""
    return names.parse_arguments(list(sys.argv[1:])).resolved_remappings(get_caller_id())


def resolve_name(name: str, caller_id: str | None = None) -> str:
    """Return the full name that a name stands for in a node, remappings applied.

    Args:
        name: any name.
        caller_id: full name of the node; None: the program's own.
    """
    if not name:
        return namespace(caller_id or get_caller_id())
    full = names.resolve_name(str(name), caller_id or get_caller_id())
    return get_resolved_mappings().get(full, full)


def remap_name(name: str, caller_id: str | None = None, resolved: bool = True) -> str:
    """Return what a name is remapped to, or the name itself.

    Args:
        resolved: compare full names.
    """
    caller = caller_id or get_caller_id()
    if not resolved:
        return get_mappings().get(name, name)
    full = names.resolve_name(name, caller)
    return get_resolved_mappings().get(full, name)


def scoped_name(caller_id: str, name: str) -> str:
    """Return a name relative to a node's namespace, if it is in there."""
    if not is_global(caller_id):
        raise Exception("caller_id must be global")
    if not is_global(name):
        raise Exception("name must be global")
    scope = namespace(caller_id)
    return name[len(scope) :] if name.startswith(scope) and name != scope else name


def valid_name(param_name: str, empty_allowed: bool = False) -> Any:
    """Return a validator of names, as rospy's functions use it."""

    def validator(value: Any, caller_id: str) -> Any:
        if not value and empty_allowed:
            return value
        if not isinstance(value, str) or not value:
            raise ValueError(f"ERROR: parameter [{param_name}] must be a non-empty string")
        return resolve_name(value, caller_id)

    return validator
