"""``node list``: prints the registered nodes (L70)."""

from __future__ import annotations

from functools import partial
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.graph import names_in_namespace
from pyros1.ground.terminal_text import one_line


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print the registered nodes. Return 1 if ``--check`` is given and a node is not alive, otherwise 0."""
    if len(args) > 1:
        raise UsageError("invalid args: you may only specify one namespace")
    namespace = invocation.resolve(args[0]) if args else None
    graph = invocation.graph
    names = sorted(names_in_namespace(graph.state().nodes(), namespace))
    if options.json or options.check:
        uris = {name: graph.node_uri(name) for name in names}
        states = _check_nodes(invocation, uris) if options.check else {}
        if options.json:
            print_json([{"node": name, "uri": uris[name], **states.get(name, {})} for name in names])
        else:
            _print_states(states)
        return int(any(state["state"] != "alive" for state in states.values()))
    if options.all:
        names = [f"{graph.node_uri(name) or 'unknown address'} \t{name}" for name in names]
    elif options.uris:
        names = [graph.node_uri(name) or f"unknown address {name}" for name in names]
    print(*names, sep="\n")
    return 0


def _print_states(states: dict[str, dict[str, str]]) -> None:
    width = max(map(len, states), default=0)
    for name, state in states.items():
        print(f"{name:{width}}  {state['state']}" + (f": {state['reason']}" if state["reason"] else ""))


def _check_nodes(invocation: Invocation, uris: dict[str, str | None]) -> dict[str, dict[str, str]]:
    """Return each node's state and the reason for it, by node. All nodes are contacted concurrently."""
    from pyros1.doctor.concurrent import run_concurrently  # noqa: PLC0415
    from pyros1.doctor.facts import HANGS, REFUSED, Failure  # noqa: PLC0415
    from pyros1.doctor.probe import NODE_TIMEOUT, probe_node  # noqa: PLC0415 - only for --check

    caller_id = invocation.master.caller_id
    results = run_concurrently(
        {name: partial(probe_node, caller_id, uri) for name, uri in uris.items() if uri}, NODE_TIMEOUT + 0.5
    )
    states = {}
    for name, result in results.items():
        if result is None:
            states[name] = {"state": "alive", "reason": ""}
        elif isinstance(result, Failure) and result.kind == REFUSED:
            states[name] = {"state": "dead", "reason": "its port is closed"}
        elif isinstance(result, Failure) and result.kind == HANGS:
            states[name] = {
                "state": "hangs",
                "reason": f"it accepts connections, but did not answer within {NODE_TIMEOUT:g} s",
            }
        else:
            text = result.text if isinstance(result, Failure) else str(result)
            states[name] = {"state": "unreachable", "reason": one_line(text)}
    return states


VERB = Verb(
    "list",
    "list active nodes",
    Flag("-u", dest="uris", help="list XML-RPC URIs"),
    Flag("-a", "--all", help="list all information"),
    Flag(
        "--check",
        help="ask each node whether it is alive; exit with 1 if one is dead, hangs or is unreachable",
        pyros1_only=True,
    ),
    Flag("--json", help="print a JSON list of objects: node, uri; with --check: state, reason", pyros1_only=True),
    Argument("/namespace", "namespace", optional=True),
    usage="",
    examples=[
        ("", "list all nodes"),
        ("-a", "list all nodes with their addresses"),
        ("--check", "print which nodes are alive, hanging or dead"),
    ],
    run=run,
)
