"""rosbash's functions in a real bash, and those of `pyros1 setup`: the same folders, files and exit codes (L184)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from harness import SOURCE

STOCK = "source /usr/share/bash-completion/completions/rosbash"
OURS = "source <(pyros1 setup --shell bash)"

COMMANDS = [
    "roscd roscpp && pwd",
    "roscd roscpp/cmake && pwd",
    "roscd nope 2>&1; echo $?",
    "roscd >/dev/null 2>&1; echo $?",
    "CMAKE_PREFIX_PATH=$HOME/bin:$HOME/ros roscd && pwd",
    "CMAKE_PREFIX_PATH=$HOME/bin:$HOME/ros ROS_WORKSPACE=$HOME/bin roscd && pwd",
    "CMAKE_PREFIX_PATH=$HOME/bin roscd >/dev/null 2>&1; echo $?",
    "roscd log && pwd",
    "roscd here && pwd",
    "rosls std_msgs",
    "rosls std_msgs/msg | head -3",
    "roscat std_msgs String.msg",
    "roscat std_msgs nope.msg >/dev/null 2>&1; echo $?",
    "rosed std_msgs String.msg",
    "roscp std_msgs String.msg copied && cat copied",
    "rospd roscpp >/dev/null && pwd && rospd rospy >/dev/null && pwd && rosd | wc -l",
    "rospd roscpp >/dev/null && rospd rospy > /dev/null && rospd 1 > /dev/null && pwd",
]


@pytest.fixture
def place(tmp_path: Path) -> Path:
    (tmp_path / "bin").mkdir()
    program = tmp_path / "bin" / "pyros1"
    program.write_text(f'#!/bin/sh\nPYTHONPATH="{SOURCE}" exec "{sys.executable}" -m pyros1 "$@"\n')
    program.chmod(0o755)
    (tmp_path / "ros" / "log").mkdir(parents=True)
    (tmp_path / "ros" / ".catkin").touch()  # a devel space
    return tmp_path


def bash(setup: str, command: str, place: Path) -> tuple[str, int]:
    environ = {
        "PATH": f"{place / 'bin'}:/usr/bin:/bin",
        "HOME": str(place),
        "ROS_HOME": str(place / "ros"),
        "ROS_PACKAGE_PATH": "/usr/share",
        "ROS_LOCATIONS": f"here={place}",
        "EDITOR": "head -n 1",
    }
    done = subprocess.run(
        ["bash", "--norc", "-c", f"{setup}\n{command}"],
        cwd=place, env=environ, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    return done.stdout, done.returncode


@pytest.mark.parametrize("command", COMMANDS)
def test_functions(place: Path, command: str) -> None:
    stock, ours = bash(STOCK, command, place), bash(OURS, command, place)
    assert ours == stock
