"""``pyros1 topic_tools mux_select`` and its like: the services of mux and demux, called from a command line (L192)."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

from pyros1.cli.topic_tools import UsageError, open_node
from pyros1.errors import ServiceError

_DOING = {
    "select": 'Selecting "{topic}" at {kind} "{name}"',
    "add": 'Adding "{topic}" to {kind} "{name}"',
    "delete": 'Deleting "{topic}" from {kind} "{name}"',
    "list": 'Listing topics from {kind} "{name}"',
}


def main(tool: str, arguments: Sequence[str], words: Sequence[str]) -> int:
    """Call the service that a tool stands for.

    Args:
        tool: ``mux_select``, ``demux_list``, ..., or ``switch_mux``.
        arguments: name of the mux or demux, and a topic.
        words: the whole command line, with remappings.

    Returns:
        The exit code: 1 if the service refused.
    """
    kind, _, verb = tool.partition("_")
    if len(arguments) != (1 if verb == "list" else 2):
        raise UsageError("")
    name, *topic = arguments
    if tool == "switch_mux":
        return _switch(name, topic[0], words)
    service = f"{name}/{verb}"
    print(f'Waiting for service "{service}"', flush=True)
    response = None
    with open_node(tool, words) as node:
        node.wait_for_service(service)
        print(_DOING[verb].format(kind=kind, name=name, topic="".join(topic)), flush=True)
        response = _call(node, service, f"topic_tools/{kind.capitalize()}{verb.capitalize()}", topic)
        if response is not None and verb == "list":
            print(response.topics)
    return 1 if response is None else 0


def _switch(output: str, topic: str, words: Sequence[str]) -> int:
    response = None
    with open_node("switch_mux", words) as node:
        node.log.warn("switch_mux is deprecated: use mux_select")
        response = _call(node, f"{output}_select", "topic_tools/MuxSelect", [topic])
        if response is not None:
            node.log.info("%s was switched from %s to %s", output, response.prev_topic or "nothing", topic)
    return 1 if response is None else 0


def _call(node: Any, service: str, type_name: str, values: Sequence[str]) -> Any:
    try:
        return node.service(service, type_name)(*values)
    except ServiceError as error:
        print(f"Service call failed: {error}", file=sys.stderr)
        return None
