"""Write ``interop/features.md``: what works, and the test that shows it.

::

    python interop/features.py            # write the page
    python interop/features.py --check    # exit code 1 if it is not current

A test states its feature in a paragraph of its docstring, the module's or a function's::

    Feature: latched topics -- also for subscribers that connect later

What follows ``--`` are notes, whose links are relative to the project's root. Tests that state the same feature share
a row.
"""

from __future__ import annotations

import argparse
import ast
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "interop" / "features.md"

SECTIONS = {
    "Topics": "interop/topics tests/node/publishing tests/node/subscribing",
    "Nodes, services and the master": "interop/nodes tests/node tests/aio tests/master",
    "Messages": "tests/msgs",
    "rospy and other Python modules": "interop/modules tests/drop_in",
    "tf and robot models": "interop/tf",
    "Launch files": "interop/launch tests/launch",
    "Bags": "interop/bag tests/bag",
    "Commands": "interop/tools tests/cli tests/doctor tests/topic_tools",
    "The web page": "interop/web tests/web",
    "Several masters": "interop/bridge tests/bridge",
    "Nodes of robots": "tests/robot_nodes tests/web/rosbridge_server tests/web/web_video_server",
    "ROS 2": "interop/ros2 tests/ros2",
    "Networks and faults": "interop/hosts interop/faults tests/net tests/fuzz tests/schedules",
    "Packages, the guide and tests of your own": "tests/packages tests/guide tests/testing tests/turtlesim tests",
}
"""Headings, and the folders whose tests are below them; the longest path counts."""

BEGINNING = """# Features, and the tests that show them

Written by `interop/features.py` from the docstrings of the tests; not to be changed by hand. Tests in `interop` run
beside stock ROS 1.
"""


class Feature(NamedTuple):
    """A feature as one test states it.

    Attributes:
        name: the feature.
        notes: more about it; may be empty.
        test: ``file`` or ``file::test``.
    """

    name: str
    notes: str
    test: str


def stated(docstring: str, test: str) -> Iterator[Feature]:
    """Yield the features that a docstring states."""
    for paragraph in re.split(r"\n\s*\n", docstring):
        for text in re.split(r"^\s*Feature:", paragraph, flags=re.M)[1:]:
            name, _, notes = " ".join(text.split()).partition(" -- ")
            yield Feature(name, notes, test)


def features() -> list[Feature]:
    """Return the features of all tests, in the order of their files."""
    found = []
    for path in sorted([*(ROOT / "interop").rglob("test_*.py"), *(ROOT / "tests").rglob("test_*.py")]):
        text = path.read_text(encoding="utf-8")
        if "Feature:" not in text:
            continue
        file, tree = path.relative_to(ROOT).as_posix(), ast.parse(text)
        found += stated(ast.get_docstring(tree) or "", file)
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                found += stated(ast.get_docstring(node) or "", f"{file}::{node.name}")
    return found


def section_of(test: str) -> str:
    """Return the heading for a test."""
    folders = {folder: title for title, folders in SECTIONS.items() for folder in folders.split()}
    return folders[max((folder for folder in folders if test.startswith(f"{folder}/")), key=len)]


def relative_to_page(notes: str) -> str:
    """Return notes with their links to files made relative to the page."""
    return re.sub(r"\]\((?!\w+:)([^)]+)\)", lambda found: f"]({os.path.relpath(found[1], 'interop')})", notes)


def page() -> str:
    """Return the page."""
    rows: dict[str, list[Feature]] = {}
    for feature in features():
        rows.setdefault(feature.name, []).append(feature)
    lines = [BEGINNING]
    for title in SECTIONS:
        lines += [f"## {title}\n", "| feature | notes | test |", "|---|---|---|"]
        for name, stating in rows.items():
            if section_of(stating[0].test) == title:
                notes = relative_to_page("; ".join(filter(None, (each.notes for each in stating))))
                tests = ", ".join(f"`{each.test}`" for each in stating)
                lines.append(f"| {name} | {notes} | {tests} |".replace("|  |", "| |"))
        lines.append("")
    return "\n".join(lines)


def main() -> int:
    """Write or check the page; return the exit code."""
    parser = argparse.ArgumentParser(description="write interop/features.md")
    parser.add_argument("--check", action="store_true", help="only check that the page is current")
    if parser.parse_args().check:
        return int(PAGE.read_text(encoding="utf-8") != page())
    PAGE.write_text(page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
