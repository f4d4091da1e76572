"""``topic_tools mux_select`` and its like: the services of mux and demux, called from a command line (L192)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

from pyros1.cli.commands.topic_tools._tool import Tool, open_node
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument
from pyros1.errors import ServiceError

_DOING = {
    "select": 'Selecting "{topic}" at {kind} "{name}"',
    "add": 'Adding "{topic}" to {kind} "{name}"',
    "delete": 'Deleting "{topic}" from {kind} "{name}"',
    "list": 'Listing topics from {kind} "{name}"',
}


def _run(kind: str, verb: str) -> Callable[[Invocation, Any, list[str]], int]:
    """Return what calls a service.

    Args:
        kind: ``mux`` or ``demux``.
        verb: one of `_DOING`.
    """

    def run(invocation: Invocation, options: Any, args: list[str]) -> int:
        if len(args) != (1 if verb == "list" else 2):
            raise UsageError("")
        name, *topic = args
        service = f"{name}/{verb}"
        print(f'Waiting for service "{service}"', flush=True)
        response = None
        with open_node(invocation, f"{kind}_{verb}") as node:
            node.wait_for_service(service)
            print(_DOING[verb].format(kind=kind, name=name, topic="".join(topic)), flush=True)
            response = _call(node, service, f"topic_tools/{kind.capitalize()}{verb.capitalize()}", topic)
            if response is not None and verb == "list":
                print(response.topics)
        return 1 if response is None else 0

    return run


def _switch(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Select the input of a mux that is known by its output."""
    if len(args) != 2:
        raise UsageError("")
    output, topic = args
    response = None
    with open_node(invocation, "switch_mux") as node:
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


_MUX, _DEMUX, _TOPIC = Argument("MUX"), Argument("DEMUX"), Argument("TOPIC", "topic")

VERBS = [
    Tool(
        "mux_select",
        "selects the mux's input, or none: __none",
        _MUX,
        _TOPIC,
        examples=[("mux_vel /planner", "")],
        run=_run("mux", "select"),
    ),
    Tool("mux_add", "adds an input", _MUX, _TOPIC, examples=[("mux_vel /by_hand", "one more")], run=_run("mux", "add")),
    Tool(
        "mux_delete", "deletes an input", _MUX, _TOPIC, examples=[("mux_vel /planner", "")], run=_run("mux", "delete")
    ),
    Tool(
        "mux_list", "lists the inputs", _MUX, examples=[("mux_vel", "what there is to select")], run=_run("mux", "list")
    ),
    Tool(
        "demux_select",
        "selects the demux's output, or none: __none",
        _DEMUX,
        _TOPIC,
        examples=[("demux /right/cmd", "as `demux /cmd /left/cmd /right/cmd` has it")],
        own=True,
        run=_run("demux", "select"),
    ),
    Tool(
        "demux_add",
        "adds an output",
        _DEMUX,
        _TOPIC,
        examples=[("demux /arm/cmd", "one more")],
        own=True,
        run=_run("demux", "add"),
    ),
    Tool(
        "demux_delete",
        "deletes an output",
        _DEMUX,
        _TOPIC,
        examples=[("demux /left/cmd", "")],
        own=True,
        run=_run("demux", "delete"),
    ),
    Tool(
        "demux_list",
        "lists the outputs",
        _DEMUX,
        examples=[("demux", "what there is to select")],
        own=True,
        run=_run("demux", "list"),
    ),
    Tool(
        "switch_mux",
        "deprecated: mux_select, by the name of the mux's output",
        Argument("MUXED_TOPIC", "topic"),
        Argument("SELECT_TOPIC", "topic"),
        examples=[("/cmd_vel /planner", "by the service /cmd_vel_select")],
        run=_switch,
    ),
]
