"""The complementary filter on a simulated IMU."""

from __future__ import annotations

import time
from dataclasses import replace
from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.imu_complementary_filter.complementary import ComplementaryFilter, Settings
from pyros1.robot_nodes.shared.imu_readings import Estimate, Reading, UnusableReadingError
from pyros1.tf.rotation import Vector, to_angles

from ..imu_motion import FIELD, Motion, angle_between, tilt_between

LEVEL = Reading((0.0, 0.0, 0.0), (0.0, 0.0, 9.81))


def started(settings: Settings, reading: Reading = LEVEL) -> ComplementaryFilter:
    """Return a filter that has begun with a reading."""
    estimator = ComplementaryFilter(settings)
    assert estimator.update(reading, 0.0) is None, "as in stock ROS, the first reading has no output"
    estimator.update(reading, 0.0)
    return estimator


def update(estimator: ComplementaryFilter, reading: Reading, seconds: float = 0.01) -> Estimate:
    estimate = estimator.update(reading, seconds)
    assert estimate is not None
    return estimate


@pytest.mark.parametrize("has_field", [True, False])
def test_it_follows_the_true_orientation(has_field: bool) -> None:
    """Feature: imu_complementary_filter estimates the orientation of an IMU, x to magnetic north if it knows that"""
    motion = Motion("nwu", noise=0.1, bias=(0.01, -0.02, 0.01), has_field=has_field)
    estimator, errors = ComplementaryFilter(Settings()), []
    for reading, truth in motion.readings(1500):
        estimate = estimator.update(reading, 0.01)
        if estimate is not None:
            errors.append((angle_between if has_field else tilt_between)(estimate.orientation, truth))
            assert hypot(*estimate.orientation) == pytest.approx(1.0, abs=1e-12)
    assert max(errors[500:]) < 0.06 and np.mean(errors[500:]) < 0.04


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3))
def test_it_begins_with_the_orientation_that_the_sensors_show(start: Vector) -> None:
    (reading, truth), *_ = Motion("nwu", speed=0.0, start=start).readings(1)
    estimator = started(Settings(), reading)
    assert angle_between(update(estimator, reading).orientation, truth) < 1e-6
    estimator = started(Settings(), reading._replace(field=None))
    assert tilt_between(update(estimator, reading._replace(field=None)).orientation, truth) < 1e-6


def test_upside_down_has_an_orientation() -> None:
    roll, pitch, _ = to_angles(update(started(Settings(), Reading((0.0,) * 3, (0.0, 0.0, -9.81))), LEVEL).orientation)
    assert abs(roll) == pytest.approx(pi, abs=0.1) and pitch == pytest.approx(0.0, abs=0.01)


def test_each_reading_corrects_a_share_of_the_difference() -> None:
    settings = Settings(gain_acc=0.1, gain_mag=0.2, do_adaptive_gain=False)
    estimator = started(settings, Reading((0.0,) * 3, (0.0, 6.0, 6.0)))
    rolls = [to_angles(update(estimator, LEVEL).orientation)[0] for _ in range(3)]
    assert rolls == pytest.approx([pi / 4 * 0.9, pi / 4 * 0.9**2, pi / 4 * 0.9**3])
    estimator = started(settings)
    yaws = [to_angles(update(estimator, LEVEL._replace(field=(0.0, 1.0, -1.0))).orientation)[2] for _ in range(2)]
    assert yaws == pytest.approx([-pi / 2 * 0.2, -pi / 2 * (1 - 0.8**2)])


@pytest.mark.parametrize(
    ("share", "trust"), [(1.05, 1.0), (0.95, 1.0), (1.15, 0.5), (0.85, 0.5), (1.3, 0.0), (0.0, 0.0)]
)
def test_accelerations_that_are_not_gravity_count_less(share: float, trust: float) -> None:
    tilted = Reading((0.0,) * 3, (0.0, 6.9367, 6.9367))
    estimator = started(Settings(gain_acc=0.1, do_bias_estimation=False), tilted)
    roll = to_angles(update(estimator, Reading((0.0,) * 3, (0.0, 0.0, 9.81 * share))).orientation)[0]
    assert roll == pytest.approx(pi / 4 * (1 - 0.1 * trust), abs=1e-6)


def test_the_bias_of_the_gyroscope_is_found_at_rest_only() -> None:
    still, moving = LEVEL._replace(rates=(0.05, -0.02, 0.03)), LEVEL._replace(rates=(0.0, 0.3, 0.0))
    estimator = started(Settings(bias_alpha=0.1), still)
    estimates = [update(estimator, still) for _ in range(100)]
    assert estimates[-1].steady and estimates[-1].rates == pytest.approx((0, 0, 0), abs=1e-5)
    for _ in range(100):
        estimate = update(estimator, moving)
        assert not estimate.steady and estimate.rates == pytest.approx((-0.05, 0.32, -0.03), abs=1e-5)
    shaken = [update(estimator, still._replace(acceleration=(0.0, 0.0, 9.95))) for _ in range(3)]
    assert not any(estimate.steady for estimate in shaken)
    unsteady = [update(estimator, still._replace(rates=(0.05 + i % 2 * 0.02, -0.02, 0.03))) for i in range(4)]
    assert not any(estimate.steady for estimate in unsteady[1:])
    off = started(replace(Settings(), do_bias_estimation=False), still)
    estimates = [update(off, still) for _ in range(50)]
    assert not estimates[-1].steady and estimates[-1].rates == still.rates


def test_without_acceleration_it_waits_and_later_uses_the_gyroscope_alone() -> None:
    falling = Reading((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), tuple(FIELD.tolist()))
    estimator = ComplementaryFilter(Settings())
    assert estimator.update(falling, 0.01) is None
    with pytest.raises(UnusableReadingError, match="no gravity"):
        estimator.update(falling, 0.01)
    estimator = started(Settings())
    for _ in range(10):
        estimate = update(estimator, falling._replace(field=None))
    assert to_angles(estimate.orientation) == pytest.approx((0.0, 0.0, 0.1))
    estimator.reset()
    assert estimator.update(LEVEL, 0.0) is None
    assert to_angles(update(estimator, LEVEL).orientation) == pytest.approx((0.0, 0.0, 0.0))


numbers = st.floats(-1e9, 1e9, exclude_max=True, exclude_min=True)
anything = st.tuples(numbers, numbers, numbers)


@pytest.mark.slow
@given(st.lists(st.tuples(anything, anything, st.none() | anything, st.floats(0, 1)), max_size=8))
def test_nothing_makes_it_invalid(inputs: list[tuple[Vector, Vector, Vector | None, float]]) -> None:
    estimator = started(Settings(gain_acc=1.0, gain_mag=1.0))
    for rates, acceleration, field, seconds in inputs:
        assert hypot(*update(estimator, Reading(rates, acceleration, field), seconds).orientation) == pytest.approx(1.0)


def test_a_message_costs_little() -> None:
    readings = [reading for reading, _ in Motion(noise=0.1).readings(500)]
    estimator, times = ComplementaryFilter(Settings()), []
    for _ in range(3):
        start = time.process_time()
        for reading in readings:
            estimator.update(reading, 0.01)
        times.append((time.process_time() - start) / len(readings))
    assert min(times) < 150e-6
