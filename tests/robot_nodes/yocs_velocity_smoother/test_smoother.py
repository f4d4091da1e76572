"""Limits of speed and acceleration, and what happens without input."""

from __future__ import annotations

import random
from collections.abc import Iterable

import pytest

from pyros1.robot_nodes.yocs_velocity_smoother.smoother import STANDSTILL, Feedback, Limits, Smoother, Velocity

LIMITS = Limits(Velocity(0.8, 5.4), Velocity(0.5, 4.0), 2.0)
PERIOD = 0.1


def drive(
    smoother: Smoother, commands: Iterable[Velocity | None], start: float = 0.0, period: float = PERIOD
) -> list[Velocity | None]:
    """Return what is published if these commands arrive, one before each step."""
    published = []
    for index, command in enumerate(commands):
        now = start + index * period
        if command is not None:
            smoother.command(command, now)
        published.append(smoother.step(now))
    return published


def forward(published: list[Velocity | None]) -> list[float | None]:
    return [None if velocity is None else round(velocity.forward, 9) for velocity in published]


def test_accelerating_and_braking() -> None:
    smoother = Smoother(LIMITS, PERIOD)
    published = drive(smoother, [Velocity(0.17, 0.0)] * 5 + [STANDSTILL] * 3)
    assert forward(published) == [0.05, 0.1, 0.15, 0.17, 0.17, 0.07, 0.0, 0.0]


def test_the_robot_stays_on_the_curve() -> None:
    published = drive(Smoother(LIMITS, PERIOD), [Velocity(0.5, 1.0)] * 10)
    assert forward(published)[-1] == 0.5
    for velocity in published:
        assert velocity is not None and velocity.turning == pytest.approx(2 * velocity.forward)


def test_speeds_are_limited() -> None:
    published = drive(Smoother(LIMITS, PERIOD), [Velocity(-9.0, 99.0)] * 60)
    assert published[-1] == Velocity(-0.8, 5.4)


@pytest.mark.parametrize(("period", "silence"), [(0.05, 0.15), (0.1, 0.3), (0.15, 0.45), (1.0, 0.5)])
def test_silence_stops_the_robot(period: float, silence: float) -> None:
    """Feature: velocity_smoother stops the robot when its input is silent"""
    smoother = Smoother(Limits(Velocity(9, 9), Velocity(0.5, 4.0)), 0.01)
    for index in range(5):
        smoother.command(Velocity(9.0, 0.0), index * period)
    end = 4 * period
    before = smoother.step(end + silence - 0.001)
    after = smoother.step(end + silence + 0.001)
    assert before is not None and after is not None and after.forward < before.forward
    published = drive(smoother, [None] * 3000, end + silence + 0.01, 0.01)
    assert STANDSTILL in [after, *published] and published[-1] is None


def test_nothing_is_published_at_rest() -> None:
    assert drive(Smoother(LIMITS, PERIOD), [None] * 5) == [None] * 5


def test_commands_at_the_same_time() -> None:
    """As in a simulation whose clock is slow."""
    smoother = Smoother(LIMITS, PERIOD)
    for _ in range(6):
        smoother.command(Velocity(0.5, 0.0), 10.0)
    assert forward(drive(smoother, [None] * 2, 10.0, 0.09)) == [0.05, 0.1]
    assert smoother.step(11.0) == Velocity(0.0, 0.0)


def test_after_time_has_jumped_back() -> None:
    smoother = Smoother(LIMITS, PERIOD)
    smoother.command(Velocity(0.05, 0.0), 100.0)
    assert smoother.step(100.0) == Velocity(0.05, 0.0)
    assert smoother.step(5.0) == STANDSTILL


@pytest.mark.parametrize("limits", [Limits(LIMITS.speed, STANDSTILL), Limits(LIMITS.speed, LIMITS.acceleration, 0.0)])
def test_limits_of_0_do_not_keep_it_from_braking(limits: Limits) -> None:
    smoother = Smoother(LIMITS, PERIOD)
    drive(smoother, [Velocity(0.5, 1.0)] * 12)
    smoother.limits = limits
    assert drive(smoother, [STANDSTILL] * 2, 1.2)[-1] == STANDSTILL


def test_feedback() -> None:
    for feedback in Feedback:
        smoother = Smoother(LIMITS, PERIOD, feedback)
        drive(smoother, [Velocity(0.5, 0.0)] * 12)
        smoother.robot_moves(Velocity(0.1, 0.0), 1.15)
        published = drive(smoother, [Velocity(0.5, 0.0)], 1.2)
        assert forward(published) == [0.5 if feedback == Feedback.NONE else 0.15]
    smoother.robot_moves(Velocity(99.0, 0.0), 1.3)
    assert forward(drive(smoother, [Velocity(0.8, 0.0)], 1.3)) == [0.8], "even then, speeds are limited"


def test_old_feedback_does_not_keep_the_robot_going() -> None:
    smoother = Smoother(LIMITS, PERIOD, Feedback.ODOMETRY)
    drive(smoother, [Velocity(0.8, 0.0)] * 20)
    smoother.robot_moves(Velocity(0.8, 0.0), 2.0)
    published = drive(smoother, [STANDSTILL] * 20, 2.0)
    assert published[-1] == STANDSTILL
    assert forward(drive(smoother, [Velocity(0.8, 0.0)] * 20, 4.0))[-1] == 0.8


def test_odometry_of_a_robot_that_rolls_the_other_way() -> None:
    speeds = []
    for feedback in (Feedback.COMMANDS, Feedback.ODOMETRY):
        smoother = Smoother(LIMITS, PERIOD, feedback)
        smoother.robot_moves(Velocity(-0.05, 0.0), 0.0)
        speeds += forward(drive(smoother, [Velocity(0.5, 0.0)]))
    assert speeds == [0.05, 0.1], "then it brakes"


def test_random_commands() -> None:
    """Each change lies in the direction of the target, within the limits, and could not be larger."""
    chance = random.Random(6)
    for _ in range(100):
        limits = Limits(
            Velocity(chance.uniform(0.1, 2), chance.uniform(0.1, 5)),
            Velocity(chance.uniform(0.1, 3), chance.uniform(0.1, 9)),
            chance.choice([0.5, 1.0, 3.0]),
        )
        smoother = Smoother(limits, PERIOD)
        last, target = STANDSTILL, STANDSTILL
        for index in range(60):
            if chance.random() < 0.2 or index == 0:
                target = Velocity(chance.uniform(-3, 3), chance.choice([0.0, chance.uniform(-6, 6)]))
            [velocity] = drive(smoother, [target], index * PERIOD)
            assert velocity is not None
            goal = [max(-limit, min(limit, value)) for value, limit in zip(target, limits.speed, strict=True)]
            wanted = [end - begin for begin, end in zip(last, goal, strict=True)]
            done = [end - begin for begin, end in zip(last, velocity, strict=True)]
            largest = [
                rate * PERIOD * (1.0 if end * change > 0 else limits.decel_factor)
                for rate, end, change in zip(limits.acceleration, goal, wanted, strict=True)
            ]
            assert all(abs(change) <= limit + 1e-9 for change, limit in zip(done, largest, strict=True))
            assert wanted[0] * done[1] == pytest.approx(wanted[1] * done[0])
            assert all(change * part >= 0 for change, part in zip(wanted, done, strict=True))
            assert list(velocity) == goal or any(
                abs(change) >= limit - 1e-9 for change, limit in zip(done, largest, strict=True)
            )
            last = velocity
