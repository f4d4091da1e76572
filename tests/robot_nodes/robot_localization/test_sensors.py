"""Conversions of what sensors report, against rotations by tf's matrices."""

from __future__ import annotations

from math import cos, inf, nan, pi, sin

import numpy as np
import pytest

from pyros1.robot_nodes.robot_localization.ekf import MIN_VARIANCE, Measurement
from pyros1.robot_nodes.robot_localization.motion import SIZE
from pyros1.robot_nodes.robot_localization.sensors import (
    AccelerationPart,
    Frame,
    Mask,
    Mount,
    PoseHistory,
    PosePart,
    TwistPart,
    cross,
    matrix,
    rotate_mask,
    unit,
)
from pyros1.tf.rotation import Transform, from_angles, multiply, to_angles
from pyros1.tf.transformations import euler_matrix, quaternion_matrix, random_quaternion

NONE = np.zeros(3)


def mask(*indices: int) -> Mask:
    flags = np.zeros(SIZE, bool)
    flags[list(indices)] = True
    return flags


def as_dict(measurement: Measurement | None) -> dict[int, float]:
    assert measurement is not None
    return dict(zip(measurement.indices.tolist(), measurement.values.tolist(), strict=True))


def random_transform(random: np.random.Generator) -> Transform:
    x, y, z = random.normal(0.0, 1.0, 3).tolist()
    return (x, y, z, *from_angles(*random.uniform(-1.5, 1.5, 3).tolist()))


def test_matrices_are_those_of_tf() -> None:
    for _ in range(20):
        quaternion = random_quaternion()
        assert matrix(tuple(3.0 * quaternion)) == pytest.approx(quaternion_matrix(quaternion)[:3, :3])


def test_cross_products_are_those_of_numpy() -> None:
    a, b = np.random.default_rng(0).normal(0.0, 1.0, (2, 3))
    assert cross(a, b) == pytest.approx(np.cross(a, b))


def test_quaternions_that_nobody_filled_in_do_not_rotate() -> None:
    assert unit((0.0, 0.0, 0.0, 0.0)) == (0.0, 0.0, 0.0, 1.0)
    assert unit((0.0, 0.0, 3.0, 4.0)) == pytest.approx((0.0, 0.0, 0.6, 0.8))


@pytest.mark.parametrize("seed", range(10))
def test_twists_are_turned_and_freed_of_the_motion_of_a_sensor_beside_the_centre(seed: int) -> None:
    random = np.random.default_rng(seed)
    velocity, angular = random.normal(0.0, 1.0, 3), random.normal(0.0, 1.0, 3)
    frame = Frame(random_transform(random))
    back = frame.rotation.T
    twist = np.concatenate([back @ (velocity + np.cross(angular, frame.offset)), back @ angular])
    root = random.normal(0.0, 1.0, (6, 6))
    part = TwistPart("odom0", mask(*range(6, 12)))
    measurement = part.convert(5, twist, root @ root.T, frame, angular)
    assert measurement is not None
    assert measurement.values == pytest.approx([*velocity, *angular])
    blocks = np.kron(np.eye(2), frame.rotation)
    assert measurement.covariance == pytest.approx(blocks @ root @ root.T @ blocks.T)


@pytest.mark.parametrize("seed", range(10))
def test_poses_are_converted_to_the_world_frame(seed: int) -> None:
    random = np.random.default_rng(seed)
    pose, world = random_transform(random), random_transform(random)
    root = random.normal(0.0, 1.0, (6, 6))
    measurement = PosePart("pose0", mask(*range(6))).convert(5, pose, root @ root.T, Frame(world))
    assert measurement is not None
    expected = multiply(world, pose)
    assert measurement.values == pytest.approx([*expected[:3], *to_angles(expected[3:])])
    blocks = np.kron(np.eye(2), Frame(world).rotation)
    assert measurement.covariance == pytest.approx(blocks @ root @ root.T @ blocks.T)


def test_what_is_used_is_meant_in_the_sensors_frame() -> None:
    """A sensor that looks up measures the robot's vz with its vx; one that is turned by 45 degrees vx and vy."""
    up, turned = (Frame((0.0, 0.0, 0.0, *from_angles(*angles))) for angles in ((0, -pi / 2, 0), (0, 0, pi / 4)))
    part, twist, covariance = TwistPart("twist0", mask(6)), np.array([2.0, 0, 0, 0, 0, 0]), np.eye(6)
    assert as_dict(part.convert(0, twist, covariance, up, NONE)) == pytest.approx({8: 2.0})
    assert as_dict(part.convert(0, twist, covariance, turned, NONE)) == pytest.approx({6: 2**0.5, 7: 2**0.5})
    assert as_dict(part.convert(0, twist, covariance, Frame(), NONE)) == {6: 2.0}


