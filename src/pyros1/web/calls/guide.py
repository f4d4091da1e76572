"""Calls that return the guide, as ``pyros1 guide`` displays it in a terminal, and check its exercises."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pyros1.guide import checks, documents
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.service_calls import ServiceCalls


def _blocks(page: documents.GuideStep | documents.GuidePage) -> list[dict[str, Any]]:
    return [block._asdict() for block in page.blocks]


def steps(robot: Robot, args: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the guide's steps: number, name, title, heading and blocks (see `pyros1.guide.documents.Block`)."""
    return [
        {
            "number": step.number,
            "name": step.name,
            "title": step.title,
            "heading": step.heading,
            "blocks": _blocks(step),
        }
        for step in documents.steps()
    ]


def pages(robot: Robot, args: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the how-to pages: name, heading and blocks (see `pyros1.guide.documents.Block`)."""
    return [
        {"name": page.name, "heading": page.heading, "blocks": _blocks(page)} for page in documents.pages().values()
    ]


def check(robot: Robot, args: Mapping[str, Any], service_calls: ServiceCalls) -> dict[str, str]:
    """Check the exercise of a step, as ``pyros1 guide check`` does. Args: step (its number).

    Returns:
        ``missing``: what is still missing (empty if the exercise is done); ``folder``: the folder that was checked,
        which is the server's working directory.

    Raises:
        RequestError: the step does not exist, or the server restricts which topics pages can see (``--topics``).
        Error: the check failed, for example because there is no master.
    """
    step = args.get("step")
    if type(step) is not int or not 1 <= step <= len(checks.CHECKS):
        raise RequestError(f"step must be a number from 1 to {len(checks.CHECKS)}")
    if robot.access.topics:
        raise RequestError(
            f"this server shows only some topics (--topics): run pyros1 guide check {step} in a terminal"
        )
    folder = Path.cwd()
    missing = checks.check(step, {**os.environ, "ROS_MASTER_URI": robot.master_uri}, folder)
    return {"missing": missing, "folder": str(folder)}


CALLS: dict[str, Callable[..., Any]] = {"steps": steps, "pages": pages, "check": check}
CHANGES: frozenset[str] = frozenset({"check"})
"""Calls refused in read-only mode: some checks call services, send goals, or run the test that the reader wrote."""
