"""``node info``: prints the topics, services and connections of nodes (L71, L72)."""

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
            [
                _node_info(graph, state, node_name, contacts_node=not options.quiet)
                for node_name in map(invocation.resolve, args)
            ]
        )
        return
    for node_name in map(invocation.resolve, args):
        print(_SEPARATOR)
        state = graph.state()
        print(_registrations_text(node_name, state, graph.published_types()))
        uri = graph.node_uri(node_name)
        if uri is None:
            sys.stdout.flush()
            hint = did_you_mean(node_name, state.nodes())
            print(f"cannot contact [{node_name}]: unknown node{hint}", file=sys.stderr)
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


def _node_info(graph: Graph, state: SystemState, node_name: str, *, contacts_node: bool) -> dict[str, Any]:
    registrations = state.of_node(node_name)
    info: dict[str, Any] = {
        "node": node_name,
        "uri": graph.node_uri(node_name),
        "publishes": registrations.publications,
        "subscribes": registrations.subscriptions,
        "services": registrations.services,
    }
    if info["uri"] is None:
        raise CommandError(f"unknown node {node_name}{did_you_mean(node_name, state.nodes())}")
    if contacts_node:
        node_api = graph.node_api(info["uri"])
        try:
            info["pid"] = node_api.pid()
            info["connections"] = [connection._asdict() for connection in node_api.connections()]
        except (UnreachableError, DeadlineError) as error:
            info["error"] = str(error)
        finally:
            node_api.close()
    return info


def _registrations_text(node_name: str, state: SystemState, types: dict[str, str]) -> str:
    """Return the first part of the output for a node, which only needs data from the master."""
    registrations = state.of_node(node_name)

    def format_block(title: str, entries: list[str]) -> str:
        return f"{title}: None\n" if not entries else f"{title}: \n" + "".join(f" * {entry}\n" for entry in entries)

    def append_types(topics: list[str]) -> list[str]:
        return [f"{topic} [{types.get(topic, UNKNOWN_TYPE)}]" for topic in topics]

    return "\n".join(
        [
            f"Node [{node_name}]\n" + format_block("Publications", append_types(registrations.publications)),
            format_block("Subscriptions", append_types(registrations.subscriptions)),
            format_block("Services", registrations.services),
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
    destination = connection.destination
    if connection.direction == "i":
        for name in state.publishers.get(connection.topic, ()):
            if graph.node_uri(name) == destination:
                destination = f"{name} ({destination})"
                break
    direction = {"i": "inbound", "o": "outbound"}.get(connection.direction, "unknown")
    if connection.peer is not None:
        direction += f" ({connection.local_port} - {connection.peer}) [{connection.socket}]"
    return (
        f" * topic: {connection.topic}\n    * to: {destination}\n"
        f"    * direction: {direction}\n    * transport: {connection.transport}"
    )
