"""``node cleanup``: removes the registrations of nodes that do not respond (L75)."""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

from pyros1.cli.commands.node._ping_failures import PING_TIMEOUT, failure_reason
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import MASTER_TIMEOUT, Invocation
from pyros1.cli.records import Verb
from pyros1.graph import Graph
from pyros1.ground.errors import Error, MasterError


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Ask for confirmation, then unregister nodes that do not respond."""
    if args:
        raise UsageError("too many arguments")
    graph = invocation.graph
    from pyros1.doctor.concurrent import run_concurrently  # noqa: PLC0415 - not needed for help

    names = graph.state().nodes()
    results = run_concurrently({name: partial(_is_responding, graph, name) for name in names}, PING_TIMEOUT + 1.0)
    for result in results.values():
        if isinstance(result, MasterError):
            raise result  # without the master, it is unknown which nodes respond
    unresponsive_names = [name for name, result in results.items() if result is not True]
    if not unresponsive_names:
        return
    print("Unable to contact the following nodes:\n" + "\n".join(f" * {name}" for name in unresponsive_names))
    print("Warning: these might include alive and functioning nodes, e.g. in unstable networks.")
    print("Cleanup will purge all information about these nodes from the master.")
    print("Please type y or n to continue:", flush=True)
    while True:
        line = sys.stdin.readline()
        answer = line.strip()
        if answer == "y":
            break
        if answer == "n" or not line:
            print("aborting")
            return
        print("Please type y or n to continue:", flush=True)
    for name in unresponsive_names:
        print(f"Unregistering {name}")
        _unregister(invocation, graph, name)
    print("done")


VERB = Verb(
    "cleanup",
    "purge registration information of unreachable nodes",
    examples=[("", "unregister nodes that do not respond, after asking for confirmation")],
    run=run,
)


def _is_responding(graph: Graph, node_name: str) -> bool:
    uri = graph.node_uri(node_name)
    if uri is None:
        return True  # the node has unregistered in the meantime
    node_api = graph.node_api(uri, PING_TIMEOUT)
    try:
        node_api.pid()
    except Error as error:
        # One write, so that the lines of nodes that are pinged concurrently do not mix.
        sys.stderr.write(f"ERROR: {failure_reason(error, node_name, uri)}\n")
        return False
    finally:
        node_api.close()
    return True


def _unregister(invocation: Invocation, graph: Graph, node_name: str) -> None:
    """Remove all registrations of a node from the master, on the node's behalf."""
    from pyros1.net.master_client import MasterClient  # noqa: PLC0415

    uri = graph.node_uri(node_name)
    if uri is None:
        return
    registrations = graph.state().of_node(node_name)
    master_calls: list[tuple[str, list[str]]] = [
        ("unregisterPublisher", [topic, uri]) for topic in registrations.publications
    ]
    master_calls += [("unregisterSubscriber", [topic, uri]) for topic in registrations.subscriptions]
    for service in registrations.services:
        service_uri = graph.service_uri(service)
        if service_uri:
            master_calls.append(("unregisterService", [service, service_uri]))
    master = MasterClient(node_name, invocation.master.uri, timeout=MASTER_TIMEOUT)
    try:
        for method, arguments in master_calls:
            master.call(method, *arguments)
    finally:
        master.close()
