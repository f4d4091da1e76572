"""Sets private parameters from the command line: ``_rate:=10`` sets ``~rate`` to the number 10 (N13: YAML rules, like
rospy).

The parameters remain on the master after the node has shut down, so they are still set if the node is later started
without these arguments.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.ground.names import Arguments
    from pyros1.net.master_client import MasterClient

# These patterns are compiled when needed, since most nodes do not need them.
_INT_PATTERN = r"[-+]?(0|[1-9][0-9]*)\Z"
_FLOAT_PATTERN = r"[-+]?[0-9]+\.[0-9]*\Z"
_WORD_PATTERN = r"(?a)[A-Za-z/_][\w/.-]*\Z"
_MAX_LISTED = 5
_YAML_KEYWORDS = {"true", "false", "yes", "no", "on", "off", "null", "y", "n"}


def parse_private_parameter(text: str) -> Any:
    """Parse a parameter's value and return it. Text that is not valid YAML is returned as a string."""
    plain_value = parse_plain_value(text)
    if plain_value is not None:
        return plain_value
    from pyros1.ground.errors import Error  # noqa: PLC0415 - as below
    from pyros1.values import load_yaml  # noqa: PLC0415 - takes 20 ms to import

    try:
        value = load_yaml(text)
    except Error:
        return text
    return "" if value is None else value


def parse_plain_value(text: str) -> int | float | str | None:
    """Return the value of a simple number or string; None for anything else, which requires a YAML parser."""
    if re.match(_INT_PATTERN, text):
        return int(text)
    if re.match(_FLOAT_PATTERN, text):
        return float(text)
    if re.match(_WORD_PATTERN, text) and text.lower() not in _YAML_KEYWORDS:
        return text
    return None


def argument_warnings(arguments: Arguments) -> list[str]:
    """Return a warning for each malformed remapping, and for each private parameter that looks misspelt, such as
    ``_rate=10``.
    """
    warnings = [f"invalid remapping argument {argument!r}: use name:=newname" for argument in arguments.malformed]
    suspects = [argument for argument in arguments.rest if argument.startswith("_")]
    if not suspects:
        return warnings
    from pyros1.ground.suggest import argument_hint  # noqa: PLC0415 - needed only for misspelt parameters

    return warnings + [hint for hint in map(argument_hint, suspects) if hint]


def set_private(
    master: MasterClient, resolve: Callable[[str], str], assignments: Mapping[str, str], timeout: float
) -> tuple[Any, Any]:
    """Set a node's private parameters, in one call.

    Args:
        master: the node's client of the master.
        resolve: resolves a name to a full name.
        assignments: name without ``~`` -> value as text.
        timeout: maximum number of seconds for the call.

    Returns:
        The values that the node needs at startup: /use_sim_time and a dict of all private parameters; an Error in place
        of each that is not set.
    """
    settings: list[tuple[str, tuple[Any, ...]]] = [
        ("setParam", (resolve("~" + key), parse_private_parameter(text))) for key, text in assignments.items()
    ]
    *_, use_sim_time, private_params = master.multicall(
        [*settings, ("getParam", ("/use_sim_time",)), ("getParam", (master.caller_id,))], timeout=timeout
    )
    return use_sim_time, private_params


def leftover_warning(node_name: str, private_params: Any, assignments: Mapping[str, str]) -> list[str]:
    """Return one line about private parameters that were already set before a node started; an empty list if none were.

    Args:
        node_name: the node's full name.
        private_params: the node's private parameters; not a dict if none are set.
        assignments: names of the parameters that the command line sets.
    """
    assigned_names = {name.strip("/") for name in assignments}
    leftovers = (
        [(name, value) for name, value in _leaves(private_params, "") if name not in assigned_names]
        if isinstance(private_params, dict)
        else []
    )
    if not leftovers:
        return []
    descriptions = [f"~{name} is {value!r:.40}" for name, value in leftovers[:_MAX_LISTED]]
    omitted = f" and {len(leftovers) - _MAX_LISTED} more" if len(leftovers) > _MAX_LISTED else ""
    # The hint does not suggest deleting the whole namespace: other nodes may have parameters in it.
    hint = f"to delete {'it' if len(leftovers) == 1 else 'one'}: pyros1 param delete {node_name}/{leftovers[0][0]}"
    return [f"already set before the node started: {', '.join(descriptions)}{omitted} ({hint})"]


def _leaves(tree: dict[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for name, value in tree.items():
        if isinstance(value, dict) and value:
            yield from _leaves(value, f"{prefix}{name}/")
        else:
            yield prefix + name, value
