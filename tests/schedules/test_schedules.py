"""All scenes, each with some dozens of schedules; `python -m tests.schedules.exploring` plays many more."""

from __future__ import annotations

import pytest

from .exploring import at_random, with_deviations
from .scenes.every import SHARES
from .stage import Scenario

RANDOM, DEVIATING = 0.15, 0.1
"""Schedules of a scene: this times its share."""
SLOW = 5
"""The share of scenes that take long."""


@pytest.mark.parametrize("scene", SHARES, ids=lambda scene: scene.__name__)
def test_every_schedule_keeps_the_promises(scene: type[Scenario]) -> None:
    at_random(scene(), max(1, round(RANDOM * SHARES[scene])))
    if SHARES[scene] > SLOW:
        with_deviations(scene(), max(1, round(DEVIATING * SHARES[scene])), bound=1)
