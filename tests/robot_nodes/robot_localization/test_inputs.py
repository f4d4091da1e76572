"""Messages become measurements; a simulated robot is followed with those of odometry and IMU."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

import numpy as np
import pytest

from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import PoseWithCovarianceStamped, TwistWithCovarianceStamped
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.sensor_msgs.msg import Imu
from pyros1.robot_nodes.robot_localization.ekf import Ekf
from pyros1.robot_nodes.robot_localization.estimator import Estimator
from pyros1.robot_nodes.robot_localization.inputs import SensorInput, pose_tuple
from pyros1.robot_nodes.robot_localization.sensors import Frame
from pyros1.robot_nodes.robot_localization.settings import DEFAULT_NOISE, read_settings
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.tf.rotation import Quaternion, Transform, from_angles, multiply

MOUNTED: Transform = (0.1, 0.2, 0.3, *from_angles(0.0, 0.0, pi / 2))
FRAMES = {"imu_link": Frame(MOUNTED), "base_link": Frame(), "odom": Frame()}


def make_ekf() -> Ekf:
    return Ekf(np.diag(DEFAULT_NOISE), 1e-9 * np.eye(15))


def make_input(kind: str, used: list[int], ekf: Ekf | None = None, flat: bool = False, **options: Any) -> SensorInput:
    name = f"{kind}0"
    parameters = {"two_d_mode": flat, name: "topic", f"{name}_config": [index in used for index in range(15)]}
    parameters.update({f"{name}_{option}": value for option, value in options.items()})
    settings = read_settings(PrivateParameters(parameters, pytest.fail))
    return SensorInput(
        settings.sensors[0], settings, ekf or make_ekf(), lambda target, source, time: FRAMES.get(source)
    )


def values(sensor: SensorInput, message: Any) -> list[dict[int, float]]:
    found = sensor.read(message)
    return [dict(zip(item.indices.tolist(), item.values.round(9).tolist(), strict=True)) for item in found]


def set_quaternion(field: Any, quaternion: Quaternion) -> None:
    field.x, field.y, field.z, field.w = quaternion


def make_imu(quaternion: Quaternion = (0.0, 0.0, 0.0, 1.0), frame: str = "imu_link", seconds: float = 1.0) -> Any:
    imu = Imu()
    imu.header.stamp, imu.header.frame_id = Time.from_sec(seconds), frame
    set_quaternion(imu.orientation, quaternion)
    imu.angular_velocity.y, imu.linear_acceleration.z = 0.5, 9.80665
    return imu


def make_odometry(seconds: float = 1.0) -> Any:
    odometry = Odometry(child_frame_id="base_link")
    odometry.header.stamp, odometry.header.frame_id = Time.from_sec(seconds), "odom"
    odometry.pose.pose.position.x = seconds
    odometry.pose.pose.orientation.w = 1.0
    odometry.twist.twist.linear.x = 0.7
    odometry.pose.covariance = np.arange(36.0).tolist()
    odometry.twist.covariance = (0.1 * np.eye(6)).ravel().tolist()
    return odometry


def test_odometry_has_a_pose_and_a_twist() -> None:
    sensor = make_input("odom", [0, 5, 6])
    assert values(sensor, make_odometry()) == [{0: 1.0, 5: 0.0}, {6: 0.7}]
    assert [item.covariance.tolist() for item in sensor.read(make_odometry())] == [[[1e-9, 5.0], [30.0, 35.0]], [[0.1]]]
    assert [item.time for item in sensor.read(make_odometry(2.5))] == [2_500_000_000] * 2


@pytest.mark.parametrize("frame", ["imu_link", "base_link"])
@pytest.mark.parametrize("flat", [False, True])
def test_a_covariance_may_change_from_message_to_message(frame: str, flat: bool) -> None:
    chance = np.random.default_rng(5)
    used = [0, 4, 5, 6, 7, 11, 12, 14]
    kept = {kind: make_input(kind, used, flat=flat) for kind in ("imu", "odom")}
    for _ in range(60):
        imu, odometry = make_imu(frame=frame), make_odometry()
        for message, field, size in (
            (imu, "orientation_covariance", 3),
            (imu, "angular_velocity_covariance", 3),
            (imu, "linear_acceleration_covariance", 3),
            (odometry.pose, "covariance", 6),
            (odometry.twist, "covariance", 6),
        ):
            matrix = np.diag([0.0, 0.2, float("nan")][chance.integers(3)] + chance.integers(2) * np.ones(size))
            setattr(message, field, matrix.ravel().tolist())
        for kind, message in (("imu", imu), ("odom", odometry)):
            found, expected = (sensor.read(message) for sensor in (kept[kind], make_input(kind, used, flat=flat)))
            assert [item.indices.tolist() for item in found] == [item.indices.tolist() for item in expected]
            assert [item.values.tolist() for item in found] == [item.values.tolist() for item in expected]
            assert [item.covariance.tolist() for item in found] == [item.covariance.tolist() for item in expected]


def test_poses_and_twists() -> None:
    pose, twist = PoseWithCovarianceStamped(), TwistWithCovarianceStamped()
    pose.pose.pose.position.y, twist.twist.twist.angular.z = 3.0, 0.4
    assert values(make_input("pose", [0, 1, 6]), pose) == [{0: 0.0, 1: 3.0}]
    assert values(make_input("twist", [1, 11]), twist) == [{11: 0.4}]


def test_differential_poses_become_velocities() -> None:
    sensor = make_input("odom", [0, 1], differential=True)
    assert values(sensor, make_odometry(1.0)) == []
    assert values(sensor, make_odometry(1.5)) == [{6: 1.0, 7: 0.0}]


def test_relative_poses_begin_at_the_origin() -> None:
    sensor = make_input("odom", [0], relative=True)
    assert values(sensor, make_odometry(4.0)) + values(sensor, make_odometry(5.0)) == [{0: 0.0}, {0: 1.0}]


@pytest.mark.parametrize("options", [{}, {"differential": True}])
def test_a_mounted_imu_reports_what_the_robot_does(options: dict[str, bool]) -> None:
    """Its y axis points backwards, so its pitch is the robot's negative roll, and so is its angular velocity."""
    sensor = make_input("imu", [3, 4, 5], **options)
    robot = multiply((0.0, 0.0, 0.0, *from_angles(0.0, 0.0, 0.3)), (0.0, 0.0, 0.0, *MOUNTED[3:]))
    first = values(sensor, make_imu(robot[3:]))
    turned = multiply((0.0, 0.0, 0.0, *from_angles(0.01, 0.0, 0.34)), (0.0, 0.0, 0.0, *MOUNTED[3:]))
    second = values(sensor, make_imu(turned[3:], seconds=1.1))
    if options:
        assert (first, second) == ([], [pytest.approx({9: 0.1, 10: 0.0, 11: 0.4}, abs=2e-3)])
    else:
        assert (first, second) == ([{3: 0.0, 4: 0.0, 5: 0.3}], [{3: 0.01, 4: 0.0, 5: 0.34}])
    assert values(make_input("imu", [9, 10, 11]), make_imu()) == [{9: -0.5, 10: 0.0, 11: 0.0}]


