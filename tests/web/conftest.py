"""A robot of the web server, on a master of the test."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.node import Node
from pyros1.web.robot import Robot
from pyros1.web.server.access import Access

sys.path.insert(0, str(Path(__file__).parent))
from serving import PATIENCE, Served


@pytest.fixture
def make_robot(environ: dict[str, str]) -> Iterator[Callable[..., Robot]]:
    """Return a function that makes a robot, with the arguments of `Access`, and waits for its node."""
    robots: list[Robot] = []

    def make(**options: Any) -> Robot:
        made = threading.Event()

        def node() -> Node:
            try:
                return Node("web", argv=[], environ=environ, handle_signals=False, rosout=False, wait_for_master=0.0)
            finally:
                made.set()

        robot = Robot(environ["ROS_MASTER_URI"], Access(**options), node)
        robots.append(robot)
        robot.start()
        assert made.wait(PATIENCE)
        robot.wait_for_node(PATIENCE)
        return robot

    yield make
    for robot in robots:
        robot.close()


@pytest.fixture
def robot(make_robot: Callable[..., Robot]) -> Robot:
    """A robot that shows all."""
    return make_robot()


@pytest.fixture
def serve(make_robot: Callable[..., Robot]) -> Iterator[Callable[..., Served]]:
    """Return a function that makes a robot and serves it, with the arguments of `Access`."""
    servers: list[Served] = []

    def start(**options: Any) -> Served:
        robot = make_robot(**options)
        servers.append(Served(robot, robot.access))
        return servers[-1]

    yield start
    for server in servers:
        server.close()
