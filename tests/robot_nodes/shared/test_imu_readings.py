"""The time between messages of an IMU, and which values are garbage."""

from __future__ import annotations

from math import inf, nan

import pytest

from pyros1.robot_nodes.shared.imu_readings import Reading, TimeSteps, UnusableReadingError, is_usable

SECOND = 1_000_000_000


def test_steps_are_the_differences_of_stamps() -> None:
    steps = TimeSteps()
    found = [steps.next(100 * SECOND + stamp) for stamp in (0, 10_000_000, 30_000_000, 30_000_000)]
    assert [step.seconds for step in found] == pytest.approx([0.0, 0.01, 0.02, 0.0])
    assert not any(step.problem or step.restart or step.ignore for step in found)


def test_the_period_may_be_constant() -> None:
    steps = TimeSteps(0.02)
    assert [steps.next(stamp).seconds for stamp in (0, 5 * SECOND, SECOND)] == [0.02] * 3


def test_without_stamps_the_user_is_told_what_to_do() -> None:
    step = TimeSteps().next(0)
    assert step.seconds == 0.0 and "set the parameter constant_dt" in step.problem


def test_jumps_of_time() -> None:
    steps = TimeSteps()
    steps.next(100 * SECOND)
    pause = steps.next(105 * SECOND)
    assert pause.seconds == 0.0 and "no IMU messages for 5.0 s" in pause.problem and not pause.restart
    late = steps.next(105 * SECOND - 20_000_000)
    assert late.ignore and "0.020 s older" in late.problem
    assert steps.next(105 * SECOND + 10_000_000).seconds == pytest.approx(0.01), "late messages do not move the time"
    back = steps.next(50 * SECOND)
    assert back.restart and back.seconds == 0.0 and "time has jumped back by 55.0 s" in back.problem
    assert steps.next(50 * SECOND + 10_000_000).seconds == pytest.approx(0.01)


@pytest.mark.parametrize("bad", [nan, inf, -inf, 1e300])
def test_garbage_is_not_usable(bad: float) -> None:
    for index in range(3):
        vector = tuple(bad if axis == index else 1.0 for axis in range(3))
        assert not is_usable(vector)  # type: ignore[arg-type]
        with pytest.raises(UnusableReadingError, match="angular velocity is not finite"):
            Reading(vector, (0.0, 0.0, 9.8)).check()  # type: ignore[arg-type]
        with pytest.raises(UnusableReadingError, match="linear acceleration is not finite"):
            Reading((0.0, 0.0, 0.0), vector).check()  # type: ignore[arg-type]
    Reading((0.0, -100.0, 0.0), (0.0, 0.0, -9.8)).check()