def test_an_imus_acceleration_without_gravity() -> None:
    tilted = from_angles(0.1, 0.2, 0.0)
    for quaternion, x in ((from_angles(0.0, 0.0, 1.0), 0.0), (tilted, 9.80665 * sin(0.2))):
        message = make_imu(quaternion, "base_link")
        message.angular_velocity.y = 0.0
        found = values(make_input("imu", [12], remove_gravitational_acceleration=True), message)
        assert found == [{12: pytest.approx(x)}]
    assert values(make_input("imu", [14]), make_imu()) == [{14: 9.80665}]


def test_the_orientation_of_a_relative_imu_is_that_of_its_mounting_at_first() -> None:
    """It is mounted sideways, and has been tilted by its own pitch, which is a roll of the robot."""
    sensor = make_input("imu", [12, 13], relative=True, remove_gravitational_acceleration=True)
    message = make_imu(from_angles(0.2, 0.0, 0.0))
    message.angular_velocity.y, message.linear_acceleration.z = 0.0, 0.0
    message.linear_acceleration.x = 9.80665 * sin(0.2)
    assert values(sensor, message) == [pytest.approx({12: 0.0, 13: 0.0}, abs=1e-6)]


def test_gravity_is_removed_with_the_estimate_if_the_imu_has_no_orientation() -> None:
    ekf = make_ekf()
    ekf.state[4] = 0.2
    sensor = make_input("imu", [12], ekf, remove_gravitational_acceleration=True)
    message = make_imu(frame="base_link")
    message.orientation_covariance = [-1.0, *[0.0] * 8]
    assert values(sensor, message) == [{12: pytest.approx(9.80665 * sin(0.2))}]


