"""The ``wait-for`` attribute: conditions for the start of a node."""

from __future__ import annotations

from dataclasses import dataclass

from pyros1.ground.errors import LaunchError
from pyros1.ground.names import ns_join, resolve_name

KINDS = ("topic", "service", "param", "node")
DEFAULT_TIMEOUT = 60.0
"""Default of ``wait-timeout`` in seconds."""


@dataclass(frozen=True)
class Condition:
    """Something that must exist: a published topic, a service, a parameter or a node.

    Attributes:
        kind: one of `KINDS`.
        name: full name.
    """

    kind: str
    name: str

    def __str__(self) -> str:
        return f"{self.kind}:{self.name}"


def parse_conditions(text: str, namespace: str, name: str) -> list[Condition]:
    """Return the conditions in a ``wait-for`` attribute: words such as ``topic:/scan`` or ``param:~ready``.

    Args:
        text: the attribute, with words separated by blanks.
        namespace: namespace of relative names.
        name: the node's base name, for private names.

    Raises:
        LaunchError: a word does not have this form.
    """
    found = []
    for word in text.split():
        kind, colon, what = word.partition(":")
        if not colon or kind not in KINDS or not what.strip("/~"):
            raise LaunchError(
                f"'wait-for' has the invalid word '{word}': use topic:NAME, service:NAME, param:NAME or node:NAME"
            )
        found.append(Condition(kind, resolve_name(what, ns_join(namespace, name))))
    return found


def parse_seconds(text: str, attribute: str) -> float:
    """Return an attribute that is a number of seconds.

    Args:
        text: the attribute's value.
        attribute: its name, for the error.

    Raises:
        LaunchError: it is not a number, negative or infinite.
    """
    try:
        seconds = float(text)
    except ValueError as error:
        raise LaunchError(f"'{attribute}' must be a number of seconds, not {text!r}") from error
    if not 0 <= seconds < float("inf"):
        raise LaunchError(f"'{attribute}' must not be negative or infinite: {text!r}")
    return seconds
