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

from pyros1.cli.common import CommandError, Invocation, no_master, quiet_pipe, report
from pyros1.doctor.edges import Edge, actual_edges
from pyros1.doctor.together import together
from pyros1.errors import Error, MasterUnreachableError
from pyros1.graph import Connection, Graph

_NODE_TIMEOUT = 2.0
_PERIOD = 1.0


def usage(program: str) -> str:
    """What the tool is for."""
    text = f"{program} is a command-line tool for debugging the ROS Computation Graph.\n\nUsage:\n\t{program}\n"
    if program == "rosgraph":
        return text
    return f"""{text}
Prints nodes, their connections and services, each second until it is interrupted.

Options:
\t--once      print once
\t--json      print one line of JSON
\t--dot       print the graph in Graphviz's language
\t--svg FILE  draw the graph, where Graphviz is installed
"""


def main(argv: list[str]) -> int:
    """Run ``graph``.

    Args:
        argv: the words behind.

    Returns:
        The exit code.
    """
    invocation = Invocation("rosgraph", ["graph", *argv])
    words = invocation.args
    if words in (["-h"], ["--help"]):
        print(usage(invocation.program))
        return 0
    drawing = len(words) == 2 and words[0] == "--svg"
    if words and not drawing and words not in (["--once"], ["--json"], ["--dot"]):
        print(usage(invocation.program))
        return 255
    try:
        _run(invocation, *words)
    except KeyboardInterrupt:
        pass
    except BrokenPipeError:
        quiet_pipe()
    except MasterUnreachableError as error:
        return report(no_master(error), 0 if invocation.program == "rosgraph" else 1)
    except Error as error:
        return report(str(error), 1)
    finally:
        invocation.close()
    return 0


def _run(invocation: Invocation, how: str = "", file: str = "") -> None:
    while True:
        picture = Picture(invocation.graph)
        if how == "--svg":
            _draw(picture.dot(), file)
        elif how == "--json":
            print(json.dumps(picture.as_json(), ensure_ascii=False))
        else:
            print(picture.dot() if how == "--dot" else picture.text(), flush=True)
            for name in picture.silent:
                print(f"WARNING: {name} does not answer; see: pyros1 wtf", file=sys.stderr)
        if how:
            return
        time.sleep(_PERIOD)


class Picture:
    """The system at one moment.

    Args:
        graph: asked for everything at once.

    Attributes:
        nodes, services: names, sorted.
        edges: connections, as the nodes tell of them.
        silent: nodes that did not answer.
    """

    def __init__(self, graph: Graph) -> None:
        state = graph.state()
        self.nodes = sorted(state.nodes())
        self.services = sorted(state.services)
        uris = {name: uri for name in self.nodes if (uri := graph.node_uri(name)) is not None}
        answers = together({name: partial(_connections, graph, uri) for name, uri in uris.items()}, _NODE_TIMEOUT)
        self.silent = [name for name, answer in answers.items() if isinstance(answer, Exception)]
        told = {name: answer for name, answer in answers.items() if not isinstance(answer, Exception)}
        topics = {*state.publishers, *state.subscribers}
        self.edges = sorted(
            {edge for edges in actual_edges(told, uris).values() for edge in edges if edge.topic in topics}
        )

    def text(self) -> str:
        """The listing of the stock tool."""
        lines = ["", "", "Nodes:"]
        for node in self.nodes:
            inbound = {edge.publisher for edge in self.edges if edge.subscriber == node}
            outbound = {edge.subscriber for edge in self.edges if edge.publisher == node}
            lines += [f"  {node} :", "    Inbound:", *_indented(inbound), "    Outbound:", *_indented(outbound)]
        return "\n".join([*lines, "Services:", *(f"  {name}" for name in self.services)])

    def as_json(self) -> dict[str, Any]:
        """The same for programs."""
        edges = [edge._asdict() for edge in self.edges]
        return {"nodes": self.nodes, "edges": edges, "services": self.services, "silent": self.silent}

    def dot(self) -> str:
        """The same in Graphviz's language: nodes are ellipses, arrows bear their topic; who is silent is dashed."""
        lines = ["digraph system {", "  rankdir=LR;"]
        for node in self.nodes:
            lines.append(f"  {json.dumps(node)}{' [style=dashed]' if node in self.silent else ''};")
        for edge in self.edges:
            lines.append(f"  {json.dumps(edge.publisher)} -> {json.dumps(edge.subscriber)} [label={_label(edge)}];")
        return "\n".join([*lines, "}"])


def _label(edge: Edge) -> str:
    return json.dumps(edge.topic, ensure_ascii=False)


def _indented(names: Iterable[str]) -> list[str]:
    return [f"      {name}" for name in sorted(names)]


def _connections(graph: Graph, uri: str) -> list[Connection]:
    node = graph.node(uri, _NODE_TIMEOUT)
    try:
        return node.connections()
    finally:
        node.close()


def _draw(dot: str, file: str) -> None:
    program = shutil.which("dot")
    if program is None:
        raise CommandError("drawing needs Graphviz's program dot; --dot prints what it would draw")
    done = subprocess.run([program, "-Tsvg", "-o", file], input=dot.encode(), capture_output=True, check=False)
    if done.returncode:
        raise CommandError(f"dot cannot draw {file}: {done.stderr.decode(errors='replace').strip()}")
