"""Parses the ``wait-for`` attribute: conditions that must be met before a node starts."""

from __future__ import annotations

from dataclasses import dataclass

from pyros1.ground.errors import LaunchError
from pyros1.ground.names import ns_join, resolve_name

CONDITION_KINDS = ("topic", "service", "param", "node")
DEFAULT_TIMEOUT = 60.0
"""Default of ``wait-timeout`` in seconds."""


@dataclass(frozen=True)
class Condition:
    """The condition that a topic is published, or that a service, a parameter or a node exists.

    Attributes:
        kind: one of `CONDITION_KINDS`.
        name: the full name.
    """

    kind: str
    name: str

    def __str__(self) -> str:
        return f"{self.kind}:{self.name}"


def parse_conditions(text: str, namespace: str, name: str) -> list[Condition]:
    """Return the conditions in a ``wait-for`` attribute, such as ``topic:/scan`` or ``param:~ready``.

    Args:
        text: the attribute's value; conditions are separated by blanks.
        namespace: namespace for relative names.
        name: the node's base name, for private names.

    Raises:
        LaunchError: a condition is malformed.
    """
    conditions = []
    for word in text.split():
        kind, colon, target = word.partition(":")
        if not colon or kind not in CONDITION_KINDS or not target.strip("/~"):
            raise LaunchError(
                f"'wait-for' has the invalid condition '{word}': use topic:NAME, service:NAME, param:NAME or node:NAME"
            )
        conditions.append(Condition(kind, resolve_name(target, ns_join(namespace, name))))
    return conditions


def parse_seconds(text: str, attribute: str) -> float:
    """Parse an attribute that is a number of seconds.

    Args:
        text: the attribute's value.
        attribute: the attribute's name, for error messages.

    Raises:
        LaunchError: the value is not a number, or negative or infinite.
    """
    try:
        seconds = float(text)
    except ValueError as error:
        raise LaunchError(f"'{attribute}' must be a number of seconds, not {text!r}") from error
    if not 0 <= seconds < float("inf"):
        raise LaunchError(f"'{attribute}' must not be negative or infinite: {text!r}")
    return seconds
