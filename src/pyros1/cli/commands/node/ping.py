"""``node ping``: measures how fast nodes respond (L73)."""

from __future__ import annotations

import itertools
import sys
import time
from typing import Any

from pyros1.cli.commands.node._ping_failures import PING_TIMEOUT, failure_reason
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.graph import Graph
from pyros1.ground.errors import Error, ProtocolError


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print whether and how fast nodes respond."""
    graph = invocation.graph
    if options.all:
        names = graph.state().nodes()
        print("Will ping the following nodes: \n" + "".join(f" * {name}\n" for name in names))
        for name in names:
            _ping(graph, name, 1)
        return
    if not args:
        _print_known_nodes(invocation, graph)
        raise UsageError("Please enter a node to ping")
    if len(args) > 1:
        raise UsageError("you may only specify one input node")
    name = invocation.resolve(args[0])
    print(f"{invocation.program}: node is [{name}]")
    _ping(graph, name, options.count, prints_average=True)


VERB = Verb(
    "ping",
    "test connectivity to node",
    Flag("-a", "--all", help="ping all nodes"),
    Option("-c", type="int", dest="count", metavar="COUNT", help="number of pings to send. Not available with --all"),
    Argument("node", "node"),
    usage="[options] <node>",
    examples=[("-c 3 /talker", "print whether and how fast a node responds"), ("-a", "ping all nodes")],
    run=run,
)


def _print_known_nodes(invocation: Invocation, graph: Graph) -> None:
    """Print the usage and the available nodes. The caller prints the error after them, as in stock ROS."""
    from pyros1.cli.help import Parser  # noqa: PLC0415 - only needed after a failure

    try:
        node_list = "\n".join(map(str, sorted(graph.state().nodes())))
    except Error:
        node_list = ""
    Parser(VERB, invocation).print_usage(sys.stderr)
    if node_list:
        hint = f"Please enter a node to ping. Available nodes are:\n{node_list}\n"
        print(f"{invocation.program}: error: {hint}", end="", file=sys.stderr)


def _ping(graph: Graph, node_name: str, count: int | None, prints_average: bool = False) -> bool:
    """Ping a node until it fails or the count is reached. Return whether the node always responded."""
    uri = graph.node_uri(node_name)
    if uri is None:
        sys.stdout.flush()
        print(f"cannot ping [{node_name}]: unknown node", file=sys.stderr)
        return False
    try:
        node_api = graph.node_api(uri, PING_TIMEOUT)
    except ProtocolError as error:  # an invalid address
        sys.stdout.flush()
        print(f"cannot ping [{node_name}]: {error}", file=sys.stderr)
        return False
    print(f"pinging {node_name} with a timeout of {PING_TIMEOUT}s")
    total_milliseconds, ping_count = 0.0, 0
    try:
        for number in itertools.count(1):
            milliseconds = node_api.ping() * 1000.0
            print(f"xmlrpc reply from {uri}\ttime={milliseconds:f}ms", flush=True)
            total_milliseconds, ping_count = total_milliseconds + milliseconds, number
            if count is not None and number >= count:
                break
            time.sleep(1.0)
    except KeyboardInterrupt:
        pass
    except Error as error:
        sys.stdout.flush()
        print(f"ERROR: {failure_reason(error, node_name, uri)}", file=sys.stderr)
        return False
    finally:
        node_api.close()
    if prints_average and ping_count > 1:
        print(f"ping average: {total_milliseconds / ping_count:f}ms")
    return True
