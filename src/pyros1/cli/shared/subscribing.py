"""Subscriptions to topics of any type, for echo, hz, bw and delay. The publisher's header contains the type."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.ground.errors import MasterError
from pyros1.msgs import AnyMsg

_POLL_PERIOD = 0.2


def wait_for_topic(invocation: Invocation, node: Any, name: str) -> tuple[str, str, str] | None:
    """Wait until the topic in ``name`` is known, and split ``name`` into topic and field path.

    If the topic is not known yet, print a warning before waiting (L61).

    Returns:
        (topic, field path, type), or None if the node was shut down.
    """
    graph = invocation.graph
    topic_match = graph.find_topic(name)
    if topic_match is None:
        hint = did_you_mean(name, graph.topic_types())
        print(f"WARNING: topic [{name}] does not appear to be published yet{hint}", file=sys.stderr, flush=True)
    while topic_match is None:
        if not node.ok():
            return None
        # Only the registered topics tell where the topic ends and the field path begins.
        invocation.pause(_POLL_PERIOD)
        try:
            topic_match = graph.find_topic(name)
        except MasterError:
            continue  # the master may become available again
    return topic_match[0], topic_match[2], topic_match[1]


def subscribe(node: Any, topic: str, callback: Callable[[AnyMsg], object]) -> Any:
    """Subscribe to a topic without decoding its messages. Return the subscriber."""
    return node.subscribe(topic, AnyMsg, callback)
