"""``pyros1 graph``: prints nodes and their connections, like rosgraph (L177)."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable
from functools import partial
from typing import Any

from pyros1.cli.failures import CommandError, report_no_master
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_unparsed
from pyros1.cli.records import Command, Flag, Option, Verb
from pyros1.doctor.concurrent import run_concurrently
from pyros1.doctor.edges import actual_edges, expected_edges, is_missing_edge
from pyros1.graph import Connection, Graph
from pyros1.ground.atomic_file import write_atomically
from pyros1.ground.errors import MasterUnreachableError
from pyros1.ground.terminal_text import json_text, one_line

_NODE_TIMEOUT = 2.0
_PERIOD = 1.0


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print the graph every second, or once in another format. Return the exit code."""
    if args in (["-h"], ["--help"]):
        print(_usage(invocation))
        return 0
    writes_file = len(args) == 2 and args[0] in ("--svg", "--dot")
    if args and not writes_file and args not in (["--once"], ["--json"], ["--dot"]):
        print(_usage(invocation))
        return 255
    try:
        _print_graph(invocation, *args)
    except KeyboardInterrupt:
        pass
    except MasterUnreachableError as error:
        return report_no_master(error, 0 if invocation.as_stock else 1)
    return 0


_VERB = Verb(
    "",
    "",
    Flag("--once", help="print once", pyros1_only=True),
    Flag("--json", help="print one line of JSON", pyros1_only=True),
    Flag(
        "--dot",
        metavar="[FILE]",
        help="print the graph in the dot language of Graphviz, or write it to a file",
        pyros1_only=True,
    ),
    Option("--svg", metavar="FILE", help="draw the graph to a file; needs Graphviz", pyros1_only=True),
    examples=[
        ("--once", "print nodes, their connections and services"),
        ("--svg graph.svg", "draw the graph to an SVG file"),
        ("--json", "print JSON for programs"),
    ],
    parse=leave_unparsed,
    run=run,
)
COMMAND = Command("graph", "print nodes and their connections", _VERB, group="inspect", stock="rosgraph")


def _usage(invocation: Invocation) -> str:
    program = invocation.program
    text = f"{program} is a command-line tool for debugging the ROS Computation Graph.\n\nUsage:\n\t{program}\n"
    if invocation.as_stock:
        return text
    help_by_option = {
        " ".join([*option.names, *option.settings.get("metavar", "").split()]): option.help for option in _VERB.options
    }
    option_list = "".join(f"\t{names:12}  {about}\n" for names, about in help_by_option.items())
    return (
        f"{text}\nPrints nodes, their connections and services every second, until interrupted.\n\n"
        f"Options:\n{option_list}{_VERB.examples_text(program, as_stock=False)}"
    )


def _print_graph(invocation: Invocation, output_format: str = "", file: str = "") -> None:
    while True:
        snapshot = GraphSnapshot(invocation.graph)
        if output_format == "--svg":
            _draw_svg(snapshot.dot(), file)
        elif file:
            _write_dot_file(file, snapshot.dot())
        elif output_format == "--json":
            print(json_text(json.dumps(snapshot.as_json(), ensure_ascii=False)))
        else:
            print(snapshot.dot() if output_format == "--dot" else snapshot.text(), flush=True)
            for name in snapshot.unreachable_nodes:
                print(f"WARNING: {name} does not answer; see: pyros1 wtf", file=sys.stderr)
        if output_format:
            return
        time.sleep(_PERIOD)


