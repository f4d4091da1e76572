"""Fixtures of the tests of faults: two hosts with a cable between them whose faults the test chooses."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))

from hosts import Host, Network
from wires import Wires


class Site(NamedTuple):
    """Two hosts, and the cables between them.

    Attributes:
        robot, laptop: the hosts.
        wires: the cables.
    """

    robot: Host
    laptop: Host
    wires: Wires


@pytest.fixture
def site() -> Iterator[Site]:
    """A robot and a laptop, for one test."""
    with Network() as network:
        robot, laptop = network.add("robot"), network.add("laptop")
        with Wires(robot, laptop) as wires:
            yield Site(robot, laptop, wires)
