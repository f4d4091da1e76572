"""Madgwick's filter on a simulated IMU."""

from __future__ import annotations

import time
from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.imu_filter_madgwick.madgwick import GRAVITY, MadgwickFilter, Settings, gradient
from pyros1.robot_nodes.imu_filter_madgwick.world import WorldFrame
from pyros1.robot_nodes.shared.imu_readings import Reading, UnusableReadingError
from pyros1.robot_nodes.shared.quaternions import conjugate, from_rotation_vector, rotate
from pyros1.tf.rotation import Vector, to_angles

from ..imu_motion import FIELD, Motion, angle_between, matrix, tilt_between

LEVEL = Reading((0.0, 0.0, 0.0), (0.0, 0.0, 9.81))


@pytest.mark.slow
@pytest.mark.parametrize("world", ["enu", "ned", "nwu"])
@pytest.mark.parametrize("has_field", [True, False])
def test_it_follows_the_true_orientation(world: str, has_field: bool) -> None:
    """Feature: imu_filter_madgwick estimates the orientation of an IMU in ENU, NED and NWU frames"""
    motion = Motion(world, noise=0.1, bias=(0.01, -0.02, 0.01), has_field=has_field)
    estimator = MadgwickFilter(Settings(world=WorldFrame(world)))
    errors = []
    for reading, truth in motion.readings(1500):
        estimate = estimator.update(reading, 0.01)
        errors.append((angle_between if has_field else tilt_between)(estimate.orientation, truth))
        assert hypot(*estimate.orientation) == pytest.approx(1.0, abs=1e-12)
    assert max(errors[500:]) < 0.06 and np.mean(errors[500:]) < 0.03


def test_it_converges_from_a_wrong_orientation_at_its_gain() -> None:
    """The orientation turns by about 2 * gain rad/s towards what the sensors show."""
    for field in (None, tuple(FIELD.tolist())):
        estimator = MadgwickFilter(Settings(gain=0.2))
        estimator.update(Reading((0.0, 0.0, 0.0), (0.0, 9.81, 9.81), field), 0.0)
        tilts = [to_angles(estimator.update(LEVEL._replace(field=field), 0.01).orientation)[0] for _ in range(400)]
        assert tilts[0] > 0.7 and abs(tilts[-1]) < 0.01
        near = next(index for index, tilt in enumerate(tilts) if tilt < 0.2)
        assert field is not None or tilts[near] - tilts[near + 25] == pytest.approx(0.1, rel=0.02)


@pytest.mark.slow
def test_zeta_removes_the_bias_of_the_gyroscope() -> None:
    bias, mean_errors = (0.1, -0.05, 0.08), []
    for zeta in (0.0, 0.02):
        estimator = MadgwickFilter(Settings(gain=0.1, zeta=zeta))
        readings = Motion(noise=0.1, bias=bias).readings(2000)
        errors = [angle_between(estimator.update(reading, 0.01).orientation, truth) for reading, truth in readings]
        mean_errors.append(np.mean(errors[1500:]))
    assert mean_errors[1] < 0.3 * mean_errors[0]


vectors = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


@given(vectors, vectors, vectors)
def test_the_gradient_is_that_of_the_squared_distance(rotation: Vector, reference: Vector, measured: Vector) -> None:
    orientation = from_rotation_vector(*rotation)

    def distance(quaternion: np.ndarray) -> float:
        x, y, z, w = quaternion.tolist()
        difference = matrix((x, y, z, w)).T @ reference - measured
        return float(difference @ difference) / 2

    step = 1e-6
    numeric = [
        (distance(np.array(orientation) + step * axis) - distance(np.array(orientation) - step * axis)) / (2 * step)
        for axis in np.eye(4)
    ]
    np.testing.assert_allclose(gradient(orientation, reference, measured), numeric, atol=1e-7)


def test_what_the_robot_adds_to_the_field_is_subtracted() -> None:
    field = tuple(FIELD.tolist())
    disturbed = (field[0] + 3e-5, field[1] - 1e-5, field[2] + 2e-5)
    settings = Settings(mag_bias=(3e-5, -1e-5, 2e-5))
    reading = LEVEL._replace(field=disturbed)
    for estimator in (MadgwickFilter(settings), MadgwickFilter(Settings())):
        estimator.configure(0.1, 0.0, settings.mag_bias)
        for _ in range(100):
            estimate = estimator.update(reading, 0.01)
        assert estimate.orientation == pytest.approx((0, 0, 0, 1), abs=2e-3)