class GraphSnapshot:
    """A snapshot of the system's nodes, connections and services.

    Args:
        graph: the object that queries the system. All queries are made in the constructor.

    Attributes:
        nodes: the sorted names of the nodes.
        services: the sorted names of the services.
        edges: the connections that nodes report.
        missing_edges: the connections that the registrations imply, but that at least one of their nodes does not
            report.
        unknown_edges: the connections that the registrations imply, but whose publisher or subscriber did not respond.
        unreachable_nodes: the names of the nodes that did not respond.
    """

    def __init__(self, graph: Graph) -> None:
        state = graph.state()
        self.nodes = sorted(state.nodes())
        self.services = sorted(state.services)
        uris = {name: uri for name in self.nodes if (uri := graph.node_uri(name)) is not None}
        results = run_concurrently(
            {name: partial(_query_connections, graph, uri) for name, uri in uris.items()}, _NODE_TIMEOUT
        )
        self.unreachable_nodes = [name for name, result in results.items() if isinstance(result, Exception)]
        connections_by_node = {name: result for name, result in results.items() if not isinstance(result, Exception)}
        topics = {*state.publishers, *state.subscribers}
        reported_edges = actual_edges(connections_by_node, uris)
        self.edges = sorted({edge for edges in reported_edges.values() for edge in edges if edge.topic in topics})
        implied_edges = expected_edges(state)
        self.missing_edges = {edge for edge in implied_edges if is_missing_edge(edge, reported_edges)}
        unreachable = {*self.unreachable_nodes}
        self.unknown_edges = {edge for edge in implied_edges if not unreachable.isdisjoint(edge[1:])}.difference(
            self.edges
        )

    def text(self) -> str:
        """Return the graph as text in the stock tool's format."""
        lines = ["", "", "Nodes:"]
        for node in self.nodes:
            inbound = {edge.publisher for edge in self.edges if edge.subscriber == node}
            outbound = {edge.subscriber for edge in self.edges if edge.publisher == node}
            lines += [
                f"  {node} :",
                "    Inbound:",
                *_indented_lines(inbound),
                "    Outbound:",
                *_indented_lines(outbound),
            ]
        return "\n".join([*lines, "Services:", *(f"  {name}" for name in self.services)])

    def as_json(self) -> dict[str, Any]:
        """Return the graph as a JSON object."""
        edges = [edge._asdict() for edge in self.edges]
        return {"nodes": self.nodes, "edges": edges, "services": self.services, "silent": self.unreachable_nodes}

    def dot(self) -> str:
        """Return the graph in the dot language.

        Edges are labelled with topics. Unreachable nodes and unknown edges are dashed; missing edges are dashed and
        red. The page of ``pyros1 web`` saves graphs in the same format (`web/page/lib/graph/model.js`).
        """
        lines = ["digraph system {", "  rankdir=LR;"]
        for node in self.nodes:
            lines.append(f"  {_quote(node)}{' [style=dashed]' if node in self.unreachable_nodes else ''};")
        for edge in sorted({*self.edges, *self.missing_edges, *self.unknown_edges}):
            style = (
                ", color=red, style=dashed"
                if edge in self.missing_edges
                else ", style=dashed"
                if edge in self.unknown_edges
                else ""
            )
            attributes = f"label={_quote(edge.topic)}{style}"
            lines.append(f"  {_quote(edge.publisher)} -> {_quote(edge.subscriber)} [{attributes}];")
        return "\n".join([*lines, "}"])


def _quote(text: str) -> str:
    """Return a string literal of the dot language, in which only quotation marks and backslashes are special."""
    return '"' + one_line(text).replace("\\", "\\\\").replace('"', '\\"') + '"'


def _indented_lines(names: Iterable[str]) -> list[str]:
    return [f"      {name}" for name in sorted(names)]


def _query_connections(graph: Graph, uri: str) -> list[Connection]:
    node_api = graph.node_api(uri, _NODE_TIMEOUT)
    try:
        return node_api.connections()
    finally:
        node_api.close()


def _write_dot_file(file: str, dot: str) -> None:
    try:
        write_atomically(file, f"{dot}\n")
    except OSError as error:
        raise CommandError(f"cannot write {one_line(file)}: {error.strerror}") from None


def _draw_svg(dot: str, file: str) -> None:
    program = shutil.which("dot")
    if program is None:
        raise CommandError("drawing needs Graphviz (its program dot); --dot prints the graph as text")
    result = subprocess.run([program, "-Tsvg", "-o", file], input=dot.encode(), capture_output=True, check=False)
    if result.returncode:
        raise CommandError(f"dot cannot draw {file}: {result.stderr.decode(errors='replace').strip()}")
