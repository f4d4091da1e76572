"""``topic list -b`` and ``topic echo -b``: print the topics and messages in a bag (L27, L35, L36, L43)."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from typing import Any

from pyros1 import bag as bags
from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.cli.shared.printing import print_json
from pyros1.graph import names_in_namespace
from pyros1.ground.terminal_text import one_line
from pyros1.ground.timing import Time
from pyros1.msgs import AnyMsg

ResolveFunction = Callable[[str], str]
"""Type of a function that returns the full name of a topic. Relative names in bags are resolved like arguments."""


def list_topics(path: str, namespace: str | None, resolve: ResolveFunction, *, as_json: bool) -> None:
    """Print the topics in a bag, or the number and times of the messages on topics below a namespace."""
    with _open(path) as bag:
        if namespace is None:
            names = list(dict.fromkeys(connection.topic for connection in bag.connections))
            if as_json:
                print_json([{"topic": name, "type": bag.topics[name], "messages": bag.count(name)} for name in names])
            elif names:
                print(*map(one_line, names), sep="\n")
            return
        topics = [name for name in bag.topics if names_in_namespace([resolve(name)], namespace)]
        times = [message.time.to_sec() for message in bag.messages(topics, raw=True)] if topics else []
        if as_json:
            time_range = {"start": min(times), "end": max(times)} if times else {"start": None, "end": None}
            print_json({"namespace": namespace, "topics": topics, "messages": len(times), **time_range})
            return
        if not times:
            hint = did_you_mean(namespace, map(resolve, bag.topics))
            raise CommandError(f"no messages on {namespace} in {path}{hint}")
        first_time, last_time = (
            time.strftime("%d %b %Y %H:%M:%S", time.localtime(seconds)) for seconds in (min(times), max(times))
        )
        print(f"{len(times)} message(s) from {first_time} to {last_time}")


def find_topic(path: str, name: str, resolve: ResolveFunction) -> tuple[list[str], str] | None:
    """Split a full name into topics of the bag and a field path.

    Returns:
        The recorded topics (several if the bag has both ``/a`` and ``a``) and the path. If there are none, print a
        warning and return None.
    """
    with _open(path) as bag:
        topics_by_full_name: dict[str, list[str]] = {}
        for topic in bag.topics:
            topics_by_full_name.setdefault(resolve(topic), []).append(topic)
    for topic in sorted(topics_by_full_name, key=len, reverse=True):
        if name == topic or name.startswith(topic + "/"):
            return topics_by_full_name[topic], name[len(topic) :]
    print(f"WARNING: no topic [{name}] in {path}{did_you_mean(name, topics_by_full_name)}", file=sys.stderr)
    return None


def for_each_message(path: str, topics: list[str] | None, on_message: Callable[[str, AnyMsg, Time], bool]) -> None:
    """Call a function with each raw message in a bag, in chronological order, until it returns False.

    Args:
        path: the path of the bag.
        topics: the topics; None for all.
        on_message: called with the topic, the message and the time at which it was recorded.
    """
    with _open(path) as bag:
        definitions = {connection.id: bag.definition(connection) for connection in bag.connections}
        for message in bag.messages(topics, raw=True):
            message.message._connection_header["message_definition"] = definitions[message.connection.id]
            if not on_message(message.topic, message.message, message.time):
                return
            del message  # a message may be large, and must not stay in memory while the next one is read


def _open(path: str) -> Any:
    if not os.path.isfile(path):
        raise CommandError(f"bag file [{path}] does not exist")
    return bags.open(path)
