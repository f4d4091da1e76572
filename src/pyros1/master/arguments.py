"""Validates the arguments of the master's methods, and resolves names; the error messages are the stock master's.

The checks are as lenient as stock's (M09, M10): any name that the stock master accepts must be accepted here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.names import SEP, canonicalize_name, namespace

Validator = Callable[[Any, str], Any]
"""``validator(argument, caller_id)`` returns the value to use, or raises Refused."""


class Refused(Error):
    """A call is refused; the response has a code other than 1.

    Args:
        message: the message to return.
        code: -1 for an error by the caller, or 0.
        value: the value to return; None for the method's default.
    """

    def __init__(self, message: str, code: int = -1, value: Any = None) -> None:
        self.message = message
        self.code = code
        self.value = value
        super().__init__(message)


def resolve(name: str, caller_id: str) -> str:
    """Return the global name for a name used by a node; any characters are accepted (M08)."""
    if not name:
        return namespace(caller_id)
    if name[0] == SEP:  # true for nearly all names
        return canonicalize_name(name) if name[-1] == SEP or "//" in name else name
    if name[0] == "~":
        return canonicalize_name(caller_id + SEP + name[1:])
    return canonicalize_name(namespace(caller_id) + name)


def _resolve_name(parameter: str, value: Any, caller_id: str) -> str:
    if not isinstance(value, str) or not value:
        raise Refused(f"ERROR: parameter [{parameter}] must be a non-empty string")
    if ":" in value or " " in value:
        raise Refused(f"ERROR: parameter [{parameter}] contains illegal chars")
    return resolve(value, caller_id)


def validate_node_name(value: Any, caller_id: str) -> str:
    """Validate and resolve the name of a node; return the full name."""
    return _resolve_name("node", value, caller_id)


def make_name_validator(parameter: str) -> Validator:
    """Return a validator for the name of a topic or service, which must not be ``/``."""

    def check(value: Any, caller_id: str) -> str:
        name = _resolve_name(parameter, value, caller_id)
        if name == SEP:
            raise Refused(f"ERROR: parameter [{parameter}] cannot be the global namespace")
        return name

    return check


def validate_topic_type(value: Any, caller_id: str) -> str:
    """Validate a topic's type, ``*`` or ``package/Type``, and return it."""
    if not isinstance(value, str) or not value:
        raise Refused("ERROR: parameter [topic_type] must be a non-empty string")
    if value != "*" and value.count(SEP) != 1:
        raise Refused("ERROR: parameter [topic_type] is not a valid package resource name")
    return value


def make_api_validator(parameter: str) -> Validator:
    """Return a validator for an ``http://`` or ``rosrpc://`` URI."""

    def check(value: Any, caller_id: str) -> str:
        if not isinstance(value, str) or not value:
            raise Refused(f"ERROR: parameter [{parameter}] is not an XMLRPC URI")
        if not value.startswith(("http://", "rosrpc://")):
            raise Refused(f"ERROR: parameter [{parameter}] is not an RPC URI")
        return value

    return check


def validate_raw_key(value: Any, caller_id: str) -> str:
    """Validate a parameter's key and return it unresolved."""
    if not value:
        raise Refused("ERROR: parameter [key] must be specified and non-empty")
    if not isinstance(value, str):
        raise Refused("ERROR: parameter [key] must be a string")
    return value


def validate_key(value: Any, caller_id: str) -> str:
    """Validate and resolve a parameter's key; return the full key (M51)."""
    return resolve(validate_raw_key(value, caller_id), caller_id)


def validate_parameter_value(value: Any, caller_id: str) -> Any:
    """Validate the value of a parameter, which must not be null, and return it."""
    if value is None:
        raise Refused("ERROR: parameter [value] must be specified")
    return value


def validate_subgraph(value: Any, caller_id: str) -> str:
    """Validate a namespace; return its full name, or an empty string, which means all namespaces."""
    if not isinstance(value, str):
        raise Refused("ERROR: parameter [subgraph] must be a string")
    return resolve(value, caller_id) if value else ""


def accept_any(value: Any, caller_id: str) -> Any:
    """Return an argument without validating it."""
    return value
