"""Validates, resolves and remaps graph resource names, and parses command-line arguments with remappings.

Implements https://wiki.ros.org/Names and https://wiki.ros.org/Remapping%20Arguments. The functions use only their
arguments: they read neither the environment nor the command line.
"""

from __future__ import annotations

import re

from pyros1.ground.errors import InvalidNameError

SEP = "/"

_GRAPH_NAME = re.compile(r"[~/A-Za-z][\w/]*\Z", re.ASCII)
_BASE_NAME = re.compile(r"[A-Za-z]\w*\Z", re.ASCII)
_REMAPPING = re.compile(r"([~/A-Za-z]|_|__)[\w/]*:=", re.ASCII)


def canonicalize_name(name: str) -> str:
    """Return a name without repeated or trailing separators; ``/`` stays ``/``."""
    if not name or name == SEP:
        return name
    joined = SEP.join(part for part in name.split(SEP) if part)
    return SEP + joined if name[0] == SEP else joined


def is_legal_name(name: str) -> bool:
    """Return whether ``name`` is a legal graph name: relative, global or private. The empty name is legal."""
    return not name or (_GRAPH_NAME.match(name) is not None and "//" not in name)


def is_legal_base_name(name: str) -> bool:
    """Return whether ``name`` is a legal name without namespace, as a node's name must be."""
    return _BASE_NAME.match(name) is not None


def is_global(name: str) -> bool:
    """Return whether ``name`` is global: ``/a``."""
    return name.startswith(SEP)


def is_private(name: str) -> bool:
    """Return whether ``name`` is private, that is, below the node's own name: ``~a``."""
    return name.startswith("~")


def namespace(name: str) -> str:
    """Return the namespace of ``name`` with a trailing separator: ``/a/b`` gives ``/a/``, ``/a`` gives ``/``."""
    if not name:
        return SEP
    if name[-1] == SEP:
        name = name[:-1]
    return name[: name.rfind(SEP) + 1] or SEP


def ns_join(ns: str, name: str) -> str:
    """Return ``name`` below the namespace ``ns``; a global or private ``name`` is returned unchanged."""
    if is_private(name) or is_global(name):
        return name
    if ns == "~":
        return "~" + name
    if not ns:
        return name
    return ns + name if ns[-1] == SEP else ns + SEP + name


class FullName(str):
    """A full name that has already been resolved and remapped: `resolve_name` does not remap it again.

    With ``a:=b b:=c``, the name ``a`` resolves to ``/b``, however often it is resolved. A string derived from a
    FullName, such as ``f"{name}/goal"``, is an ordinary name.
    """

    __slots__ = ()


def resolve_name(name: str, node_name: str, remappings: dict[str, str] | None = None, strict: bool = True) -> str:
    """Resolve ``name`` to a global name, as a node does.

    Args:
        name: relative, global or private (``~x``); empty means the node's namespace. A `FullName` is not remapped.
        node_name: the node's full name, for example ``/robot/talker``.
        remappings: resolved name -> resolved name; applied once, with an exact match.
        strict: whether ``name`` must be legal.

    Raises:
        InvalidNameError: ``strict`` is true, and ``name`` is not legal.
    """
    if not name:
        return namespace(node_name)
    if strict and not is_legal_name(name):
        raise InvalidNameError(
            f"{name!r} is not a legal ROS name: a name starts with a letter, '/' or '~' and contains "
            "letters, digits, '_' and '/'"
        )
    if name[0] == "~":
        resolved = node_name + SEP + canonicalize_name(name[1:]).lstrip(SEP)
    elif name[0] == SEP:
        resolved = name
    else:
        resolved = namespace(node_name) + name
    resolved = canonicalize_name(resolved)
    if remappings and resolved in remappings and not isinstance(name, FullName):
        return remappings[resolved]
    return resolved


def anonymous_name(base: str, pid: int, millis: int) -> str:
    """Return ``base`` made unique with the process id and the time in milliseconds, as in rospy."""
    return f"{base}_{pid}_{millis}"


class Arguments:
    """The parsed arguments of a command line.

    Attributes:
        remappings: ``a:=b`` as ``{"a": "b"}``; the names are not resolved.
        parameters: ``_p:=v`` as ``{"p": "v"}``; the values are strings.
        special: ``__name:=x`` as ``{"__name": "x"}``.
        rest: the program's own arguments: all others, in order, like the result of rospy's ``myargv``.
        malformed: arguments that look like a remapping but have more than one ``:=``.
    """

    def __init__(self) -> None:
        self.remappings: dict[str, str] = {}
        self.parameters: dict[str, str] = {}
        self.special: dict[str, str] = {}
        self.rest: list[str] = []
        self.malformed: list[str] = []

    def resolved_remappings(self, node_name: str, strict: bool = True) -> dict[str, str]:
        """Return the remappings with both sides resolved for a node with the given full name.

        Raises:
            InvalidNameError: ``strict`` is true, and one of the names is not legal.
        """
        return {
            resolve_name(old, node_name, strict=strict): resolve_name(new, node_name, strict=strict)
            for old, new in self.remappings.items()
        }


def parse_arguments(argv: list[str]) -> Arguments:
    """Divide command-line arguments into remappings, private parameters, special keys and the rest.

    Args:
        argv: the arguments, without the program's name.
    """
    arguments = Arguments()
    for argument in argv:
        if not _REMAPPING.match(argument):
            arguments.rest.append(argument)
            continue
        key, _, value = argument.partition(":=")
        if ":=" in value:
            arguments.malformed.append(argument)
        elif key.startswith("__"):
            arguments.special[key] = value
        elif key.startswith("_"):
            arguments.parameters[key[1:]] = value
        else:
            arguments.remappings[key] = value
    return arguments
