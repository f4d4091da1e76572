"""Both filters beside a simulated truth: a robot with slipping wheels and an IMU with an offset, in `flat_world`.

``pytest -s`` prints the errors, which the manual states.

Feature: how far the estimated pose is from a simulated truth, with late GPS, too -- `smooth_lagged_data`
"""

from __future__ import annotations

from math import cos, hypot, sin
from typing import Any

import numpy as np
import pytest

from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import PoseWithCovarianceStamped
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.sensor_msgs.msg import Imu
from pyros1.robot_nodes.flat_world.walls import Walls
from pyros1.robot_nodes.flat_world.world import DT, Settings, World
from pyros1.robot_nodes.robot_localization.ekf import Ekf
from pyros1.robot_nodes.robot_localization.estimator import Estimator
from pyros1.robot_nodes.robot_localization.inputs import SensorInput
from pyros1.robot_nodes.robot_localization.motion import Array
from pyros1.robot_nodes.robot_localization.sensors import Frame
from pyros1.robot_nodes.robot_localization.settings import read_settings
from pyros1.robot_nodes.robot_localization.ukf import Ukf
from pyros1.robot_nodes.shared.parameters import PrivateParameters

SECONDS = 30
PARAMETERS = {
    "two_d_mode": True,
    "odom0": "odom",
    "odom0_config": [False] * 6 + [True, True] + [False] * 7,
    "imu0": "imu",
    "imu0_config": [False] * 5 + [True] + [False] * 5 + [True] + [False] * 3,
    "pose0": "gps",
    "pose0_config": [True, True] + [False] * 13,
}
HEADING_ERROR, GPS_ERROR = 0.02, 0.3


class Follower:
    """A filter that gets the messages of a robot."""

    def __init__(self, kind: type[Ekf], uses_gps: bool, delay: int = 0, **more: object) -> None:
        self.delay = delay  # of the GPS, in steps of the world
        problems: list[str] = []
        parameters = {key: value for key, value in PARAMETERS.items() if uses_gps or "pose0" not in key} | more
        settings = read_settings(PrivateParameters(parameters, problems.append))
        assert not problems
        self.filter = kind(settings.process_noise, settings.initial_covariance)
        self.estimator = Estimator(self.filter, history=round(settings.history * 1e9))
        frame = Frame()
        self.inputs = {
            each.name: SensorInput(each, settings, self.filter, lambda *names: frame) for each in settings.sensors
        }
        self.errors: list[float] = []

    def receive(self, name: str, message: object) -> None:
        for measurement in self.inputs[name].read(message) if name in self.inputs else []:
            self.estimator.add(measurement)

    def advance(self, time: Time, truth: Array) -> None:
        self.estimator.advance(time.to_nsec())
        self.errors.append(hypot(*(self.filter.state[:2] - truth[:2])))


def drive(seed: int, followers: list[Follower]) -> list[float]:
    """Drive to and fro; return the errors of the wheels alone."""
    random = np.random.default_rng(seed)
    walls = Walls(np.zeros((200, 200), bool), 1.0, (-100.0, -100.0))
    world, errors = World(walls, np.zeros((1, 3)), Settings(command_timeout=10.0), seed), []
    fixes: dict[int, Any] = {}
    for step in range(round(SECONDS / DT)):
        if step % 80 == 0:
            world.command(0, random.uniform(0.3, 1.0), random.uniform(-0.6, 0.6))
        world.step()
        if step % 2 == 0:  # messages come at 20 Hz
            continue
        x, y, yaw = world.poses[0].tolist()
        odometry, imu, fix = Odometry(), Imu(), PoseWithCovarianceStamped()
        time = odometry.header.stamp = imu.header.stamp = fix.header.stamp = Time.from_sec(1000.0 + step * DT)
        odometry.twist.twist.linear.x = float(world.wheel_speeds[0, 0])
        odometry.twist.covariance = (1e-4 * np.eye(6)).ravel().tolist()
        measured_yaw = yaw + random.normal(0.0, HEADING_ERROR)
        imu.orientation.z, imu.orientation.w = sin(measured_yaw / 2), cos(measured_yaw / 2)
        imu.orientation_covariance = (HEADING_ERROR**2 * np.eye(3)).ravel().tolist()
        imu.angular_velocity.z = float(world.imus[0, 0])
        imu.angular_velocity_covariance = (3e-5 * np.eye(3)).ravel().tolist()
        fix.pose.pose.position.x, fix.pose.pose.position.y = (
            x + random.normal(0.0, GPS_ERROR),
            y + random.normal(0.0, GPS_ERROR),
        )
        fix.pose.covariance = (GPS_ERROR**2 * np.eye(6)).ravel().tolist()
        if step % 40 == 39:
            fixes[step] = fix
        for follower in followers:
            follower.receive("odom0", odometry)
            follower.receive("imu0", imu)
            if step - follower.delay in fixes:
                follower.receive("pose0", fixes[step - follower.delay])
            follower.advance(time, world.poses[0])
        errors.append(hypot(*(world.odometry[0, :2] - world.poses[0, :2])))
    return errors


def rms(errors: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(errors))))


@pytest.mark.slow
def test_both_filters_are_nearer_to_the_truth_than_the_wheels() -> None:
    late = {"smooth_lagged_data": True, "history_length": 3.0}
    followers = {
        "EKF": Follower(Ekf, False),
        "UKF": Follower(Ukf, False),
        "EKF with GPS": Follower(Ekf, True),
        "UKF with GPS": Follower(Ukf, True),
        "EKF with late GPS": Follower(Ekf, True, delay=30),
        "EKF with late GPS and a history": Follower(Ekf, True, delay=30, **late),
    }
    wheels = drive(0, list(followers.values()))
    found = {name: rms(follower.errors) for name, follower in followers.items()}
    for name, errors in {"wheels alone": wheels, **{key: each.errors for key, each in followers.items()}}.items():
        print(f"{name}: {rms(errors):.3f} m, {errors[-1]:.3f} m at the end")
    assert rms(wheels) > 1.0
    assert max(found["EKF"], found["UKF"]) < 0.2
    assert max(found["EKF with GPS"], found["UKF with GPS"]) < GPS_ERROR
    # A late fix corrects what was estimated for its own time.
    assert found["EKF with late GPS and a history"] < GPS_ERROR < found["EKF with late GPS"]
