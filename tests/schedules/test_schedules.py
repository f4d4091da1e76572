"""All scenes, each with some dozens of schedules; `python -m tests.schedules.exploring` plays many more.

Feature: correct whatever the order in which threads run -- the real parts on a scheduler that the test controls:
    seeded random orders, and all orders with few context switches
"""

from __future__ import annotations

import pytest

from .exploring import at_random, play, with_deviations
from .plans import FewDeviations, RandomPlan
from .scenes.bags import RecordingSplit
from .scenes.datagrams import Datagrams
from .scenes.every import SHARES
from .scenes.goals import LostLinks
from .scenes.lanes import RaisingLanes
from .scenes.nodes import Restarting
from .scenes.publishing import Closing, Ending, Joining
from .scenes.subscribing import Spinning, Within
from .scenes.web import Unsubscribing
from .scheduler import Plan
from .stage import Scenario, stage_for

pytestmark = pytest.mark.once

FAILED_BEFORE: list[tuple[type[Scenario], Plan]] = [
    (RaisingLanes, RandomPlan(66)),  # the rest of the jobs was forgotten when one raised
    (Ending, RandomPlan(114)),  # a frame was torn, as another thread had half of it on the wire
    (Joining, FewDeviations(((10, 1), (25, 2)))),  # a link was never closed: it came just when the publisher ended
    (Spinning, RandomPlan(12)),  # a message was counted as dropped that was just being taken
    (Closing, RandomPlan(200350)),  # the greeting was torn of a subscriber that came just when the publisher ended
    (Within, RandomPlan(200012)),  # as with Spinning, without a bound
    (Datagrams, RandomPlan(320153)),  # a publisher's last messages did not count as waiting
    (Restarting, RandomPlan(200007)),  # a node did not start, as the master ended between two of its calls
    (RecordingSplit, RandomPlan(63)),  # a recording had ended, but one of its messages did not count yet
    (LostLinks, FewDeviations()),  # what was lost with its link was waited for for ever
    (Unsubscribing, RandomPlan(436)),  # a viewer got a message after it had heard that the channel had gone
]
"""What many schedules have found, in Python 3.11."""
RANDOM, DEVIATING = 0.08, 0.04
"""Schedules of a scene: this times its share."""
SLOW = 5
"""The share of scenes that take long."""


@pytest.mark.slow
@pytest.mark.parametrize("scene", SHARES, ids=lambda scene: scene.__name__)
def test_every_schedule_keeps_the_promises(scene: type[Scenario]) -> None:
    at_random(scene(), max(1, round(RANDOM * SHARES[scene])))
    if SHARES[scene] > SLOW:
        with_deviations(scene(), max(1, round(DEVIATING * SHARES[scene])), bound=1)


@pytest.mark.parametrize(("scene", "plan"), FAILED_BEFORE, ids=lambda each: str(getattr(each, "__name__", each)))
def test_schedules_that_failed_before(scene: type[Scenario], plan: Plan) -> None:
    with stage_for(scene()) as stage:
        play(stage, scene(), FewDeviations())
        play(stage, scene(), plan)
