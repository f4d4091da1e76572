"""Parameters of ROS 2 nodes, with stock's dynparam and dynamic_reconfigure's client.

The node is written with zenoh-ros2-sdk and, where PYROS1_ROS2_PYTHON names a Python that has it (see `test_rclpy.py`),
with rclpy.

Feature: parameters of ROS 2 nodes in dynamic_reconfigure's tools -- with stock's dynparam, zenoh-ros2-sdk and rclpy
Feature: parameters of ROS 2 nodes, read by a command -- `pyros1 bridge param ros2:`, zenoh-ros2-sdk and rclpy
"""

from __future__ import annotations

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from harness import STOCK_PYTHON, Master, Process, free_port, until

MASTERS = ("stock",)
OWN_MASTER = True
PEERS = Path(__file__).parents[1] / "peers"
PYTHON = os.environ.get("PYROS1_ROS2_PYTHON", "")
DYNPARAM = "/usr/lib/dynamic_reconfigure/dynparam"
NODE = "/ros2_camera"
START = 60.0
WATCH = f"""
import sys
import rospy
from dynamic_reconfigure.client import Client
rospy.init_node("watch")
def show(*words):
    sys.stdout.write(" ".join(map(str, words)) + chr(10))
    sys.stdout.flush()
client = Client("{NODE}")
for each in client.get_parameter_descriptions():
    show("described", *(each[key] for key in ("name", "type", "min", "max", "description")))
client.get_configuration()
client.set_config_callback(lambda config: show("rate", config["rate"]))
rospy.spin()
"""


class Sides:
    """A stock master, the bridge, and the ROS 2 node."""

    def __init__(self, master: Master, way: str) -> None:
        self.master = master
        self._ros2_environ: dict[str, str] = {}
        port = str(free_port())
        words, python, peer = ["--listen", f"tcp/127.0.0.1:{port}"], sys.executable, "ros2_sdk_parameters_peer.py"
        if way == "rclpy":
            words, python, peer = ["--via", "rclpy"], PYTHON, "rclpy_parameters_peer.py"
            domain = str(random.randrange(1, 100))
            self._ros2_environ = {"ROS_DOMAIN_ID": domain, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        bridge = [python, "-m", "pyros1", "bridge", "ros2", *words, "--reconfigure", NODE]
        self.bridge = self.start("ours", "bridge", *bridge)
        self.bridge.wait_line("^bridge to ROS 2", START)
        self.ros2 = self.start("ours", "ROS 2", python, str(PEERS / peer), port)
        self.ros2.wait_line("^ready", START)
        until(lambda: NODE in self.dynparam("list"), "dynparam lists it", timeout=START)

    def start(self, python: str, label: str, *command: str) -> Process:
        process = Process(command, self.master.environ(python) | self._ros2_environ, label)
        self.master.processes.append(process)
        return process

    def dynparam(self, *words: str) -> str:
        """Return what stock's dynparam prints."""
        return self.run("stock", STOCK_PYTHON, DYNPARAM, *words)

    def param(self, *words: str) -> str:
        """Return what `pyros1 bridge param` prints."""
        return self.run("ours", sys.executable, "-m", "pyros1", "bridge", "param", *words)

    def run(self, python: str, *command: str) -> str:
        """Return what a program prints."""
        environ = self.master.environ(python)
        return subprocess.run(command, env=environ, capture_output=True, text=True, timeout=START, check=True).stdout


@pytest.fixture(params=["zenoh", "rclpy"] if PYTHON else ["zenoh"])
def sides(launcher: Master, request: pytest.FixtureRequest) -> Sides:
    return Sides(launcher, request.param)


def test_stock_tools_of_dynamic_reconfigure(sides: Sides, tmp_path: Path) -> None:
    watch = sides.start("stock", "watch", STOCK_PYTHON, "-c", WATCH)
    watch.wait_line(r"^described rate int 1 9 the rate$", START)
    watch.wait_line(r"^rate 5$", START)
    sides.dynparam("set", NODE, "rate", "7")
    sides.ros2.wait_line("^set rate 7$", START)
    watch.wait_line(r"^rate 7$", START)
    sides.dynparam("set", NODE, "gains.p", "2.5")
    sides.ros2.wait_line(r"^set gains\.p 2\.5$", START)
    sides.dynparam("set", NODE, "rate", "4")
    assert "refuses to set rate to 4: it must be odd" in sides.bridge.wait_line("refuses to set.*").string
    sides.ros2.write("rate 3")
    watch.wait_line(r"^rate 3$", START)
    file = tmp_path / "camera.yaml"
    sides.dynparam("dump", NODE, str(file))
    dumped = {line.strip() for line in file.read_text().splitlines()}  # with tags of stock's own classes
    assert {"rate: 3", "gains.p: 2.5", "frame: map", "use_sim_time: false"} <= dumped
    assert "limits" not in file.read_text()
    file.write_text("{rate: 9, frame: odom}")
    sides.dynparam("load", NODE, str(file))
    sides.ros2.wait_line("^set frame odom$", START)
    watch.wait_line(r"^rate 9$", START)


def test_own_dynparam(sides: Sides) -> None:
    ours = ("ours", sys.executable, "-m", "pyros1", "dynparam")
    assert NODE in sides.run(*ours, "list").splitlines()
    sides.run(*ours, "set", NODE, "rate", "9")
    sides.ros2.wait_line("^set rate 9$", START)
    assert yaml.safe_load(sides.run(*ours, "get", NODE))["rate"] == 9


def test_parameters_are_read_by_a_command(sides: Sides) -> None:
    assert sides.param("ros2:").splitlines() == [NODE]
    values = yaml.safe_load(sides.param("ros2:", NODE))
    expected = {"rate": 5, "gains.p": 1.5, "frame": "map", "use_sim_time": False, "limits": [1.0, 2.5]}
    assert expected.items() <= values.items()
    assert sides.param("ros2:", f"{NODE}/gains.p") == "1.5\n"
    assert yaml.safe_load(sides.param(f"ros2:{NODE}/limits")) == [1.0, 2.5]
    sides.param("ros2:", f"{NODE}/limits", "--to", "/limits")
    assert yaml.safe_load(sides.run("stock", "rosparam", "get", "/limits")) == [1.0, 2.5]
