"""``node kill``: asks nodes to shut down (L74)."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.graph import Graph
from pyros1.ground.errors import DeadlineError, Error, ProtocolError


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Make nodes shut down. Return 1 if one could not be shut down, otherwise 0."""
    if options.all and args:
        raise UsageError("invalid arguments with kill all (-a) option")
    graph = invocation.graph
    running_names = graph.state().nodes()
    if options.all:
        names = running_names
    elif args:
        names = [invocation.resolve(arg) for arg in args]
        unknown_names = [name for name in names if name not in running_names]
        if unknown_names:
            raise CommandError(
                "Unknown node(s):\n"
                + "\n".join(f" * {name}{did_you_mean(name, running_names)}" for name in unknown_names)
            )
    else:
        chosen_name = _choose_node(sorted(running_names))
        if chosen_name is None:
            return 0
        names = [chosen_name]
    if len(names) > 1:
        print("killing:\n" + "\n".join(f" * {name}" for name in names))
    else:
        print(f"killing {names[0]}" if names else "killing:")
    failed_names = [name for name in names if not _shut_down(graph, name)]
    if failed_names:
        sys.stdout.flush()
        print("ERROR: Failed to kill:\n" + "\n".join(f" * {name}" for name in failed_names), file=sys.stderr)
        return 1
    print("killed")
    return 0


VERB = Verb(
    "kill",
    "kill a running node",
    Flag("-a", "--all", help="kill all nodes"),
    Argument("node", "node", repeatable=True, optional=True),
    usage="[node]...",
    examples=[("/talker", "ask a node to shut down")],
    run=run,
)


def _choose_node(names: list[str]) -> str | None:
    """Ask the user for the number of a node. Return its name, or None if there are no nodes or the input ends."""
    if not names:
        print("No nodes running")
        return None
    print("".join(f"{number}. {name}\n" for number, name in enumerate(names, 1)))
    print("Please enter the number of the node you wish to kill.\n> ", end="", flush=True)
    while True:
        line = sys.stdin.readline()
        if not line:
            return None
        if line.strip().isdecimal() and 1 <= int(line) <= len(names):
            return names[int(line) - 1]
        print("ERROR: please enter a number (ctrl-C to cancel)", flush=True)


def _shut_down(graph: Graph, node_name: str) -> bool:
    uri = graph.node_uri(node_name)
    if uri is None:
        return False
    try:
        node_api = graph.node_api(uri)
    except ProtocolError as error:  # the node's address is invalid; the other nodes are still shut down
        print(f"[{node_name}]: {error}", file=sys.stderr)
        return False
    try:
        node_api.shutdown("user request")
    except DeadlineError as error:
        print(f"[{node_name}]: {error}; if its process hangs, use kill -9", file=sys.stderr)
        return False
    except Error:
        # The node exited before it responded, or was already dead: rosnode prints killed in both cases.
        return True
    finally:
        node_api.close()
    return True
