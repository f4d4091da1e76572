"""``topic list``: prints the topics of the running system or of a bag (L25-L27)."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.printing import print_json
from pyros1.graph import UNKNOWN_TYPE, Graph, SystemState, names_in_namespace
from pyros1.ground.errors import ProtocolError
from pyros1.net.hosts import parse_uri


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the registered topics, or the topics in a bag."""
    if len(args) > 1:
        raise UsageError("you may only specify one input topic")
    if options.bag:
        for is_given, option in ((options.subscribers, "-s"), (options.publishers, "-p"), (options.host, "--host")):
            if is_given:
                raise UsageError(f"{option} option is not valid with bags")
        from pyros1.cli.commands.topic import _bag  # noqa: PLC0415 - slow to import

        namespace = invocation.resolve(args[0]) if args else None
        _bag.list_topics(options.bag, namespace, invocation.resolve, as_json=options.json)
        return
    if options.publishers and options.subscribers:
        raise UsageError("you may only specify one of -p, -s")
    namespace = invocation.resolve(args[0]) if args else None  # like rostopic, list all namespaces by default
    selected_role = "p" if options.publishers else "s" if options.subscribers else ""
    graph = invocation.graph
    state = graph.state()
    publishers = {} if selected_role == "s" else _select_namespace(state.publishers, namespace)
    subscribers = {} if selected_role == "p" else _select_namespace(state.subscribers, namespace)
    if options.json:
        print_json(_as_json(publishers, subscribers, graph.topic_types()))
    elif options.host:
        _list_by_host(graph, state, publishers, subscribers, bool(options.verbose), selected_role)
    elif options.verbose:
        print(_verbose_text(publishers, subscribers, graph.topic_types(), selected_role, ""))
    else:
        print(*sorted({*publishers, *subscribers}), sep="\n")


VERB = Verb(
    "list",
    "list active topics",
    Option("-b", "--bag", help="list topics in .bag file", metavar="BAGFILE"),
    CHUNK_LIMIT_OPTION,
    Flag("-v", "--verbose", help="list full details about each topic"),
    Flag("-p", dest="publishers", help="list only publishers"),
    Flag("-s", dest="subscribers", help="list only subscribers"),
    Flag("--host", help="group by host name"),
    Flag("--json", help="print a JSON list of objects: topic, type, publishers, subscribers", pyros1_only=True),
    Argument("/namespace", "namespace", optional=True),
    usage="[/namespace]",
    examples=[
        ("", "list all topics"),
        ("-v /robot1", "list topics below /robot1 with their types and numbers of publishers"),
        ("--json", "print JSON for programs"),
    ],
    run=run,
)


def _as_json(
    publishers: dict[str, list[str]], subscribers: dict[str, list[str]], types: dict[str, str]
) -> list[dict[str, object]]:
    return [
        {
            "topic": topic,
            "type": types.get(topic),
            "publishers": publishers.get(topic, []),
            "subscribers": subscribers.get(topic, []),
        }
        for topic in sorted({*publishers, *subscribers})
    ]


def _select_namespace(nodes_by_topic: dict[str, list[str]], namespace: str | None) -> dict[str, list[str]]:
    return {name: nodes_by_topic[name] for name in names_in_namespace(nodes_by_topic, namespace)}


def _verbose_text(
    publishers: dict[str, list[str]],
    subscribers: dict[str, list[str]],
    types: dict[str, str],
    selected_role: str,
    indent: str,
) -> str:
    lines = [""]
    for title, role, nodes_by_topic, other_role in (
        ("Published", "publisher", publishers, "s"),
        ("Subscribed", "subscriber", subscribers, "p"),
    ):
        if selected_role == other_role:
            continue
        lines.append(f"{indent}{title} topics:")
        for topic, nodes in nodes_by_topic.items():
            plural_suffix = "s" if len(nodes) > 1 else ""
            lines.append(f"{indent} * {topic} [{types.get(topic, UNKNOWN_TYPE)}] {len(nodes)} {role}{plural_suffix}")
        lines.append(indent)
    if indent:
        lines[-1] = ""
    return "\n".join(lines)


def _list_by_host(
    graph: Graph,
    state: SystemState,
    publishers: dict[str, list[str]],
    subscribers: dict[str, list[str]],
    verbose: bool,
    selected_role: str,
) -> None:
    hosts_by_node: dict[str, str | None] = {}
    for node in state.nodes():
        uri = graph.node_uri(node)
        try:
            hosts_by_node[node] = parse_uri(uri)[0] if uri else None
        except ProtocolError as error:
            print(f"WARNING: {node} is left out: {error}", file=sys.stderr)
    types = graph.topic_types() if verbose else {}

    def restrict_to_host(host: str, nodes_by_topic: dict[str, list[str]]) -> dict[str, list[str]]:
        nodes_on_host = {
            topic: [node for node in nodes if hosts_by_node.get(node) == host]
            for topic, nodes in nodes_by_topic.items()
        }
        return {topic: nodes for topic, nodes in nodes_on_host.items() if nodes}

    for host in sorted({host for host in hosts_by_node.values() if host}):
        published, subscribed = restrict_to_host(host, publishers), restrict_to_host(host, subscribers)
        if not published and not subscribed:
            continue
        print(f"Host [{host}]:")
        if verbose:
            print(_verbose_text(published, subscribed, types, selected_role, "  "))
        else:
            print("\n".join(f"  {topic}" for topic in sorted({*published, *subscribed})))