@pytest.mark.parametrize("mount", [(0.0, 0.0, pi / 2), (pi, 0.0, 0.0), (pi / 2, 0.0, -pi / 2), (0.0, pi / 2, 0.3)])
def test_the_orientation_of_a_mounted_imu_is_that_of_the_robot(mount: tuple[float, float, float]) -> None:
    robot = (0.2, -0.1, 2.5)
    imu = multiply((0.0, 0.0, 0.0, *from_angles(*robot)), (0.0, 0.0, 0.0, *from_angles(*mount)))
    found = Mount(Frame((1.0, 2.0, 3.0, *from_angles(*mount)))).robot_orientation(imu[3:])
    assert to_angles(found[3:]) == pytest.approx(robot)
    assert found[:3] == (0.0, 0.0, 0.0)


def test_the_yaw_of_an_imus_mounting_turns_what_is_used() -> None:
    mount = Mount(Frame((0.0, 0.0, 0.0, *from_angles(pi, 0.0, pi / 2))))
    assert rotate_mask(mask(3, 5), mount.turn).tolist() == mask(4, 5).tolist()


@pytest.mark.parametrize("seed", range(10))
def test_gravity_and_the_centrifugal_acceleration_are_removed(seed: int) -> None:
    random = np.random.default_rng(seed)
    acceleration, angular = random.normal(0.0, 1.0, 3), random.normal(0.0, 1.0, 3)
    frame, to_world = Frame(random_transform(random)), euler_matrix(*random.normal(0.0, 1.0, 3))[:3, :3]
    at_imu = acceleration + np.cross(angular, np.cross(angular, frame.offset))
    reported = frame.rotation.T @ at_imu + to_world.T @ (0.0, 0.0, 9.8)
    part = AccelerationPart("imu0", mask(12, 13, 14))
    found = part.convert(0, reported, np.eye(3), frame, angular, to_world, 9.8)
    assert as_dict(found) == pytest.approx(dict(enumerate(acceleration, 12)))


def test_without_removal_gravity_stays() -> None:
    part = AccelerationPart("imu0", mask(14))
    assert as_dict(part.convert(0, np.array([0.0, 0.0, 9.8]), np.eye(3), Frame(), NONE)) == {14: 9.8}


def test_in_a_plane_all_other_variables_are_zero() -> None:
    part = TwistPart("odom0", mask(6, 8, 9), flat=True)
    found = part.convert(0, np.arange(1.0, 7.0), np.full((6, 6), 0.5), Frame(), NONE)
    assert found is not None
    assert as_dict(found) == {6: 1.0, **dict.fromkeys([2, 3, 4, 8, 9, 10, 14], 0.0)}
    assert found.covariance[3].tolist() == [0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0]
    assert np.diag(found.covariance).tolist() == [1e-6] * 3 + [0.5] + [1e-6] * 4


def test_values_that_are_not_finite_are_left_out() -> None:
    part, twist = TwistPart("odom0", mask(6, 7)), np.array([1.0, nan, 0, 0, 0, 0])
    assert as_dict(part.convert(0, twist, np.eye(6), Frame(), NONE)) == {6: 1.0}
    twist[0] = inf
    assert part.convert(0, twist, np.eye(6), Frame(), NONE) is None
    assert part.convert(0, np.ones(6), np.full((6, 6), nan), Frame(), NONE) is None


def test_variances_are_positive() -> None:
    part, covariance = TwistPart("odom0", mask(6, 7)), np.zeros((6, 6))
    covariance[0, 0] = -0.5
    found = part.convert(0, np.ones(6), covariance, Frame(), NONE)
    assert found is not None
    assert np.diag(found.covariance).tolist() == [0.5, MIN_VARIANCE]


def test_relative_poses_are_relative_to_the_first() -> None:
    random = np.random.default_rng(3)
    history, first, motion = PoseHistory(), random_transform(random), random_transform(random)
    assert history.relative(first) == pytest.approx((0, 0, 0, 0, 0, 0, 1))
    assert history.relative(multiply(first, motion)) == pytest.approx(motion)
    assert history.relative(first) == pytest.approx((0, 0, 0, 0, 0, 0, 1))


def test_differential_poses_are_velocities_in_the_robots_frame() -> None:
    """A robot that looks to yaw 1 rad and drives 0.2 m ahead in 0.1 s, while it turns by 0.05 rad."""
    history, one = PoseHistory(), np.eye(6)
    start: Transform = (5.0, 5.0, 0.0, *from_angles(0.0, 0.0, 1.0))
    assert history.velocity(0, start, one) is None
    end: Transform = (5.0 + 0.2 * cos(1.0), 5.0 + 0.2 * sin(1.0), 0.0, *from_angles(0.0, 0.0, 1.05))
    found = history.velocity(10**8, end, 2 * one)
    assert found is not None
    assert found[0] == pytest.approx([2.0, 0.0, 0.0, 0.0, 0.0, 0.5])
    assert found[1] == pytest.approx(0.3 * one)
    assert history.velocity(10**8, end, one) is None, "no time has passed"
