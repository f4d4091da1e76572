"""``node machine``: prints on which machines nodes run (L74)."""

from __future__ import annotations

import socket
import sys
from collections.abc import Iterable
from typing import Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.errors import ProtocolError
from pyros1.net.hosts import parse_uri


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the machines that nodes run on, or the nodes on one machine."""
    if len(args) > 1:
        raise UsageError("please enter only one machine name")
    graph = invocation.graph
    hosts_by_node: dict[str, str] = {}
    for name in graph.state().nodes():
        uri = graph.node_uri(name)
        if uri:
            try:
                hosts_by_node[name] = parse_uri(uri)[0]
            except ProtocolError as error:
                print(f"WARNING: {name} is left out: {error}", file=sys.stderr)
    if not args:
        _print_names(set(hosts_by_node.values()), as_json=options.json)
        return
    addresses = _resolve(args[0])
    if not addresses:
        raise CommandError(f"cannot resolve machine name [{args[0]}] to address")
    machine_hosts = {host for host in set(hosts_by_node.values()) if host == args[0] or _resolve(host) & addresses}
    _print_names((name for name, host in hosts_by_node.items() if host in machine_hosts), as_json=options.json)


VERB = Verb(
    "machine",
    "list nodes running on a particular machine or list machines",
    Flag("--json", help="print a JSON list: machines, or the nodes on one machine", pyros1_only=True),
    Argument("machine-name", "machine", optional=True),
    usage="[machine-name]",
    examples=[("", "list the machines that nodes run on"), ("robot1", "list the nodes on one machine")],
    run=run,
)


def _print_names(names: Iterable[str], *, as_json: bool) -> None:
    if as_json:
        print_json(sorted(names))
    else:
        print(*sorted(names), sep="\n")


def _resolve(host: str) -> set[str]:
    try:
        return {str(entry[4][0]) for entry in socket.getaddrinfo(host, 0, proto=socket.IPPROTO_TCP)}
    except OSError:
        return set()
