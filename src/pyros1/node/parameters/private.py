"""Private parameters on the command line: ``_rate:=10`` sets ``~rate`` to the number 10 (N13: YAML rules, as rospy).

They stay on the master when the node ends, so a later start without them finds them there.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.ground.names import Arguments
    from pyros1.net.master_client import MasterClient

# Compiled when needed: most nodes have none.
_INT = r"[-+]?(0|[1-9][0-9]*)\Z"
_FLOAT = r"[-+]?[0-9]+\.[0-9]*\Z"
_WORD = r"(?a)[A-Za-z/_][\w/.-]*\Z"
_MAX_SHOWN = 5
_KEYWORDS = {"true", "false", "yes", "no", "on", "off", "null", "y", "n"}


def private_parameter(text: str) -> Any:
    """Return the value of a parameter given as text. Text that is not YAML is a string."""
    plain = plain_value(text)
    if plain is not None:
        return plain
    from pyros1.ground.errors import Error  # noqa: PLC0415 - with the next
    from pyros1.values import load_yaml  # noqa: PLC0415 - takes 20 ms to load

    try:
        value = load_yaml(text)
    except Error:
        return text
    return "" if value is None else value


def plain_value(text: str) -> int | float | str | None:
    """Return the value of a plain number or word; None for anything else, which takes a YAML reader."""
    if re.match(_INT, text):
        return int(text)
    if re.match(_FLOAT, text):
        return float(text)
    if re.match(_WORD, text) and text.lower() not in _KEYWORDS:
        return text
    return None


def argument_warnings(arguments: Arguments) -> list[str]:
    """Return a warning for each malformed remapping, and for each apparent misspelt private parameter, such as
    ``_rate=10``."""
    malformed = [f"invalid remapping argument {word!r}: use name:=newname" for word in arguments.malformed]
    suspects = [word for word in arguments.rest if word.startswith("_")]
    if not suspects:
        return malformed
    from pyros1.ground.suggest import argument_hint  # noqa: PLC0415 - needed only for misspelt parameters

    return malformed + [hint for hint in map(argument_hint, suspects) if hint]


def set_private(
    master: MasterClient, resolve: Callable[[str], str], assignments: Mapping[str, str], timeout: float
) -> tuple[Any, Any]:
    """Set a node's private parameters, in one call.

    Args:
        master: the node's client of the master.
        resolve: returns the full name that a name stands for.
        assignments: name without ``~`` -> value as text.
        timeout: seconds that the master may take.

    Returns:
        /use_sim_time and the tree of all private parameters, which the node needs at startup; an Error in place of
        each that is not set.
    """
    settings: list[tuple[str, tuple[Any, ...]]] = [
        ("setParam", (resolve("~" + key), private_parameter(text))) for key, text in assignments.items()
    ]
    *_, sim_time, private = master.multicall(
        [*settings, ("getParam", ("/use_sim_time",)), ("getParam", (master.caller_id,))], timeout=timeout
    )
    return sim_time, private


def leftover_warning(node_name: str, tree: Any, assignments: Mapping[str, str]) -> list[str]:
    """Return a line about the private parameters that were set before a node started; an empty text if none were.

    Args:
        node_name: full name.
        tree: the parameters below that name; not a dict if none are set.
        assignments: names of those that the command line sets.
    """
    assigned = {name.strip("/") for name in assignments}
    found = (
        [(name, value) for name, value in _leaves(tree, "") if name not in assigned] if isinstance(tree, dict) else []
    )
    if not found:
        return []
    texts = [f"~{name} is {value!r:.40}" for name, value in found[:_MAX_SHOWN]]
    omitted = f" and {len(found) - _MAX_SHOWN} more" if len(found) > _MAX_SHOWN else ""
    # Not the whole namespace: other nodes may have parameters in it.
    forget = f"to forget {'it' if len(found) == 1 else 'one'}: pyros1 param delete {node_name}/{found[0][0]}"
    return [f"set before this start: {', '.join(texts)}{omitted} ({forget})"]


def _leaves(tree: dict[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for name, value in tree.items():
        if isinstance(value, dict) and value:
            yield from _leaves(value, f"{prefix}{name}/")
        else:
            yield prefix + name, value
