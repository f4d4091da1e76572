"""``node ping`` (L73)."""

from __future__ import annotations

import itertools
import sys
import time
from typing import Any

from pyros1.cli.commands.node._reach import PING_TIMEOUT, failure
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.graph import Graph
from pyros1.ground.errors import Error, ProtocolError


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print whether nodes answer, and how fast."""
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
    _ping(graph, name, options.count, forever=True)


VERB = Verb(
    "ping",
    "test connectivity to node",
    Flag("-a", "--all", help="ping all nodes"),
    Option("-c", type="int", dest="count", metavar="COUNT", help="number of pings to send. Not available with --all"),
    Argument("node", "node"),
    usage="[options] <node>",
    examples=[("-c 3 /talker", "whether it answers, and how fast"), ("-a", "all nodes")],
    run=run,
)


def _print_known_nodes(invocation: Invocation, graph: Graph) -> None:
    """Print usage and the available nodes. Stock prints its error again after them."""
    from pyros1.cli.help import Parser  # noqa: PLC0415 - only needed after a failure

    try:
        available = "\n".join(map(str, sorted(graph.state().nodes())))
    except Error:
        available = ""
    Parser(VERB, invocation).print_usage(sys.stderr)
    if available:
        hint = f"Please enter a node to ping. Available nodes are:\n{available}\n"
        print(f"{invocation.program}: error: {hint}", end="", file=sys.stderr)


def _ping(graph: Graph, name: str, count: int | None, forever: bool = False) -> bool:
    """Ping a node until an error. ``forever``: like the command for one node, with pauses and an average."""
    uri = graph.node_uri(name)
    if uri is None:
        sys.stdout.flush()
        print(f"cannot ping [{name}]: unknown node", file=sys.stderr)
        return False
    try:
        node = graph.node(uri, PING_TIMEOUT)
    except ProtocolError as error:  # a wrong address
        sys.stdout.flush()
        print(f"cannot ping [{name}]: {error}", file=sys.stderr)
        return False
    print(f"pinging {name} with a timeout of {PING_TIMEOUT}s")
    total, done = 0.0, 0
    try:
        for number in itertools.count(1):
            milliseconds = node.ping() * 1000.0
            print(f"xmlrpc reply from {uri}\ttime={milliseconds:f}ms", flush=True)
            total, done = total + milliseconds, number
            if count is not None and number >= count:
                break
            time.sleep(1.0)
    except KeyboardInterrupt:
        pass
    except Error as error:
        sys.stdout.flush()
        print(f"ERROR: {failure(error, name, uri)}", file=sys.stderr)
        return False
    finally:
        node.close()
    if forever and done > 1:
        print(f"ping average: {total / done:f}ms")
    return True
