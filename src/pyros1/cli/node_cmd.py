"""``pyros1 node``: rosnode (L70-L75)."""

from __future__ import annotations

import socket
import sys
from collections.abc import Iterable
from typing import Any

from pyros1.cli.common import CommandError, Invocation, did_you_mean, print_json, run
from pyros1.errors import DeadlineError, UnreachableError
from pyros1.graph import Connection, Graph, SystemState, in_namespace
from pyros1.net.hosts import parse_uri

_RULE = "-" * 80


def usage(program: str) -> str:
    """The command list."""
    return f"""{program} is a command-line tool for printing information about ROS Nodes.

Commands:
\t{program} ping\ttest connectivity to node
\t{program} list\tlist active nodes
\t{program} info\tprint information about node
\t{program} machine\tlist nodes running on a particular machine or list machines
\t{program} kill\tkill a running node
\t{program} cleanup\tpurge registration information of unreachable nodes
{_ours(program)}
Type {program} <command> -h for more detailed usage, e.g. '{program} ping -h'
"""


def _ours(program: str) -> str:
    """What stock's tool has not, and therefore does not list."""
    if program == "rosnode":
        return ""
    return f"""\t{program} tree\tnodes by namespace, with their topics and services
\t{program} status\tlist the processes of running launches: pid, CPU, memory, restarts, uptime
\t{program} stop\tstop a node of a launch
\t{program} start\tstart a stopped node of a launch
\t{program} restart\tstop a node of a launch and start it again
"""


def list_nodes(invocation: Invocation) -> None:
    """``node list [/namespace]`` (L70)."""
    namespace, uris, everything, json = None, False, False, False
    if invocation.args:
        parser = invocation.parser("list")
        parser.add_option("-u", action="store_true", dest="uris", help="list XML-RPC URIs")
        parser.add_option("-a", "--all", action="store_true", help="list all information")
        invocation.add_json(parser, "print a JSON list of objects: node, uri")
        options, args = parser.parse_args(invocation.args)
        if len(args) > 1:
            parser.error("invalid args: you may only specify one namespace")
        namespace = invocation.resolve(args[0]) if args else None
        uris, everything, json = bool(options.uris), bool(options.all), options.json
    graph = invocation.graph
    names = sorted(in_namespace(graph.state().nodes(), namespace))
    if json:
        print_json([{"node": name, "uri": graph.node_uri(name)} for name in names])
        return
    if everything:
        names = [f"{graph.node_uri(name) or 'unknown address'} \t{name}" for name in names]
    elif uris:
        names = [graph.node_uri(name) or f"unknown address {name}" for name in names]
    print(*names, sep="\n")


def info(invocation: Invocation) -> None:
    """``node info node...`` (L71, L72)."""
    parser = invocation.parser("info [options] node1 [node2...]")
    parser.add_option(
        "-q",
        "--quiet",
        action="store_true",
        help="Prints only basic information such as pubs/subs and does not contact nodes for more information",
    )
    invocation.add_json(parser, "print a JSON list of objects, one for each node")
    options, args = parser.parse_args(invocation.args)
    if not args:
        parser.error("You must specify at least one node name")
    graph = invocation.graph
    if options.json:
        state = graph.state()
        print_json([_facts(graph, state, name, contact=not options.quiet) for name in map(invocation.resolve, args)])
        return
    for name in map(invocation.resolve, args):
        print(_RULE)
        state = graph.state()
        print(description(name, state, graph.published_types()))
        uri = graph.node_uri(name)
        if uri is None:
            sys.stdout.flush()
            hint = did_you_mean(name, state.nodes())
            print(f"cannot contact [{name}]: unknown node{hint}", file=sys.stderr)
        elif not options.quiet:
            _contact(graph, state, uri)


