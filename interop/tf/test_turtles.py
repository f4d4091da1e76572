"""The turtles of tf2's tutorials, launched as their page says; stock's tf_echo sees their frames."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from harness import Master, until

from pyros1.finding.packages import OWN_PACKAGES

OWN_MASTER = True
MASTERS = ("ours",)  # the nodes do not care
TF_ECHO = Path("/usr/lib/tf/tf_echo")

pytestmark = [
    pytest.mark.ours_only,
    pytest.mark.skipif(not TF_ECHO.exists(), reason="tf is not installed; run interop/setup"),
]


def test_one_turtle_follows_the_other(launcher: Master) -> None:
    """Feature: the tf2 tutorials' turtles, one following the other -- `pyros1 launch turtle_tf2
    turtle_tf2_demo.launch`
    """
    words = [sys.executable, "-m", "pyros1", "launch", "turtle_tf2", "turtle_tf2_demo.launch", "keys:=false"]
    launcher.run(words, python="ours", ROS_PACKAGE_PATH=OWN_PACKAGES)
    until(lambda: launcher.publishers("/turtle2/cmd_vel"), "the follower has begun")
    echo = launcher.run(["stdbuf", "-oL", str(TF_ECHO), "turtle2", "turtle1"])
    distance = 4.0
    while distance > 1.0:  # it begins 3.9 units away
        x, y, z = map(float, echo.wait_line(r"Translation: \[(\S+), (\S+), (\S+)\]", 60).groups())
        assert z == 0.0
        distance = (x * x + y * y) ** 0.5


def test_keys_need_a_terminal(launcher: Master) -> None:
    launch = launcher.run([sys.executable, "-m", "pyros1", "run", "turtlesim", "turtle_teleop_key"], python="ours")
    assert launch.wait(60) == 1
    assert re.search(
        r"\[FATAL\].*standard input is not a terminal: run this in a terminal of its own", "\n".join(launch.lines)
    )
    assert "Traceback" not in "\n".join(launch.lines)