@pytest.mark.parametrize(
    ("field", "left"),
    [
        ("orientation_covariance", [{9: 0.0}, {14: 9.80665}]),
        ("angular_velocity_covariance", [{3: 0.0}, {14: 9.80665}]),
        ("linear_acceleration_covariance", [{3: 0.0}, {9: 0.0}]),
    ],
)
def test_what_an_imu_does_not_measure_is_not_used(field: str, left: object) -> None:
    message = make_imu(frame="base_link")
    setattr(message, field, [-1.0, *[0.0] * 8])
    assert values(make_input("imu", [3, 9, 14]), message) == left


def test_data_in_unknown_frames_are_not_used() -> None:
    odometry = make_odometry()
    odometry.header.frame_id = odometry.child_frame_id = "moon"
    assert values(make_input("odom", [0, 6]), odometry) == []
    assert values(make_input("imu", [3, 9, 14]), make_imu(frame="moon")) == []


def test_empty_frames_are_those_of_the_filter() -> None:
    odometry = make_odometry()
    odometry.header.frame_id = odometry.child_frame_id = ""
    assert values(make_input("odom", [0, 6]), odometry) == [{0: 1.0}, {6: 0.7}]


def test_a_simulated_robot_is_followed() -> None:
    """40 s of a figure of eight, with a noisy speed, a noisy heading, and a mounted gyroscope with noise."""
    random, dt = np.random.default_rng(5), 0.04
    estimator = Estimator(make_ekf())
    odom, imu = make_input("odom", [6, 7], estimator.ekf), make_input("imu", [5, 11], estimator.ekf)
    x = y = yaw = 0.0
    errors = []
    for step in range(1, 1000):
        seconds, rate, speed = 1.0 + step * dt, 0.4 * (1 if step // 400 % 2 else -1), 0.8
        x, y, yaw = x + speed * dt * cos(yaw), y + speed * dt * sin(yaw), yaw + rate * dt
        message = make_odometry(seconds)
        message.twist.twist.linear.x = speed + random.normal(0.0, 0.05)
        message.twist.covariance = (0.05**2 * np.eye(6)).ravel().tolist()
        heading = multiply((0, 0, 0, *from_angles(0, 0, yaw + random.normal(0.0, 0.02))), (0, 0, 0, *MOUNTED[3:]))
        angular = make_imu(heading[3:], seconds=seconds)
        angular.angular_velocity.y, angular.angular_velocity.z = 0.0, rate + random.normal(0.0, 0.01)
        angular.orientation_covariance = (0.02**2 * np.eye(3)).ravel().tolist()
        angular.angular_velocity_covariance = (0.01**2 * np.eye(3)).ravel().tolist()
        for measurement in odom.read(message) + imu.read(angular):
            estimator.add(measurement)
        estimator.advance(message.header.stamp.to_nsec())
        errors.append(np.hypot(*(estimator.ekf.state[:2] - (x, y))))
    assert max(errors) < 0.3, "of 32 m"
    assert np.hypot(x, y) > 1.0


def test_poses_are_normalised() -> None:
    pose = make_odometry().pose.pose
    set_quaternion(pose.orientation, (0.0, 0.0, 2.0, 0.0))
    assert pose_tuple(pose) == (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
