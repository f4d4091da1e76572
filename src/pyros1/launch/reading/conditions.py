"""The ``wait-for`` attribute: what has to exist before a node starts."""

from __future__ import annotations

from dataclasses import dataclass

from pyros1.errors import LaunchError
from pyros1.names import ns_join, resolve_name

KINDS = ("topic", "service", "param", "node")
DEFAULT_TIMEOUT = 60.0
"""Seconds that a node waits if ``wait-timeout`` does not say otherwise."""


@dataclass(frozen=True)
class Condition:
    """Something that has to exist: a published topic, a service, a parameter or a node.

    Attributes:
        kind: one of `KINDS`.
        name: full name.
    """

    kind: str
    name: str

    def __str__(self) -> str:
        return f"{self.kind}:{self.name}"


def parse_conditions(text: str, namespace: str, name: str) -> list[Condition]:
    """Read a ``wait-for`` attribute: words such as ``topic:/scan`` or ``param:~ready``, separated by blanks.

    Args:
        text: the attribute.
        namespace: where relative names belong.
        name: the node's base name, for private names.

    Raises:
        LaunchError: a word is not understood.
    """
    found = []
    for word in text.split():
        kind, colon, what = word.partition(":")
        if not colon or kind not in KINDS or not what.strip("/~"):
            raise LaunchError(
                f"wait-for cannot be understood at '{word}': write topic:NAME, service:NAME, param:NAME or node:NAME"
            )
        found.append(Condition(kind, resolve_name(what, ns_join(namespace, name))))
    return found


def parse_seconds(text: str, attribute: str) -> float:
    """Read a number of seconds.

    Args:
        text: the attribute's value.
        attribute: its name, for the error.

    Raises:
        LaunchError: not a number, or a negative one.
    """
    try:
        seconds = float(text)
    except ValueError as error:
        raise LaunchError(f"'{attribute}' must be a number of seconds, not {text!r}") from error
    if not 0 <= seconds < float("inf"):
        raise LaunchError(f"'{attribute}' must not be negative or endless: {text!r}")
    return seconds
