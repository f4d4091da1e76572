"""Names in the graph (https://wiki.ros.org/Names)."""

from __future__ import annotations

import os
import random
import re
import socket
import sys
from collections.abc import Mapping
from typing import Any

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground import names
from pyros1.ground.names import canonicalize_name, ns_join
from rosgraph.rosenv import ROS_NAMESPACE

SEP = GLOBALNS = "/"
PRIV_NAME = "~"
REMAP = ":="
ANYTYPE = "*"
MSG_EXT, SRV_EXT = ".msg", ".srv"
NAME_LEGAL_CHARS_P = re.compile(r"^[\~\/A-Za-z][\w\/]*$")
BASE_NAME_LEGAL_CHARS_P = re.compile(r"^[A-Za-z][\w]*$")
REMAP_PATTERN = re.compile(r"^([\~\/A-Za-z]|_|__)[\w\/]*" + REMAP + ".*")

__getattr__ = module_getattr(__name__)


def isstring(s: object) -> bool:
    """Return whether a value is a str."""
    return isinstance(s, str)


def is_global(name: str) -> bool:
    """Return whether a name is global: ``/a``; like stock, return an empty name unchanged."""
    return name and name[0] == SEP  # type: ignore[return-value]


def is_private(name: str) -> bool:
    """Return whether a name is private: ``~a``; like stock, return an empty name unchanged."""
    return name and name[0] == PRIV_NAME  # type: ignore[return-value]


def is_legal_name(name: Any) -> bool:
    """Return whether a name is legal in the graph; the empty name is legal."""
    return name is not None and names.is_legal_name(name)


def is_legal_base_name(name: Any) -> bool:
    """Return whether a name without a namespace is legal."""
    return name is not None and names.is_legal_base_name(name)


def is_legal_remap(arg: Any) -> bool:
    """Return whether a command-line argument is a remapping."""
    return arg is not None and REMAP_PATTERN.match(arg) is not None


def namespace(name: Any) -> str:
    """Return the namespace of a name, with a trailing slash.

    Raises:
        ValueError: ``name`` is None.
        TypeError: ``name`` is not a string.
    """
    if name is None:
        raise ValueError("name")
    if not isinstance(name, str):
        raise TypeError("name")
    if not name:
        return SEP
    name = name.removesuffix(SEP)
    return name[: name.rfind(SEP) + 1] or SEP


def make_global_ns(name: str) -> str:
    """Return a name as a full namespace, with a trailing slash; raises ValueError for private names."""
    if is_private(name):
        raise ValueError(f"cannot turn [{name}] into a global name")
    if not is_global(name):
        name = SEP + name
    return name if name[-1] == SEP else name + SEP


def get_ros_namespace(env: Mapping[str, str] | None = None, argv: list[str] | None = None) -> str:
    """Return the namespace that the command line or the environment sets, with a trailing slash."""
    for word in sys.argv if argv is None else argv:
        if word.startswith("__ns:="):
            return make_global_ns(word.partition(":=")[2])
    return make_global_ns((os.environ if env is None else env).get(ROS_NAMESPACE, GLOBALNS))


def resolve_name(name: str, namespace_: str, remappings: Mapping[str, str] | None = None) -> str:
    """Return the full name that a name stands for in a node.

    Args:
        name: the name.
        namespace_: the node's name.
        remappings: full name -> full name.
    """
    if not name:
        return namespace(namespace_)
    name = str(name)
    if is_private(name):
        full_name = canonicalize_name(namespace_ + SEP + name[1:])
    elif is_global(name):
        full_name = canonicalize_name(name)
    else:
        full_name = canonicalize_name(namespace(namespace_) + name)
    return full_name if not remappings else remappings.get(full_name, full_name)


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
    """Return the full name of a script, with a trailing slash."""
    return make_global_ns(ns_join(get_ros_namespace(), name))


def anonymous_name(id: str) -> str:
    """Return a unique name that starts with ``id``."""
    name = f"{id}_{socket.gethostname()}_{os.getpid()}_{random.randint(0, sys.maxsize)}"
    return name.translate({ord(char): "_" for char in ".-:"})


def load_mappings(argv: list[str]) -> dict[str, str]:
    """Return the remappings of a command line: names, and special keys such as ``__name``."""
    mappings = {}
    for word in argv:
        key, _, value = word.partition(REMAP)
        value = value.strip()
        if is_legal_remap(word) and value and REMAP not in value and (key[0] != "_" or key[1:2] in ("", "_")):
            mappings[key] = value
    return mappings
