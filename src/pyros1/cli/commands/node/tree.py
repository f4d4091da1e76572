"""``node tree``: prints nodes by namespace with their publications, subscriptions and services."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.graph import UNKNOWN_TYPE, SystemState, names_in_namespace
from pyros1.ground.terminal_text import one_line

_COMMON_TOPICS = ("/rosout", "/rosout_agg", "/clock")
_COMMON_SERVICES = ("/get_loggers", "/set_logger_level")


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print nodes by namespace."""
    if len(args) > 1:
        raise UsageError("you may only specify one input namespace")
    graph = invocation.graph
    state = graph.state()
    names = names_in_namespace(sorted(state.nodes()), invocation.resolve(args[0]) if args else None)
    registrations_by_node = {name: _registrations(state, name, include_common=options.all) for name in names}
    if options.json:
        print_json([{"node": name, **registrations_by_node[name]} for name in names])
        return
    print("\n".join(_tree_lines(registrations_by_node, graph.topic_types(), state)))


VERB = Verb(
    "tree",
    "print nodes by namespace, with their topics and services",
    Flag("-a", "--all", help="also print what every node has, such as /rosout"),
    Flag("--json", help="print a JSON list of objects: node, publishes, subscribes, services", pyros1_only=True),
    Argument("/namespace", "namespace", optional=True),
    examples=[("", "print nodes with the topics they publish and subscribe to")],
    stock="",
    run=run,
)


def _registrations(state: SystemState, node_name: str, *, include_common: bool) -> dict[str, list[str]]:
    """Return a node's topics and services by role.

    Topics and services that all nodes have are only included if `include_common` is set.
    """
    registrations = state.of_node(node_name)
    hidden_services = () if include_common else tuple(node_name + service for service in _COMMON_SERVICES)
    hidden_topics = () if include_common else _COMMON_TOPICS
    return {
        "publishes": [topic for topic in sorted(registrations.publications) if topic not in hidden_topics],
        "subscribes": [topic for topic in sorted(registrations.subscriptions) if topic not in hidden_topics],
        "services": [service for service in sorted(registrations.services) if service not in hidden_services],
    }


def _tree_lines(
    registrations_by_node: dict[str, dict[str, list[str]]], types: dict[str, str], state: SystemState
) -> Iterator[str]:
    """Yield the lines of a tree that has a branch for each part of a node's name."""
    root: dict[str, Any] = {}
    for name in registrations_by_node:
        branch = root
        for part in name.strip("/").split("/"):
            branch = branch.setdefault(part, {})
    yield "/"
    yield from _branch_lines(root, "", "", registrations_by_node, types, state)


def _branch_lines(
    branch: dict[str, Any],
    path: str,
    indent: str,
    registrations_by_node: dict[str, dict[str, list[str]]],
    types: dict[str, str],
    state: SystemState,
) -> Iterator[str]:
    for number, (part, children) in enumerate(branch.items(), 1):
        name, is_last = f"{path}/{part}", number == len(branch)
        child_indent = indent + ("   " if is_last else "│  ")
        registrations = registrations_by_node.get(name)
        yield f"{indent}{'└─' if is_last else '├─'} {one_line(part)}{'/' if registrations is None else ''}"
        if registrations is not None:
            prefix = child_indent + ("│ " if children else "  ")
            for topic in registrations["publishes"]:
                yield f"{prefix}─> {topic} [{types.get(topic, UNKNOWN_TYPE)}]{_peers(state.subscribers, topic, name)}"
            for topic in registrations["subscribes"]:
                yield f"{prefix}<─ {topic} [{types.get(topic, UNKNOWN_TYPE)}]{_peers(state.publishers, topic, name)}"
            for service in registrations["services"]:
                yield f"{prefix}() {service}"
        yield from _branch_lines(children, name, child_indent, registrations_by_node, types, state)


def _peers(nodes_by_topic: dict[str, list[str]], topic: str, node_name: str) -> str:
    nodes = [node for node in nodes_by_topic.get(topic, []) if node != node_name]
    return f" {', '.join(map(str, nodes))}" if nodes else " nobody"
