"""Other names in ROS 2, and its log: stock ROS 1 nodes, and a ROS 2 program that is not ours.

Feature: mapping rules of ros1_bridge for `pyros1 bridge ros2` -- with stock's rostopic, and zenoh-ros2-sdk
Feature: ROS 2's log in `pyros1 console` and rosout_agg -- with stock's rosout, and zenoh-ros2-sdk
"""

from __future__ import annotations

import sys
from pathlib import Path

from harness import Master, Process, free_port

from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.installed import InstalledTypes
from pyros1.ros2_types.nesting import LayeredTypes
from pyros1.ros2_types.type_hash import type_hash

MASTERS = ("stock",)
OWN_MASTER = True
PEER = Path(__file__).parents[1] / "peers" / "ros2_sdk_mapping_peer.py"
START = 60.0
FLAT = "builtin_interfaces/Time stamp\nfloat32 east\nfloat64 north\nstring extra\n"
RULES = """
- ros1_package_name: geometry_msgs
  ros1_message_name: PointStamped
  ros2_package_name: flat_interfaces
  ros2_message_name: Flat
  fields_1_to_2:
    header.stamp: stamp
    point.x: east
    point.y: north
"""
POINT = "{header: {stamp: {secs: 7, nsecs: 8}}, point: {x: 1.5, y: 2.5, z: 3}}"


def test_a_mapping_file_and_the_log(launcher: Master, tmp_path: Path) -> None:
    folder = tmp_path / "flat_interfaces" / "msg"
    folder.mkdir(parents=True)
    (folder / "Flat.msg").write_text(FLAT)
    (tmp_path / "map.yaml").write_text(RULES)
    types = LayeredTypes(InstalledTypes([tmp_path]), distribution_types())
    hashes = [type_hash(name, types) for name in ("rcl_interfaces/msg/Log", "flat_interfaces/msg/Flat")]
    port = free_port()

    def start(python: str, label: str, *command: str) -> Process:
        process = Process(command, launcher.environ(python), label)
        launcher.processes.append(process)
        return process

    words = ["--listen", f"tcp/127.0.0.1:{port}", "--mapping", str(tmp_path / "map.yaml")]
    words += ["--ros2-packages", str(tmp_path)]
    bridge = start("ours", "bridge", sys.executable, "-m", "pyros1", "bridge", "ros2", *words)
    bridge.wait_line("^bridge to ROS 2", START)
    peer = start("ours", "ROS 2", sys.executable, str(PEER), str(port), *hashes)
    peer.wait_line("^ready", START)
    start("stock", "pub", "rostopic", "pub", "-r", "5", "/flat_from_ros1", "geometry_msgs/PointStamped", POINT)
    peer.wait_line(r"^got 7 1\.5 2\.5 ''$", START)
    echo = start("stock", "echo", "rostopic", "echo", "/flat_from_ros2/point")
    echo.wait_line(r"^x: 0\.5$", START)
    log = start("stock", "log", "rostopic", "echo", "/rosout_agg")
    assert log.wait_line('^msg: "?hot ', START)
    assert any(line.startswith("level: 8") for line in log.lines)
    bridge.wait_line("only ROS 1 has header.frame_id, point.z, only ROS 2 has extra", START)
