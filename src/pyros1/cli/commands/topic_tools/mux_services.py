"""``topic_tools mux_select`` and similar tools: call the services of mux and demux (L192)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

from pyros1.cli.commands.topic_tools._tool import Tool, open_node
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument
from pyros1.ground.errors import ServiceError

_ACTION_MESSAGES = {
    "select": 'Selecting "{topic}" at {kind} "{name}"',
    "add": 'Adding "{topic}" to {kind} "{name}"',
    "delete": 'Deleting "{topic}" from {kind} "{name}"',
    "list": 'Listing topics from {kind} "{name}"',
}


def _make_run_function(kind: str, verb: str) -> Callable[[Invocation, Any, list[str]], int]:
    """Return a `run` function that calls a service of a mux or demux.

    Args:
        kind: ``mux`` or ``demux``.
        verb: the action, a key of `_ACTION_MESSAGES`.
    """

    def run(invocation: Invocation, options: Any, args: list[str]) -> int:
        if len(args) != (1 if verb == "list" else 2):
            raise UsageError("")
        name, *topics = args
        service = f"{name}/{verb}"
        print(f'Waiting for service "{service}"', flush=True)
        response = None
        with open_node(invocation, f"{kind}_{verb}") as node:
            node.wait_for_service(service)
            print(_ACTION_MESSAGES[verb].format(kind=kind, name=name, topic="".join(topics)), flush=True)
            response = _call_service(node, service, f"topic_tools/{kind.capitalize()}{verb.capitalize()}", topics)
            if response is not None and verb == "list":
                print(response.topics)
        return 1 if response is None else 0

    return run


def _switch_mux(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Select the input of the mux that publishes a given output."""
    if len(args) != 2:
        raise UsageError("")
    output_topic, topic = args
    response = None
    with open_node(invocation, "switch_mux") as node:
        node.log.warn("switch_mux is deprecated: use mux_select")
        response = _call_service(node, f"{output_topic}_select", "topic_tools/MuxSelect", [topic])
        if response is not None:
            node.log.info("%s was switched from %s to %s", output_topic, response.prev_topic or "nothing", topic)
    return 1 if response is None else 0


def _call_service(node: Any, service: str, type_name: str, values: Sequence[str]) -> Any:
    try:
        return node.service(service, type_name)(*values)
    except ServiceError as error:
        print(f"Service call failed: {error}", file=sys.stderr)
        return None


_MUX, _DEMUX, _TOPIC = Argument("MUX"), Argument("DEMUX"), Argument("TOPIC", "topic")

VERBS = [
    Tool(
        "mux_select",
        "select the input of a mux; __none selects no input",
        _MUX,
        _TOPIC,
        examples=[("mux_vel /planner", "")],
        run=_make_run_function("mux", "select"),
    ),
    Tool(
        "mux_add",
        "add a topic to the inputs of a mux",
        _MUX,
        _TOPIC,
        examples=[("mux_vel /by_hand", "add one more input")],
        run=_make_run_function("mux", "add"),
    ),
    Tool(
        "mux_delete",
        "remove a topic from the inputs of a mux",
        _MUX,
        _TOPIC,
        examples=[("mux_vel /planner", "")],
        run=_make_run_function("mux", "delete"),
    ),
    Tool(
        "mux_list",
        "list the inputs of a mux",
        _MUX,
        examples=[("mux_vel", "list the topics that can be selected")],
        run=_make_run_function("mux", "list"),
    ),
    Tool(
        "demux_select",
        "select the output of a demux; __none selects no output",
        _DEMUX,
        _TOPIC,
        examples=[("demux /right/cmd", "select an output of `demux /cmd /left/cmd /right/cmd`")],
        pyros1_only=True,
        run=_make_run_function("demux", "select"),
    ),
    Tool(
        "demux_add",
        "add a topic to the outputs of a demux",
        _DEMUX,
        _TOPIC,
        examples=[("demux /arm/cmd", "add one more output")],
        pyros1_only=True,
        run=_make_run_function("demux", "add"),
    ),
    Tool(
        "demux_delete",
        "remove a topic from the outputs of a demux",
        _DEMUX,
        _TOPIC,
        examples=[("demux /left/cmd", "")],
        pyros1_only=True,
        run=_make_run_function("demux", "delete"),
    ),
    Tool(
        "demux_list",
        "list the outputs of a demux",
        _DEMUX,
        examples=[("demux", "list the topics that can be selected")],
        pyros1_only=True,
        run=_make_run_function("demux", "list"),
    ),
    Tool(
        "switch_mux",
        "select the input of a mux, given the mux's output topic (deprecated: use mux_select)",
        Argument("MUXED_TOPIC", "topic"),
        Argument("SELECT_TOPIC", "topic"),
        examples=[("/cmd_vel /planner", "call the service /cmd_vel_select")],
        run=_switch_mux,
    ),
]