def _facts(graph: Graph, state: SystemState, name: str, *, contact: bool) -> dict[str, Any]:
    registered = state.of_node(name)
    facts: dict[str, Any] = {
        "node": name,
        "uri": graph.node_uri(name),
        "publishes": registered.publications,
        "subscribes": registered.subscriptions,
        "services": registered.services,
    }
    if facts["uri"] is None:
        raise CommandError(f"unknown node {name}{did_you_mean(name, state.nodes())}")
    if contact:
        node = graph.node(facts["uri"])
        try:
            facts["pid"] = node.pid()
            facts["connections"] = [connection._asdict() for connection in node.connections()]
        except (UnreachableError, DeadlineError) as error:
            facts["error"] = str(error)
        finally:
            node.close()
    return facts


def description(name: str, state: SystemState, types: dict[str, str]) -> str:
    """What the master knows of a node, as ``node info`` prints it."""
    node = state.of_node(name)

    def block(title: str, entries: list[str]) -> str:
        return f"{title}: None\n" if not entries else f"{title}: \n" + "".join(f" * {entry}\n" for entry in entries)

    def typed(topics: list[str]) -> list[str]:
        return [f"{topic} [{types.get(topic, 'unknown type')}]" for topic in topics]

    return "\n".join(
        [
            f"Node [{name}]\n" + block("Publications", typed(node.publications)),
            block("Subscriptions", typed(node.subscriptions)),
            block("Services", node.services),
        ]
    )


def _contact(graph: Graph, state: SystemState, uri: str) -> None:
    print(f"\ncontacting node {uri} ...")
    node = graph.node(uri)
    try:
        pid, connections = node.pid(), node.connections()
    except (UnreachableError, DeadlineError):
        raise CommandError(f"Communication with node[{uri}] failed!") from None
    finally:
        node.close()
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


def machine(invocation: Invocation) -> None:
    """``node machine [host]`` (L74)."""
    parser = invocation.parser("machine [machine-name]")
    invocation.add_json(parser, "print a JSON list: machines, or the nodes of one")
    options, args = parser.parse_args(invocation.args)
    if len(args) > 1:
        parser.error("please enter only one machine name")
    graph = invocation.graph
    hosts: dict[str, str] = {}
    for name in graph.state().nodes():
        uri = graph.node_uri(name)
        if uri:
            hosts[name] = parse_uri(uri)[0]
    if not args:
        _print_names(set(hosts.values()), options.json)
        return
    wanted = _addresses(args[0])
    if not wanted:
        raise CommandError(f"cannot resolve machine name [{args[0]}] to address")
    here = {host for host in set(hosts.values()) if host == args[0] or _addresses(host) & wanted}
    _print_names((name for name, host in hosts.items() if host in here), options.json)


def _print_names(names: Iterable[str], json: bool) -> None:
    if json:
        print_json(sorted(names))
    else:
        print(*sorted(names), sep="\n")


def _addresses(host: str) -> set[str]:
    try:
        return {str(entry[4][0]) for entry in socket.getaddrinfo(host, 0, proto=socket.IPPROTO_TCP)}
    except OSError:
        return set()


def _reach(invocation: Invocation) -> int | None:
    from pyros1.cli import node_reach  # noqa: PLC0415 - the other verbs do without

    verbs = {"ping": node_reach.ping, "kill": node_reach.kill, "cleanup": node_reach.cleanup}
    return verbs[invocation.verb](invocation)


def _tree(invocation: Invocation) -> None:
    from pyros1.cli.node_tree import tree  # noqa: PLC0415 - as above

    tree(invocation)


def _control(invocation: Invocation) -> None:
    from pyros1.cli import node_control  # noqa: PLC0415 - the other verbs do without

    verbs = {
        "status": node_control.status,
        "stop": node_control.stop,
        "start": node_control.start,
        "restart": node_control.restart,
    }
    verbs[invocation.verb](invocation)


_VERBS = {
    "list": list_nodes,
    "info": info,
    "machine": machine,
    "tree": _tree,
    **dict.fromkeys(("ping", "kill", "cleanup"), _reach),
    **dict.fromkeys(("status", "stop", "start", "restart"), _control),
}


def main(argv: list[str]) -> int:
    """Run ``node <verb> ...``; returns the exit code."""
    return run("rosnode", argv, _VERBS, usage)
