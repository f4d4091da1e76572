"""Draws the files and nodes of a plan as a text tree, or as a graph for Graphviz."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator

from pyros1.launch.plan import NodePlan, Plan


def tree_text(plan: Plan) -> str:
    """Return a plan's files and nodes as an indented tree, in the order in which the files were read.

    The content of a file, including its included files, is printed only where the file occurs first.
    """
    visited: set[str] = set()
    return "\n".join(line for top in _top_files(plan) for line in _branch(plan, top, "", visited))


def _top_files(plan: Plan) -> list[str]:
    included = {include.included for include in plan.includes}
    return list(dict.fromkeys(file for file in plan.files if file not in included))


def _branch(plan: Plan, file: str, indent: str, visited: set[str]) -> Iterator[str]:
    if file in visited:
        yield f"{_relative_path(file)} (see above)"
        return
    visited.add(file)
    yield _relative_path(file)
    lines_and_items: list[tuple[int, str | NodePlan]] = [
        (node.line, node) for node in _nodes(plan) if node.file == file
    ]
    includes = dict.fromkeys((include.line, include.included) for include in plan.includes if include.file == file)
    lines_and_items += includes
    lines_and_items.sort(key=lambda row: row[0])
    for index, (_, item) in enumerate(lines_and_items):
        is_last = index == len(lines_and_items) - 1
        prefix, child_indent = (indent + "└── ", indent + "    ") if is_last else (indent + "├── ", indent + "│   ")
        if isinstance(item, NodePlan):
            yield prefix + _describe(item)
        else:
            first, *following = _branch(plan, item, child_indent, visited)
            yield prefix + first
            yield from following


def dot_text(plan: Plan) -> str:
    """Return a plan's files, nodes and machines in Graphviz's dot language, as boxes, ellipses and clusters.

    Arrows point from a file to the files that it includes and to its nodes. Dashed arrows point from a node to what it
    waits for.
    """
    lines = ["digraph launch {", "  rankdir=LR;"]
    lines += [
        f"  {_quote(file)} [shape=box, label={_quote(_relative_path(file))}];" for file in dict.fromkeys(plan.files)
    ]
    machines: dict[str | None, list[str]] = {}
    for node in _nodes(plan):
        label = f"{node.full_name}\\n{node.package}/{node.type}"
        text = f"{_quote(node.full_name)} [label={_quote(label)}];"
        machines.setdefault(node.machine, []).append(text)
    for number, (machine, texts) in enumerate(machines.items()):
        if machine is None:
            lines += [f"  {text}" for text in texts]
        else:
            lines += [f"  subgraph cluster_{number} {{", f"    label={_quote(machine)};"]
            lines += [*(f"    {text}" for text in texts), "  }"]
    edges = [(include.file, include.included, "") for include in plan.includes]
    edges += [(node.file, node.full_name, "") for node in _nodes(plan)]
    for node in _nodes(plan):
        for condition in node.wait_for:
            target = condition.name if condition.kind == "node" else str(condition)
            edges.append((node.full_name, target, " [style=dashed]"))
    lines += [f"  {_quote(start)} -> {_quote(end)}{style};" for start, end, style in dict.fromkeys(edges)]
    return "\n".join([*lines, "}"])


def _nodes(plan: Plan) -> list[NodePlan]:
    return [*plan.nodes, *plan.tests]


def _describe(node: NodePlan) -> str:
    notes = [name for name in ("required", "respawn") if getattr(node.exit_policy, name)]
    notes += [f"on {node.machine}"] if node.machine else []
    notes += [f"after {' '.join(map(str, node.wait_for))}"] if node.wait_for else []
    notes += [f"on death: {node.on_death}"] if node.on_death else []
    return f"{node.full_name} ({node.package}/{node.type})" + (f" [{', '.join(notes)}]" if notes else "")


def _relative_path(file: str) -> str:
    relative = os.path.relpath(file)
    return file if relative.startswith("..") else relative


def _quote(text: str) -> str:
    # Graphviz reads \" and \n as JSON does; everything else is literal.
    return json.dumps(text, ensure_ascii=False).replace("\\\\n", "\\n")
