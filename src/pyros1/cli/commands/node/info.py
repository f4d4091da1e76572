"""``node info`` (L71, L72)."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.graph import UNKNOWN_TYPE, Connection, Graph, SystemState
from pyros1.ground.errors import DeadlineError, UnreachableError
from pyros1.net.connectivity import connectivity_hint
from pyros1.net.hosts import parse_uri

_SEPARATOR = "-" * 80


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the publications, subscriptions, services and connections of nodes."""
    if not args:
        raise UsageError("You must specify at least one node name")
    graph = invocation.graph
    if options.json:
        state = graph.state()
        print_json(
            [_node_info(graph, state, name, contact=not options.quiet) for name in map(invocation.resolve, args)]
        )
        return
    for name in map(invocation.resolve, args):
        print(_SEPARATOR)
        state = graph.state()
        print(_description(name, state, graph.published_types()))
        uri = graph.node_uri(name)
        if uri is None:
            sys.stdout.flush()
            hint = did_you_mean(name, state.nodes())
            print(f"cannot contact [{name}]: unknown node{hint}", file=sys.stderr)
        elif not options.quiet:
            _print_connections(graph, state, uri)


VERB = Verb(
    "info",
    "print information about node",
    Flag(
        "-q",
        "--quiet",
        help="Prints only basic information such as pubs/subs and does not contact nodes for more information",
    ),
    Flag("--json", help="print a JSON list of objects, one for each node", pyros1_only=True),
    Argument("node", "node", repeatable=True),
    usage="[options] node1 [node2...]",
    examples=[("/talker", "print topics, services and connections of a node")],
    run=run,
)


def _node_info(graph: Graph, state: SystemState, name: str, *, contact: bool) -> dict[str, Any]:
    registrations = state.of_node(name)
    info: dict[str, Any] = {
        "node": name,
        "uri": graph.node_uri(name),
        "publishes": registrations.publications,
        "subscribes": registrations.subscriptions,
        "services": registrations.services,
    }
    if info["uri"] is None:
        raise CommandError(f"unknown node {name}{did_you_mean(name, state.nodes())}")
    if contact:
        node_api = graph.node_api(info["uri"])
        try:
            info["pid"] = node_api.pid()
            info["connections"] = [connection._asdict() for connection in node_api.connections()]
        except (UnreachableError, DeadlineError) as error:
            info["error"] = str(error)
        finally:
            node_api.close()
    return info


def _description(name: str, state: SystemState, types: dict[str, str]) -> str:
    """Return the description of a node that ``node info`` prints from the master's data."""
    registrations = state.of_node(name)

    def block(title: str, entries: list[str]) -> str:
        return f"{title}: None\n" if not entries else f"{title}: \n" + "".join(f" * {entry}\n" for entry in entries)

    def with_types(topics: list[str]) -> list[str]:
        return [f"{topic} [{types.get(topic, UNKNOWN_TYPE)}]" for topic in topics]

    return "\n".join(
        [
            f"Node [{name}]\n" + block("Publications", with_types(registrations.publications)),
            block("Subscriptions", with_types(registrations.subscriptions)),
            block("Services", registrations.services),
        ]
    )


def _print_connections(graph: Graph, state: SystemState, uri: str) -> None:
    print(f"\ncontacting node {uri} ...")
    node_api = graph.node_api(uri)
    try:
        pid, connections = node_api.pid(), node_api.connections()
    except (UnreachableError, DeadlineError) as error:
        hint = connectivity_hint(parse_uri(uri)[0], error)
        raise CommandError(f"Communication with node[{uri}] failed!\n{error}. {hint}") from None
    finally:
        node_api.close()
    print(f"Pid: {pid}")
    if connections:
        print("Connections:")
    for connection in connections:
        if connection.connected:
            print(_connection_text(connection, graph, state))
    print()


def _connection_text(connection: Connection, graph: Graph, state: SystemState) -> str:
    peer = connection.destination
    if connection.direction == "i":
        for name in state.publishers.get(connection.topic, ()):
            if graph.node_uri(name) == peer:
                peer = f"{name} ({peer})"
                break
    direction = {"i": "inbound", "o": "outbound"}.get(connection.direction, "unknown")
    if connection.peer is not None:
        direction += f" ({connection.local_port} - {connection.peer}) [{connection.socket}]"
    return (
        f" * topic: {connection.topic}\n    * to: {peer}\n"
        f"    * direction: {direction}\n    * transport: {connection.transport}"
    )
