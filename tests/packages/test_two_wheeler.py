"""The example of a robot: its description, and the launch file that shows it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import Queue
from typing import Any

import pytest

import pyros1
from pyros1.finding.packages import OWN_PACKAGES
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.nav_msgs.msg import OccupancyGrid, Odometry
from pyros1.msgs.sensor_msgs.msg import JointState, LaserScan
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.urdf.joints import JointStates, Options
from pyros1.urdf.kinematics import Kinematics
from pyros1.urdf.reading import read_robot
from pyros1.web.scene.rviz.file import read_rviz

PATIENCE = 20.0
ROBOT = Path(OWN_PACKAGES) / "two_wheeler" / "urdf" / "two_wheeler.urdf"
SOURCE = Path(pyros1.__file__).parents[1]


def test_the_description_is_one_of_a_robot() -> None:
    robot = read_robot(ROBOT.read_text("utf-8"))
    states = JointStates(robot, Options())
    assert robot.warnings == () and states.warnings == []
    assert Kinematics(robot).root == "base_footprint"
    assert {joint.type for joint in robot.joints.values()} == {"fixed", "continuous", "revolute", "prismatic"}
    assert list(states.followers) == ["right_finger_joint"]


def test_the_view_of_the_world_has_its_map_and_its_robot() -> None:
    file = Path(OWN_PACKAGES) / "two_wheeler" / "rviz" / "world.rviz"
    settings, notes = read_rviz(file.read_text("utf-8"), lambda name: name)
    assert (settings["fixed"], settings["topics"], notes) == ("map", ["/map", "/scan", "/odom"], [])
    assert settings["robots"] == ["robot_description"]


@contextmanager
def launched(environ: dict[str, str], *words: str) -> Iterator[None]:
    """Run a launch file of the package."""
    process = subprocess.Popen(
        [sys.executable, "-m", "pyros1", "launch", "two_wheeler", *words],
        env={**os.environ, **environ, "ROS_PACKAGE_PATH": OWN_PACKAGES, "PYTHONPATH": str(SOURCE)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield
    finally:
        process.terminate()
        process.wait(PATIENCE)


@pytest.mark.slow
def test_display_launch_runs_without_ros(environ: dict[str, str], make_node: Callable[..., Any]) -> None:
    """Feature: the robot of the package two_wheeler, launched without ROS"""
    came: Queue[Any] = Queue()
    ear = make_node("ear")
    ear.subscribe("/tf", TFMessage, came.put)
    ear.subscribe("/tf_static", TFMessage, came.put)
    with launched(environ, "display.launch", "gui:=false"):
        seen: set[str] = set()
        while not {"camera", "lift", "left_wheel", "right_finger"} <= seen:
            seen |= {each.child_frame_id for each in came.get(timeout=PATIENCE).transforms}


@pytest.mark.slow
def test_world_launch_has_a_robot_that_drives_in_its_map(
    environ: dict[str, str], make_node: Callable[..., Any]
) -> None:
    """Feature: the simulated robot of the package two_wheeler: `pyros1 launch two_wheeler world.launch`"""
    user = make_node("user")
    commands = user.advertise("cmd_vel", Twist)
    command = Twist()
    command.linear.x = 0.5
    states: Queue[Any] = Queue()
    truths: Queue[Any] = Queue()
    user.subscribe("joint_states", JointState, states.put)
    user.subscribe("base_pose_ground_truth", Odometry, truths.put)
    with launched(environ, "world.launch", "speed:=10", "x:=0.5", "seed:=3"):
        grid = user.wait_for_message("map", OccupancyGrid, PATIENCE)
        scan = user.wait_for_message("scan", LaserScan, PATIENCE)
        truth = truths.get(timeout=PATIENCE)
        assert truth.pose.pose.position.x == 0.5
        while truth.pose.pose.position.x < 1.5:
            commands.publish(command)
            truth = truths.get(timeout=PATIENCE)
        state = states.get(timeout=PATIENCE)
        while "lift_joint" not in state.name or state.position[state.name.index("left_wheel_joint")] < 5:
            commands.publish(command)
            state = states.get(timeout=PATIENCE)
    info = grid.info
    column = int((0.5 + 0.1 + scan.ranges[180] + 0.03 - info.origin.position.x) / info.resolution)
    row = int(-info.origin.position.y / info.resolution)
    assert 100 in grid.data[row * info.width + column - 1 : row * info.width + column + 2]  # the wall that it sees
