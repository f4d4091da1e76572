"""The orientation that a single reading shows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.imu_filter_madgwick.world import WorldFrame, measured_orientation
from pyros1.robot_nodes.shared.imu_readings import UnusableReadingError
from pyros1.tf.rotation import Vector, to_angles

from ..imu_motion import EAST_NORTH_UP, FIELD, angle_between, exponential, tilt_between

UP = (0.0, 0.0, 9.81)
angles = st.tuples(*[st.floats(-3.0, 3.0)] * 3)
frames = st.sampled_from(list(WorldFrame))


@given(frames, angles)
def test_the_orientation_is_the_true_one(world: WorldFrame, rotation: Vector) -> None:
    truth = exponential(np.array(rotation))
    acceleration, field = (tuple((truth.T @ vector).tolist()) for vector in (np.array(UP), FIELD))
    found = measured_orientation(world, acceleration, field)
    assert angle_between(found, EAST_NORTH_UP[world.value] @ truth) < 1e-7


@given(frames, angles)
def test_without_a_field_the_yaw_is_0(world: WorldFrame, rotation: Vector) -> None:
    truth = exponential(np.array(rotation))
    found = measured_orientation(world, tuple((truth.T @ np.array(UP)).tolist()), None)
    assert tilt_between(found, EAST_NORTH_UP[world.value] @ truth) < 1e-7
    assert to_angles(found)[2] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("world", "acceleration", "field"),
    [
        (WorldFrame.ENU, UP, (0.0, 20e-6, -40e-6)),
        (WorldFrame.NWU, UP, (20e-6, 0.0, -40e-6)),
        (WorldFrame.NED, (0.0, 0.0, -9.81), (20e-6, 0.0, 40e-6)),
    ],
)
def test_an_imu_that_is_aligned_with_the_world(world: WorldFrame, acceleration: Vector, field: Vector) -> None:
    assert measured_orientation(world, acceleration, field) == pytest.approx((0, 0, 0, 1))
    assert measured_orientation(world, acceleration, None) == pytest.approx((0, 0, 0, 1))


def test_some_readings_show_no_orientation() -> None:
    with pytest.raises(UnusableReadingError, match="free fall"):
        measured_orientation(WorldFrame.ENU, (0.0, 0.01, 0.0), None)
    for field in ((0.0, 0.0, 5e-5), (0.0, 0.0, 0.0)):
        with pytest.raises(UnusableReadingError, match="zero or vertical"):
            measured_orientation(WorldFrame.ENU, UP, field)
