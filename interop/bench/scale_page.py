"""The figures of scale.py as tables of Markdown, and as an HTML page with plots of what one more costs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from html import escape
from itertools import groupby
from typing import Any

from curves import Curve, curves
from page import STYLE, circumstances
from scale_master import Row
from table import markdown, number

TITLES = {
    "light": "Nodes that only speak XML-RPC",
    "nodes": "Nodes of pyros1, with rosout",
    "publisher": "One publisher with many subscribers",
    "subscriptions": "One node with many subscriptions",
    "relays": "A chain of relays",
}
COLUMNS: dict[str, dict[str, str]] = {
    "light": {
        "nodes": "nodes",
        "topics": "topics",
        "side": "master",
        "wall": "to register a node (ms)",
        "cpu": "its CPU (ms)",
        "longest": "longest call (ms)",
        "rss": "memory per node (kB)",
        "memory": "memory (MB)",
        "state_wall": "getSystemState, with decoding (ms)",
        "state": "its CPU (ms)",
        "state_again": "again, unchanged",
        "set": "setParam (ms CPU)",
        "get": "getParam",
        "lookup": "lookupNode",
        "names": "getParamNames",
        "told_wall": "all told of a publisher (ms)",
        "told_each": "CPU per subscriber (µs)",
    },
    "nodes": {
        "nodes": "nodes",
        "topics": "topics",
        "side": "master",
        "own_wall": "to start a node (ms)",
        "cpu": "master's CPU (ms)",
        "own_cpu": "node's CPU (ms)",
        "rss": "memory in the master (kB)",
        "own_rss": "in the node (kB)",
        "own_threads": "threads of a node",
        "memory": "master's memory (MB)",
        "idle": "idle master (% of a core)",
        "own_idle": "idle node (%)",
        "linked": "all linked to a new publisher (ms)",
        "linked_master": "master's CPU per link (µs)",
        "linked_publisher": "publisher's",
        "linked_subscriber": "subscriber's",
        "heard": "a message to all (ms)",
    },
    "publisher": {
        "side": "publisher",
        "links": "subscribers",
        "rate": "messages delivered per second",
        "cpu": "CPU per message (µs)",
        "share": "% of a core",
        "p50": "last has it, and answers (ms)",
        "p99": "99 %",
        "spread": "last after first (ms)",
    },
    "subscriptions": {
        "side": "node",
        "topics": "subscriptions",
        "linked": "all linked, from the program's start (s)",
        "cpu": "CPU until then (s)",
        "memory": "memory (MB)",
        "threads": "threads",
        "idle": "idle CPU (%)",
    },
    "relays": {
        "side": "relay",
        "relays": "relays",
        "whole": "round trip (µs)",
        "whole99": "99 %",
        "hop": "per relay (µs)",
        "cpu": "CPU per message and relay (µs)",
        "rss": "memory of a relay (MB)",
    },
}


def scaled(name: str) -> Callable[[Row], float]:
    """A figure divided by the number of nodes, in thousandths."""
    return lambda row: float(row[name]) / row["nodes"] * 1e3


def plain(name: str) -> Callable[[Row], float]:
    """A figure as it is."""
    return lambda row: float(row[name])


PLOTS: dict[str, dict[str, Callable[[Row], float]]] = {
    "light": {
        "Registering one more node: the master's CPU (ms)": plain("cpu"),
        "Registering one more node: time (ms)": plain("wall"),
        "Memory of one more node (kB)": plain("rss"),
        "getSystemState: CPU per node (µs)": scaled("state"),
        "Telling one subscriber of a publisher: CPU (µs)": plain("told_each"),
        "setParam of one value: CPU (ms)": plain("set"),
    },
    "nodes": {
        "Starting one more node: the master's CPU (ms)": plain("cpu"),
        "Starting one more node: its own CPU (ms)": plain("own_cpu"),
        "Starting one more node: time (ms)": plain("own_wall"),
        "Linking one subscriber to a new publisher: all CPU (µs)": lambda row: (
            float(row["linked_master"]) + float(row["linked_publisher"]) + float(row["linked_subscriber"])
        ),
        "The idle master, per node (thousandths of a % of a core)": scaled("idle"),
        "Memory of one more node, in its process (kB)": plain("own_rss"),
    },
}
PLOT_STYLE = """
div.plots { display: flex; flex-wrap: wrap; gap: 1rem } .ours { --kind: var(--roscpp) } .stock { --kind: var(--rospy) }
"""


def tables(rows: Sequence[Row]) -> str:
    """All parts as tables of Markdown."""
    texts = []
    for part, members in groupby(rows, lambda row: str(row["part"])):
        texts += [f"{TITLES[part]}\n", markdown(cells(part, list(members))), ""]
    return "\n".join(texts)


def cells(part: str, rows: Sequence[Row]) -> list[list[str]]:
    """The heads and the figures of a part."""
    columns = COLUMNS[part]
    return [[*columns.values()], *([cell(row.get(name)) for name in columns] for row in rows)]


def cell(value: Any) -> str:
    """A figure in a table."""
    if not isinstance(value, float):
        return "-" if value is None else str(value)
    return "-" if math.isnan(value) else number(value)


def page(report: dict[str, Any]) -> str:
    """The HTML page of a run."""
    parts = [
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>pyros1: scale</title><style>{STYLE}</style>',
        f"<style>{PLOT_STYLE}</style>",
        '<meta name="viewport" content="width=device-width"><h1>What more of everything costs</h1>',
        f'<p class="about">{escape(circumstances(report["about"]))}</p>',
        '<p class="legend"><span class="ours">● under our master</span><span class="stock">● under rosmaster</span>'
        "A cost that is flat does not grow with the number of nodes.</p>",
    ]
    for part, members in groupby(report["rows"], lambda row: str(row["part"])):
        rows = list(members)
        parts.append(f'<h2>{escape(TITLES[part])}</h2><div class="plots">')
        for title, value in PLOTS.get(part, {}).items():
            lines: dict[str, Curve] = {
                side: [(row["nodes"], value(row)) for row in rows if row["side"] == side]
                for side in dict.fromkeys(str(row["side"]) for row in rows)
            }
            parts.append(curves(title, lines, "nodes"))
        parts.append("</div>")
        heads, *figures = cells(part, rows)
        parts += ['<div class="wide"><table><tr>', *(f"<th>{escape(head)}</th>" for head in heads), "</tr>"]
        for line in figures:
            parts += ["<tr>", *(f"<td>{escape(text)}</td>" for text in line), "</tr>"]
        parts.append("</table></div>")
    return "\n".join([*parts, "</html>"]) + "\n"
