"""Sets parameters leaf by leaf, so that a dictionary is merged with existing parameters (L80)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.shared.integers import INT_RANGE
from pyros1.ground.errors import MasterError, MasterUnreachableError, ParameterNotSetError


def set_leaves(invocation: Invocation, name: str, value: Any, message_format: str = "") -> None:
    """Set a parameter, or each leaf of a dictionary as a parameter.

    An empty dictionary is set only if no namespace has that name. The stock tool ignores empty dictionaries.

    Args:
        invocation: the command's invocation.
        name: the full name of the parameter.
        value: the value, which may be a dictionary.
        message_format: the format of the message to print after each leaf is set, with placeholders for the leaf's name
            and value; empty to print nothing.

    Raises:
        CommandError: parameters cannot have this value, or the master rejects it.
    """
    _check_value(value)
    for leaf, item in leaves(name, value):
        if item is None:
            raise CommandError(f"Parameter [{leaf}] cannot be set to null")
        try:
            if item == {} and _is_namespace(invocation, leaf):
                continue  # the parameters in the namespace are kept
            invocation.master.set_param(leaf, item)
        except MasterUnreachableError:
            raise
        except MasterError as error:
            raise CommandError(str(error)) from None
        if message_format:
            print(message_format.format(leaf, item))


def leaves(name: str, value: Any) -> list[tuple[str, Any]]:
    """Return (full name, value) for each leaf of a value. An empty dictionary is a leaf."""
    if not isinstance(value, dict) or not value:
        return [(name, value)]
    prefix = name.rstrip("/")
    return [leaf for key, item in value.items() for leaf in leaves(f"{prefix}/{key}", item)]


def _is_namespace(invocation: Invocation, name: str) -> bool:
    try:
        return isinstance(invocation.master.get_param(name), dict)
    except ParameterNotSetError:
        return False


def _check_value(value: Any) -> None:
    """Raise CommandError if a parameter cannot have this value."""
    if isinstance(value, dict):
        if any(not isinstance(key, str) for key in value):
            raise CommandError(f"YAML dictionaries must have string keys. Invalid dictionary is:\n{value}")
        for item in value.values():
            _check_value(item)
    elif isinstance(value, (list, tuple)):
        for item in value:
            _check_value(item)
    elif isinstance(value, int) and value not in INT_RANGE:
        raise CommandError(f"the integer {value} does not fit into the 32 bits of an integer parameter")
