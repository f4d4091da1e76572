"""``topic info``: prints the type, publishers and subscribers of a topic (L28)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.graph import UNKNOWN_TYPE


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a topic's type, publishers and subscribers."""
    if not args:
        raise UsageError("you must specify a topic name")
    if len(args) > 1:
        raise UsageError("you may only specify one topic name")
    topic = invocation.resolve(args[0])
    graph = invocation.graph
    state = graph.state()
    publishers, subscribers = state.publishers.get(topic), state.subscribers.get(topic)
    if publishers is None and subscribers is None:
        raise CommandError(f"Unknown topic {topic}{did_you_mean(topic, {*state.publishers, *state.subscribers})}")
    if options.json:
        print_json(
            {
                "topic": topic,
                "type": graph.topic_types().get(topic),
                "publishers": [{"node": node, "uri": graph.node_uri(node)} for node in publishers or []],
                "subscribers": [{"node": node, "uri": graph.node_uri(node)} for node in subscribers or []],
            }
        )
        return
    print(f"Type: {graph.topic_types().get(topic, UNKNOWN_TYPE)}\n")
    for title, nodes in (("Publishers", publishers), ("Subscribers", subscribers)):
        if nodes:
            print(f"{title}: ")
            for node in nodes:
                print(f" * {node} ({graph.node_uri(node) or f'unknown address {node}'})")
        else:
            print(f"{title}: None")
        print()
    print()


VERB = Verb(
    "info",
    "print information about active topic",
    JSON_FLAG,
    Argument("/topic", "topic"),
    usage="/topic",
    examples=[("/chatter", "print a topic's type, publishers and subscribers")],
    run=run,
)
