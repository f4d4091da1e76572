"""The arguments of the master's methods: resolved against the caller's name, and refused with stock's texts.

Checks are as weak as stock's (M09, M10): a name that a node could use there must be accepted here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.names import SEP, canonicalize_name, namespace

Validator = Callable[[Any, str], Any]
"""Takes an argument and the caller's id; returns the value to use, or raises Refused."""


class Refused(Error):
    """A call that is answered with a status other than 1.

    Args:
        message: the status text.
        code: -1, the caller's fault, or 0.
        value: the third item of the answer; None: the method's default.
    """

    def __init__(self, message: str, code: int = -1, value: Any = None) -> None:
        self.message = message
        self.code = code
        self.value = value
        super().__init__(message)


def resolve(name: str, caller_id: str) -> str:
    """Return the global form of a name that a node uses; accepts any characters (M08)."""
    if not name:
        return namespace(caller_id)
    if name[0] == SEP:  # true of nearly all names
        return canonicalize_name(name) if name[-1] == SEP or "//" in name else name
    if name[0] == "~":
        return canonicalize_name(caller_id + SEP + name[1:])
    return canonicalize_name(namespace(caller_id) + name)


def _name(parameter: str, value: Any, caller_id: str) -> str:
    if not isinstance(value, str) or not value:
        raise Refused(f"ERROR: parameter [{parameter}] must be a non-empty string")
    if ":" in value or " " in value:
        raise Refused(f"ERROR: parameter [{parameter}] contains illegal chars")
    return resolve(value, caller_id)


def node_name(value: Any, caller_id: str) -> str:
    """Return the full name of a node."""
    return _name("node", value, caller_id)


def name_of(parameter: str) -> Validator:
    """Return the full name of a topic or service; refuse the root."""

    def check(value: Any, caller_id: str) -> str:
        name = _name(parameter, value, caller_id)
        if name == SEP:
            raise Refused(f"ERROR: parameter [{parameter}] cannot be the global namespace")
        return name

    return check


def topic_type(value: Any, caller_id: str) -> str:
    """Return a topic's type: ``*`` or ``package/Type``."""
    if not isinstance(value, str) or not value:
        raise Refused("ERROR: parameter [topic_type] must be a non-empty string")
    if value != "*" and value.count(SEP) != 1:
        raise Refused("ERROR: parameter [topic_type] is not a valid package resource name")
    return value


def api_of(parameter: str) -> Validator:
    """Return an ``http://`` or ``rosrpc://`` URI."""

    def check(value: Any, caller_id: str) -> str:
        if not isinstance(value, str) or not value:
            raise Refused(f"ERROR: parameter [{parameter}] is not an XMLRPC URI")
        if not value.startswith(("http://", "rosrpc://")):
            raise Refused(f"ERROR: parameter [{parameter}] is not an RPC URI")
        return value

    return check


def raw_key(value: Any, caller_id: str) -> str:
    """Return a parameter's key as it was written."""
    if not value:
        raise Refused("ERROR: parameter [key] must be specified and non-empty")
    if not isinstance(value, str):
        raise Refused("ERROR: parameter [key] must be a string")
    return value


def key(value: Any, caller_id: str) -> str:
    """Return a parameter's key, resolved (M51)."""
    return resolve(raw_key(value, caller_id), caller_id)


def parameter_value(value: Any, caller_id: str) -> Any:
    """Return the value of a parameter: anything but null."""
    if value is None:
        raise Refused("ERROR: parameter [value] must be specified")
    return value


def subgraph(value: Any, caller_id: str) -> str:
    """Return a namespace; empty means everything."""
    if not isinstance(value, str):
        raise Refused("ERROR: parameter [subgraph] must be a string")
    return resolve(value, caller_id) if value else ""


def unchecked(value: Any, caller_id: str) -> Any:
    """Return the argument unchecked."""
    return value
