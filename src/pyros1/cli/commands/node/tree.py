"""``node tree``: nodes by namespace, each with its publications, subscriptions and services."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.graph import UNKNOWN_TYPE, SystemState, in_namespace
from pyros1.ground.terminal_text import one_line

_QUIET_TOPICS = ("/rosout", "/rosout_agg", "/clock")
_QUIET_SERVICES = ("/get_loggers", "/set_logger_level")


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print nodes by namespace."""
    if len(args) > 1:
        raise UsageError("you may only specify one input namespace")
    graph = invocation.graph
    state = graph.state()
    names = in_namespace(sorted(state.nodes()), invocation.resolve(args[0]) if args else None)
    table = {name: _facts(state, name, everything=options.all) for name in names}
    if options.json:
        print_json([{"node": name, **table[name]} for name in names])
        return
    print("\n".join(_render(table, graph.topic_types(), state)))


VERB = Verb(
    "tree",
    "nodes by namespace, with their topics and services",
    Flag("-a", "--all", help="also show what every node has, such as /rosout"),
    Flag("--json", help="print a JSON list of objects: node, publishes, subscribes, services", own=True),
    Argument("/namespace", "namespace", optional=True),
    examples=[("", "nodes by namespace, with the topics they publish and subscribe to")],
    stock="",
    run=run,
)


def _facts(state: SystemState, name: str, *, everything: bool) -> dict[str, list[str]]:
    """Return a node's publications, subscriptions and services; without those of every node, unless ``everything``."""
    own = state.of_node(name)
    quiet_services = () if everything else tuple(name + service for service in _QUIET_SERVICES)
    quiet_topics = () if everything else _QUIET_TOPICS
    return {
        "publishes": [topic for topic in sorted(own.publications) if topic not in quiet_topics],
        "subscribes": [topic for topic in sorted(own.subscriptions) if topic not in quiet_topics],
        "services": [service for service in sorted(own.services) if service not in quiet_services],
    }


def _render(table: dict[str, dict[str, list[str]]], types: dict[str, str], state: SystemState) -> Iterator[str]:
    """Return the lines of the tree."""
    root: dict[str, Any] = {}
    for name in table:
        branch = root
        for part in name.strip("/").split("/"):
            branch = branch.setdefault(part, {})
    yield "/"
    yield from _branch(root, "", "", table, types, state)


def _branch(
    branch: dict[str, Any],
    path: str,
    indent: str,
    table: dict[str, dict[str, list[str]]],
    types: dict[str, str],
    state: SystemState,
) -> Iterator[str]:
    for number, (part, children) in enumerate(branch.items(), 1):
        name, last = f"{path}/{part}", number == len(branch)
        inner = indent + ("   " if last else "│  ")
        own = table.get(name)
        yield f"{indent}{'└─' if last else '├─'} {one_line(part)}{'/' if own is None else ''}"
        if own is not None:
            edge = inner + ("│ " if children else "  ")
            for topic in own["publishes"]:
                yield f"{edge}─> {topic} [{types.get(topic, UNKNOWN_TYPE)}]{_peers(state.subscribers, topic, name)}"
            for topic in own["subscribes"]:
                yield f"{edge}<─ {topic} [{types.get(topic, UNKNOWN_TYPE)}]{_peers(state.publishers, topic, name)}"
            for service in own["services"]:
                yield f"{edge}() {service}"
        yield from _branch(children, name, inner, table, types, state)


def _peers(table: dict[str, list[str]], topic: str, name: str) -> str:
    nodes = [node for node in table.get(topic, []) if node != name]
    return f" {', '.join(map(str, nodes))}" if nodes else " nobody"
