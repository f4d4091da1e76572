"""``pyros1 graph``: rosgraph (L177)."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable
from functools import partial
from typing import Any

from pyros1.cli.failures import CommandError, no_master
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_words
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
    """Print the graph every second, or once in another form."""
    if args in (["-h"], ["--help"]):
        print(_usage(invocation))
        return 0
    to_file = len(args) == 2 and args[0] in ("--svg", "--dot")
    if args and not to_file and args not in (["--once"], ["--json"], ["--dot"]):
        print(_usage(invocation))
        return 255
    try:
        _print(invocation, *args)
    except KeyboardInterrupt:
        pass
    except MasterUnreachableError as error:
        return no_master(error, 0 if invocation.as_stock else 1)
    return 0


_VERB = Verb(
    "",
    "",
    Flag("--once", help="print once", own=True),
    Flag("--json", help="print one line of JSON", own=True),
    Flag("--dot", metavar="[FILE]", help="the graph in the dot language of Graphviz, printed or in a file", own=True),
    Option("--svg", metavar="FILE", help="draw the graph to a file; needs Graphviz", own=True),
    examples=[
        ("--once", "nodes, their connections and services"),
        ("--svg graph.svg", "an image of them"),
        ("--json", "for programs"),
    ],
    parse=leave_words,
    run=run,
)
COMMAND = Command("graph", "print nodes and their connections", _VERB, group="look", stock="rosgraph")


def _usage(invocation: Invocation) -> str:
    program = invocation.program
    text = f"{program} is a command-line tool for debugging the ROS Computation Graph.\n\nUsage:\n\t{program}\n"
    if invocation.as_stock:
        return text
    rows = {" ".join([*each.names, *each.settings.get("metavar", "").split()]): each.help for each in _VERB.options}
    listed = "".join(f"\t{option:12}  {about}\n" for option, about in rows.items())
    return (
        f"{text}\nPrints nodes, their connections and services every second, until interrupted.\n\n"
        f"Options:\n{listed}{_VERB.examples_text(program, as_stock=False)}"
    )


def _print(invocation: Invocation, how: str = "", file: str = "") -> None:
    while True:
        picture = Picture(invocation.graph)
        if how == "--svg":
            _draw(picture.dot(), file)
        elif file:
            _write(file, picture.dot())
        elif how == "--json":
            print(json_text(json.dumps(picture.as_json(), ensure_ascii=False)))
        else:
            print(picture.dot() if how == "--dot" else picture.text(), flush=True)
            for name in picture.unreachable:
                print(f"WARNING: {name} does not answer; see: pyros1 wtf", file=sys.stderr)
        if how:
            return
        time.sleep(_PERIOD)


class Picture:
    """The state of the system at one moment.

    Args:
        graph: queries to the system. All are made in the constructor.

    Attributes:
        nodes, services: names, sorted.
        edges: connections that the nodes report.
        missing: connections expected from the registrations that their nodes do not report.
        unknown: connections expected from the registrations, with a node that did not answer.
        unreachable: nodes that did not answer.
    """

    def __init__(self, graph: Graph) -> None:
        state = graph.state()
        self.nodes = sorted(state.nodes())
        self.services = sorted(state.services)
        uris = {name: uri for name in self.nodes if (uri := graph.node_uri(name)) is not None}
        answers = run_concurrently(
            {name: partial(_query_connections, graph, uri) for name, uri in uris.items()}, _NODE_TIMEOUT
        )
        self.unreachable = [name for name, answer in answers.items() if isinstance(answer, Exception)]
        reports = {name: answer for name, answer in answers.items() if not isinstance(answer, Exception)}
        topics = {*state.publishers, *state.subscribers}
        reported = actual_edges(reports, uris)
        self.edges = sorted({edge for edges in reported.values() for edge in edges if edge.topic in topics})
        expected = expected_edges(state)
        self.missing = {edge for edge in expected if is_missing_edge(edge, reported)}
        unreachable = {*self.unreachable}
        self.unknown = {edge for edge in expected if not unreachable.isdisjoint(edge[1:])}.difference(self.edges)

    def text(self) -> str:
        """Return the listing of the stock tool."""
        lines = ["", "", "Nodes:"]
        for node in self.nodes:
            inbound = {edge.publisher for edge in self.edges if edge.subscriber == node}
            outbound = {edge.subscriber for edge in self.edges if edge.publisher == node}
            lines += [f"  {node} :", "    Inbound:", *_indented(inbound), "    Outbound:", *_indented(outbound)]
        return "\n".join([*lines, "Services:", *(f"  {name}" for name in self.services)])

    def as_json(self) -> dict[str, Any]:
        """Return the same for JSON."""
        edges = [edge._asdict() for edge in self.edges]
        return {"nodes": self.nodes, "edges": edges, "services": self.services, "silent": self.unreachable}

    def dot(self) -> str:
        """Return the same in the dot language.

        Edges have topics as labels. Silent nodes and unknown edges are dashed, missing edges are dashed and red. The
        page of ``pyros1 web`` saves the same form (`web/page/lib/graph/model.js`).
        """
        lines = ["digraph system {", "  rankdir=LR;"]
        for node in self.nodes:
            lines.append(f"  {_quoted(node)}{' [style=dashed]' if node in self.unreachable else ''};")
        for edge in sorted({*self.edges, *self.missing, *self.unknown}):
            style = (
                ", color=red, style=dashed"
                if edge in self.missing
                else ", style=dashed"
                if edge in self.unknown
                else ""
            )
            facts = f"label={_quoted(edge.topic)}{style}"
            lines.append(f"  {_quoted(edge.publisher)} -> {_quoted(edge.subscriber)} [{facts}];")
        return "\n".join([*lines, "}"])


def _quoted(text: str) -> str:
    """Return a string of the dot language, where only quotation marks and backslashes are special."""
    return '"' + one_line(text).replace("\\", "\\\\").replace('"', '\\"') + '"'


def _indented(names: Iterable[str]) -> list[str]:
    return [f"      {name}" for name in sorted(names)]


def _query_connections(graph: Graph, uri: str) -> list[Connection]:
    node = graph.node(uri, _NODE_TIMEOUT)
    try:
        return node.connections()
    finally:
        node.close()


def _write(file: str, dot: str) -> None:
    try:
        write_atomically(file, f"{dot}\n")
    except OSError as error:
        raise CommandError(f"cannot write {one_line(file)}: {error.strerror}") from None


def _draw(dot: str, file: str) -> None:
    program = shutil.which("dot")
    if program is None:
        raise CommandError("drawing needs Graphviz (its program dot); --dot prints the graph as text")
    done = subprocess.run([program, "-Tsvg", "-o", file], input=dot.encode(), capture_output=True, check=False)
    if done.returncode:
        raise CommandError(f"dot cannot draw {file}: {done.stderr.decode(errors='replace').strip()}")