@pytest.mark.parametrize("world", list(WorldFrame))
def test_gravity_can_be_removed(world: WorldFrame) -> None:
    estimator = MadgwickFilter(Settings(world=world, remove_gravity=True))
    for reading, _ in Motion(world.value).readings(300):
        estimate = estimator.update(reading, 0.01)
        assert estimate.acceleration == pytest.approx((0, 0, 0), abs=0.1)
    gravity = rotate(conjugate(estimate.orientation), (0.0, 0.0, world.up[2] * GRAVITY))
    removed = np.subtract(reading.acceleration, estimate.acceleration)
    assert removed.tolist() == pytest.approx(gravity)


def test_the_yaw_offset_turns_the_world() -> None:
    estimator = MadgwickFilter(Settings(yaw_offset=0.5))
    for _ in range(3):
        assert to_angles(estimator.update(LEVEL, 0.01).orientation) == pytest.approx((0.0, 0.0, 0.5))


def test_without_state_each_reading_counts_alone() -> None:
    estimator = MadgwickFilter(Settings(stateless=True))
    for reading, truth in Motion(speed=20.0).readings(50):
        assert angle_between(estimator.update(reading, 0.01).orientation, truth) < 1e-6


def test_in_free_fall_it_waits_for_gravity_and_later_uses_the_gyroscope_alone() -> None:
    estimator = MadgwickFilter(Settings())
    falling = Reading((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    with pytest.raises(UnusableReadingError, match="free fall"):
        estimator.update(falling, 0.01)
    estimator.update(LEVEL, 0.0)
    for _ in range(10):
        orientation = estimator.update(falling, 0.01).orientation
    assert to_angles(orientation) == pytest.approx((0.0, 0.0, 0.1))
    estimator.reset()
    assert to_angles(estimator.update(LEVEL, 0.0).orientation) == pytest.approx((0.0, 0.0, 0.0))


def test_it_begins_with_the_first_field_that_is_known() -> None:
    estimator = MadgwickFilter(Settings(use_mag=True))
    with pytest.raises(UnusableReadingError, match="magnetic field is not finite"):
        estimator.update(LEVEL, 0.01)
    estimator.update(LEVEL._replace(field=(1.0, 0.0, -1.0)), 0.01)
    assert to_angles(estimator.update(LEVEL, 0.01).orientation)[2] == pytest.approx(pi / 2)


def test_a_long_step_from_upside_down_has_a_result() -> None:
    estimator = MadgwickFilter(Settings(gain=1.0))
    estimator.update(Reading((0.0, 0.0, 0.0), (0.0, 0.0, -9.81)), 0.0)
    assert hypot(*estimator.update(LEVEL, 1.0).orientation) == pytest.approx(1.0)


numbers = st.floats(-1e9, 1e9, exclude_max=True, exclude_min=True)
anything = st.tuples(numbers, numbers, numbers)


@pytest.mark.slow
@given(st.lists(st.tuples(anything, anything, st.none() | anything, st.floats(0, 1)), max_size=8), st.floats(-1, 1))
def test_nothing_makes_it_invalid(inputs: list[tuple[Vector, Vector, Vector | None, float]], zeta: float) -> None:
    estimator = MadgwickFilter(Settings(gain=1.0, zeta=zeta))
    estimator.update(LEVEL, 0.0)
    for rates, acceleration, field, seconds in inputs:
        orientation = estimator.update(Reading(rates, acceleration, field), seconds).orientation
        assert hypot(*orientation) == pytest.approx(1.0)


def test_a_message_costs_little() -> None:
    readings = [reading for reading, _ in Motion(noise=0.1).readings(500)]
    estimator = MadgwickFilter(Settings(zeta=0.01))
    times = []
    for _ in range(3):
        start = time.process_time()
        for reading in readings:
            estimator.update(reading, 0.01)
        times.append((time.process_time() - start) / len(readings))
    assert min(times) < 150e-6
