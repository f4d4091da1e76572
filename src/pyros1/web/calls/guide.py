"""Calls for the guide, the same as ``pyros1 guide`` shows in a terminal."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.guide import text
from pyros1.web.robot import Robot


def steps(robot: Robot, args: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the steps of the guide: number, name, title, and blocks, see `pyros1.guide.text.Block`."""
    return [
        {
            "number": step.number,
            "name": step.name,
            "title": step.title,
            "blocks": [block._asdict() for block in step.blocks],
        }
        for step in text.steps()
    ]


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {"steps": steps}
CHANGES: frozenset[str] = frozenset()
