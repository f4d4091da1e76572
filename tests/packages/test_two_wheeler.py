"""The example of a robot: its description, and the launch file that shows it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from queue import Queue
from typing import Any

import pyros1
from pyros1.finding.packages import OWN_PACKAGES
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.urdf.joints import JointStates, Options
from pyros1.urdf.kinematics import Kinematics
from pyros1.urdf.reading import read_robot

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


def test_display_launch_runs_without_ros(environ: dict[str, str], make_node: Callable[..., Any]) -> None:
    """Feature: the robot of the package two_wheeler, launched without ROS"""
    came: Queue[Any] = Queue()
    ear = make_node("ear")
    ear.subscribe("/tf", TFMessage, came.put)
    ear.subscribe("/tf_static", TFMessage, came.put)
    process = subprocess.Popen(
        [sys.executable, "-m", "pyros1", "launch", "two_wheeler", "display.launch", "gui:=false"],
        env={**os.environ, **environ, "ROS_PACKAGE_PATH": OWN_PACKAGES, "PYTHONPATH": str(SOURCE)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        seen: set[str] = set()
        while not {"camera", "lift", "left_wheel", "right_finger"} <= seen:
            seen |= {each.child_frame_id for each in came.get(timeout=PATIENCE).transforms}
    finally:
        process.terminate()
        process.wait(PATIENCE)
