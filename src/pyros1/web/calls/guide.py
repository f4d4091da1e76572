"""Calls for the guide, the same as ``pyros1 guide`` shows in a terminal."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.guide import text
from pyros1.web.robot import Robot


def _blocks(page: text.GuideStep | text.GuidePage) -> list[dict[str, Any]]:
    return [block._asdict() for block in page.blocks]


def steps(robot: Robot, args: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the steps of the guide: number, name, title, heading, and blocks, see `pyros1.guide.text.Block`."""
    return [
        {
            "number": step.number,
            "name": step.name,
            "title": step.title,
            "heading": step.heading,
            "blocks": _blocks(step),
        }
        for step in text.steps()
    ]


def pages(robot: Robot, args: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the how-to pages: name, heading, and blocks, see `pyros1.guide.text.Block`."""
    return [{"name": page.name, "heading": page.heading, "blocks": _blocks(page)} for page in text.pages().values()]


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {"steps": steps, "pages": pages}
CHANGES: frozenset[str] = frozenset()
