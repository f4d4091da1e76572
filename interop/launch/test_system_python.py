"""Scripts of Debian's ROS packages ask for the first Python on the PATH, here one without their modules: they run.

Feature: Debian's scripts run from a virtual environment -- for example its joint_state_publisher
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from harness import Master, Process

from pyros1.finding.packages import PackageIndex

pytestmark = pytest.mark.ours_only

FILE = """<launch>
  <param name="robot_description" textfile="{robot}"/>
  <node pkg="joint_state_publisher" type="joint_state_publisher" name="joint_state_publisher" output="screen"/>
</launch>
"""
ROBOT = """<robot name="arm">
  <link name="base"/><link name="arm"/>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="arm"/></joint>
</robot>
"""


@pytest.fixture(params=["launch", "run"])
def publisher(request: pytest.FixtureRequest, launcher: Master, tmp_path: Path) -> Process:
    """Debian's joint_state_publisher, started from an environment whose python3 has no modules of Debian's ROS."""
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "python3").write_text(f'#!/bin/sh\nexec "{sys.executable}" -I "$@"\n')
    (programs / "python3").chmod(0o755)
    words = ["run", "joint_state_publisher", "joint_state_publisher"]
    (tmp_path / "arm.urdf").write_text(ROBOT)
    (tmp_path / "arm.launch").write_text(FILE.format(robot=tmp_path / "arm.urdf"))
    if request.param == "launch":
        words = ["launch", str(tmp_path / "arm.launch")]
    else:
        assert launcher.call("setParam", "/robot_description", ROBOT)[0] == 1
    path = f"{programs}:{launcher.environ('ours')['PATH']}"
    return launcher.run([sys.executable, "-m", "pyros1", *words], python="ours", PATH=path, ROS_PACKAGE_PATH=None)


def test_debians_joint_state_publisher(publisher: Process, launcher: Master) -> None:
    assert PackageIndex({}).find_folder("joint_state_publisher") == "/usr/share/joint_state_publisher"
    said = launcher.tool("rostopic", "echo", "-n", "1", "/joint_states/name")
    assert "shoulder" in said
