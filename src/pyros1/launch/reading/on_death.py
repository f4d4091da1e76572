"""Parses the ``on-death`` attribute: an action to take when a node exits, for example to stop a robot that would
otherwise continue to follow the node's last command.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from dataclasses import dataclass

from pyros1.ground.errors import LaunchError
from pyros1.ground.names import ns_join, resolve_name

_USAGE_HINT = "use pub TOPIC TYPE VALUE, or run PACKAGE PROGRAM ARGUMENTS"


@dataclass(frozen=True)
class OnDeath:
    """The action to take when a node exits.

    Attributes:
        kind: ``pub`` to publish a message, or ``run`` to run a program from a package.
        words: for ``pub``, the topic's full name, the type and the values; for ``run``, package, program and arguments.
    """

    kind: str
    words: tuple[str, ...]

    def __str__(self) -> str:
        return shlex.join([self.kind, *self.words])


def parse_on_death(text: str, namespace: str, name: str, remappings: Iterable[tuple[str, str]]) -> OnDeath | None:
    """Parse an ``on-death`` attribute; return None if it is empty.

    Args:
        text: the attribute's value.
        namespace: namespace for relative names.
        name: the node's base name, for private names.
        remappings: the node's remappings, which also apply to the topic.

    Raises:
        LaunchError: the value has neither of the two forms, or unbalanced quotes.
    """
    try:
        kind, *words = shlex.split(text) or [""]
    except ValueError as error:
        raise LaunchError(f"cannot split the 'on-death' attribute into arguments: {error} in {text!r}") from error
    if not kind:
        return None
    if kind not in ("pub", "run") or len(words) < 2:
        raise LaunchError(f"'on-death' cannot be '{text}': {_USAGE_HINT}")
    if kind == "pub":
        node = ns_join(namespace, name)
        resolved_remappings = {
            resolve_name(old, node): resolve_name(new, node) for old, new in remappings if not old.startswith("_")
        }
        topic = resolve_name(words[0], node)
        words[0] = resolved_remappings.get(topic, topic)
    return OnDeath(kind, tuple(words))
