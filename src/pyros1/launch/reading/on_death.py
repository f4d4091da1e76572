"""The ``on-death`` attribute: an action when a node has ended, so that its last command does not stay in effect."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from dataclasses import dataclass

from pyros1.ground.errors import LaunchError
from pyros1.ground.names import ns_join, resolve_name

USAGE = "use pub TOPIC TYPE VALUE, or run PACKAGE PROGRAM ARGUMENTS"


@dataclass(frozen=True)
class OnDeath:
    """The action to take when a node has ended.

    Attributes:
        kind: ``pub``: a message is published; ``run``: a program of a package is run.
        words: for ``pub`` the topic's full name, the type and the values; for ``run`` package, program and arguments.
    """

    kind: str
    words: tuple[str, ...]

    def __str__(self) -> str:
        return shlex.join([self.kind, *self.words])


def parse_on_death(text: str, namespace: str, name: str, remappings: Iterable[tuple[str, str]]) -> OnDeath | None:
    """Return what an ``on-death`` attribute asks for, None if it is empty.

    Args:
        text: the attribute.
        namespace: namespace of relative names.
        name: the node's base name, for private names.
        remappings: the node's remappings, which apply to the topic as well.

    Raises:
        LaunchError: it is neither of the two forms, or its quotes do not match.
    """
    try:
        kind, *words = shlex.split(text) or [""]
    except ValueError as error:
        raise LaunchError(f"cannot split the 'on-death' attribute into words: {error} in {text!r}") from error
    if not kind:
        return None
    if kind not in ("pub", "run") or len(words) < 2:
        raise LaunchError(f"'on-death' cannot be '{text}': {USAGE}")
    if kind == "pub":
        node = ns_join(namespace, name)
        known = {resolve_name(old, node): resolve_name(new, node) for old, new in remappings if not old.startswith("_")}
        topic = resolve_name(words[0], node)
        words[0] = known.get(topic, topic)
    return OnDeath(kind, tuple(words))
