from __future__ import annotations

from math import inf
from typing import Any

import numpy as np
import pytest
import yaml

from pyros1.robot_nodes.robot_localization.settings import DEFAULT_NOISE, Settings, prefixed, read_settings
from pyros1.robot_nodes.shared.parameters import PrivateParameters

# as in the files that come with robots
WHEELED = """
odom_frame: odom
base_link_frame: base_footprint
world_frame: odom
two_d_mode: true
frequency: 50
odom0: velocity_controller/odom
odom0_config: [true, true, true,
               false, false, true,
               false, false, false,
               false, false, false,
               true, false, false]
odom0_differential: true
odom0_queue_size: 10
odom0_pose_rejection_threshold: 5
imu0: imu/data
imu0_config: [true, false, false,
              true, true, true,
              false, false, false,
              true, true, true,
              false, false, false]
imu0_relative: true
imu0_twist_rejection_threshold: 0.8
imu0_linear_acceleration_rejection_threshold: 0.7
imu0_remove_gravitational_acceleration: true
pose0: amcl_pose
pose0_config: [true, true, false, false, false, true, true, false, false, false, false, false, false, false, false]
pose0_rejection_threshold: 2
pose2: unused
"""


def read(parameters: dict[str, Any], prefix: str = "") -> tuple[Settings, list[str]]:
    problems: list[str] = []
    return read_settings(PrivateParameters(parameters, problems.append, "/ekf"), prefix), problems


def test_the_parameters_of_a_robot() -> None:
    settings, problems = read(yaml.safe_load(WHEELED))
    assert problems == []
    assert (settings.frequency, settings.sensor_timeout, settings.flat) == (50.0, 0.02, True)
    assert (settings.world_frame, settings.base_frame, settings.map_frame) == ("odom", "base_footprint", "map")
    odom, pose, imu = settings.sensors
    assert (odom.name, odom.topic, odom.queue_size) == ("odom0", "velocity_controller/odom", 10)
    assert np.nonzero(odom.mask)[0].tolist() == [0, 1, 2, 5], "an odometry has no acceleration"
    assert (odom.differential, odom.relative, odom.pose_threshold, odom.twist_threshold) == (True, False, 5.0, inf)
    assert np.nonzero(imu.mask)[0].tolist() == [3, 4, 5, 9, 10, 11], "an IMU has no position"
    assert (imu.relative, imu.removes_gravity) == (True, True)
    assert (imu.pose_threshold, imu.twist_threshold, imu.acceleration_threshold) == (inf, 0.8, 0.7)
    assert np.nonzero(pose.mask)[0].tolist() == [0, 1, 5], "a pose has no velocity"
    assert pose.pose_threshold == 2.0


def test_the_defaults() -> None:
    settings, problems = read({})
    assert (settings.sensors, problems) == ((), [])
    assert (settings.frequency, settings.sensor_timeout) == (30.0, pytest.approx(1 / 30))
    assert (settings.world_frame, settings.odom_frame, settings.map_frame) == ("odom", "odom", "map")
    assert (settings.publishes_tf, settings.publishes_acceleration, settings.diagnostics) == (True, False, True)
    assert (settings.gravity, settings.history, settings.control) == (9.80665, 0.0, None)
    assert np.diag(settings.process_noise).tolist() == list(DEFAULT_NOISE)
    assert settings.initial_covariance == pytest.approx(1e-9 * np.eye(15))


def test_matrices_may_have_numbers_that_yaml_takes_for_text() -> None:
    settings, problems = read(yaml.safe_load(f"initial_estimate_covariance: [{', '.join(['1e-9', '0', '1.5'] * 75)}]"))
    assert problems == []
    assert settings.initial_covariance[0, :3].tolist() == [1e-9, 0.0, 1.5]


@pytest.mark.parametrize(
    ("parameters", "problem"),
    [
        ({"process_noise_covariance": [1.0] * 15}, "process_noise_covariance must be a list of 225 numbers, row by"),
        ({"process_noise_covariance": ["a"] * 225}, "process_noise_covariance must be a list of 225 numbers, row by"),
        ({"initial_state": [1e400] * 15}, "initial_state must be a list of 15 numbers"),
        (
            {"odom0": "odom"},
            "odom0_config must be a list of 15 bools, true for what to use of odom0, not None: using 'nothing ",
        ),
        ({"odom0": "odom", "odom0_config": [True]}, "odom0_config must be a list of 15 bools, true for what"),
        ({"odom0": 5, "odom0_config": [True] * 15}, "odom0 must be a string, not 5"),
        ({"frequency": 0}, "frequency must be a number from 0.01 to 10000, not 0: using 30.0"),
        ({"use_control": True, "control_config": "all"}, "control_config must be a list of 6 bools, not 'all'"),
    ],
)
def test_parameters_that_cannot_be_used_are_reported(parameters: dict[str, Any], problem: str) -> None:
    settings, problems = read(parameters)
    assert problem in problems[0]
    assert len(problems) == 1 or parameters["odom0"] == 5, "one line says it all"
    assert settings.sensors == ()
    assert np.diag(settings.process_noise).tolist() == list(DEFAULT_NOISE)


def test_control() -> None:
    settings, _ = read(
        {
            "use_control": True,
            "control_config": [True, False, False, False, False, True],
            "acceleration_limits": [1.3, 0, 0, 0, 0, 3.4],
            "control_timeout": 0.2,
        }
    )
    assert settings.control is not None
    assert np.nonzero(settings.control.used)[0].tolist() == [0, 5]
    assert settings.control.deceleration_limits.tolist() == [1.3, 0, 0, 0, 0, 3.4], "as the acceleration's"
    assert settings.control.deceleration_gains.tolist() == [1.0] * 6
    assert settings.control.timeout == 0.2


def test_a_history_needs_smoothing() -> None:
    assert read({"history_length": 2.0})[0].history == 0.0
    assert read({"history_length": 2.0, "smooth_lagged_data": True})[0].history == 2.0


def test_frames_get_the_tf_prefix() -> None:
    settings, _ = read({"odom_frame": "/odom"}, "red")
    assert (settings.world_frame, settings.base_frame) == ("red/odom", "red/base_link")
    assert [prefixed("odom", "/red/"), prefixed("red/odom", "red"), prefixed("/odom", "")] == ["red/odom"] * 2 + [
        "odom"
    ]
