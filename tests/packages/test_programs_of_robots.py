"""The programs that launch files of robots name, started as nodes of a launch file."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import pytest

import pyros1
from pyros1.finding.packages import OWN_PACKAGES
from pyros1.graph import Graph
from pyros1.ground.names import resolve_name

PATIENCE = 40.0
PACKAGES = Path(OWN_PACKAGES)
MUX = PACKAGES / "yocs_cmd_vel_mux" / "param" / "example.yaml"
LIMITS = "speed_lim_v: 1, speed_lim_w: 1, accel_lim_v: 1, accel_lim_w: 1"
SOURCES = "[{name: a, topic: a, timeout: 0.5, priority: 1}]"
PROGRAMS = f"""
cv_camera cv_camera_node | device_path: /no/such | ~image_raw
depthimage_to_laserscan depthimage_to_laserscan | | scan
diagnostic_aggregator aggregator_node | analyzers: {{a: {{type: GenericAnalyzer, path: A}}}} | /diagnostics_agg
image_transport republish raw | | in
imu_filter_madgwick imu_filter_node | | imu/data_raw
interactive_marker_twist_server marker_server | | ~cmd_vel
joint_state_publisher joint_state_publisher | rate: 1 | joint_states
joint_state_publisher_gui joint_state_publisher_gui | rate: 1 | joint_states
joy joy_node | dev: /no/such | joy
joy joy_remap.py | mappings: {{axes: ["axes[0]"]}} | joy_out
laser_filters scan_to_scan_filter_chain | scan_filter_chain: [] | scan_filtered
map_server map_saver -f OUTPUT map:=no_map | | no_map
map_server map_server {PACKAGES / "two_wheeler" / "maps" / "flat.yaml"} | | map
nodelet nodelet load image_proc/rectify manager | | image_rect
nodelet nodelet load yocs_cmd_vel_mux/CmdVelMuxNodelet manager | yaml_cfg_file: {MUX} | ~output/cmd_vel
nodelet nodelet load yocs_velocity_smoother/VelocitySmootherNodelet manager | {LIMITS} | ~raw_cmd_vel
nodelet nodelet manager | | ~list
pointcloud_to_laserscan pointcloud_to_laserscan_node | | scan
robot_localization ekf_localization_node | odom0: odom, odom0_config: [{"true, " * 14}false] | odometry/filtered
robot_localization navsat_transform_node | | odometry/gps
robot_state_publisher robot_state_publisher | | joint_states
robot_state_publisher state_publisher joint_states:=no_joints | | no_joints
rosapi rosapi_node | | /rosapi/topics
rosbag record -O OUTPUT in | | in
rosbridge_server rosbridge_websocket | port: 0 | client_count
rosserial_python serial_node.py | port: /no/such | /diagnostics
teleop_twist_joy teleop_node | | cmd_vel
tf static_transform_publisher 0 0 0 0 0 0 a b 100 | | /tf
tf tf_change_notifier | | /tf
tf2_ros static_transform_publisher 0 0 0 0 0 0 a b | | /tf_static
tf2_web_republisher tf2_web_republisher | | republish_tfs
topic_tools mux out in other | | in
topic_tools relay in relayed | | in
topic_tools throttle messages in 1 slow | | in
twist_mux twist_marker | | marker
twist_mux twist_mux | topics: {SOURCES} | cmd_vel_out
usb_cam usb_cam_node | video_device: /no/such | ~image_raw
web_video_server web_video_server | port: 0 | ~get_loggers
"""
"""Package, program and arguments | private parameters | a topic or service that the node registers."""


@pytest.mark.slow
def test_every_program_is_a_node_of_a_launch_file(
    environ: dict[str, str], make_node: Callable[..., Any], tmp_path: Path
) -> None:
    """Feature: launch files start the everyday nodes of robots: their topics and services come, and Ctrl-C ends them"""
    wanted: set[tuple[str, str]] = set()
    nodes = []
    for number, line in enumerate(PROGRAMS.strip().splitlines()):
        command, parameters, name = (part.strip() for part in line.split("|"))
        package, program, *args = command.replace("OUTPUT", str(tmp_path / f"output{number}")).split()
        wanted.add((resolve_name(name, f"/node{number}"), f"/node{number}"))
        nodes.append(
            f'<node pkg="{package}" type="{program}" name="node{number}" args={quoteattr(" ".join(args))}'
            f' output="screen"><rosparam>{{{parameters}}}</rosparam></node>'
        )
    urdf = PACKAGES / "two_wheeler" / "urdf" / "two_wheeler.urdf"
    launch_file = tmp_path / "robot.launch"
    launch_file.write_text(
        f'<launch><param name="robot_description" textfile="{urdf}"/>{"".join(nodes)}</launch>', encoding="utf-8"
    )
    output = tmp_path / "output.txt"
    master = make_node("watcher").master
    with output.open("wb") as stream:
        process = subprocess.Popen(
            [sys.executable, "-m", "pyros1", "launch", "--preload", str(launch_file)],
            env={
                **os.environ,
                **environ,
                "BROWSER": "true",
                "ROS_PACKAGE_PATH": OWN_PACKAGES,
                "PYTHONPATH": str(Path(pyros1.__file__).parents[1]),
            },
            stdin=subprocess.DEVNULL,
            stdout=stream,
            stderr=subprocess.STDOUT,
        )
    try:
        deadline = time.monotonic() + PATIENCE
        while (missing := wanted - registered(master)) and time.monotonic() < deadline:
            assert process.poll() is None, output.read_text(encoding="utf-8")
            time.sleep(0.1)
        assert not missing, output.read_text(encoding="utf-8")
        process.send_signal(signal.SIGINT)
        process.wait(PATIENCE)
    finally:
        process.kill()
        process.wait(PATIENCE)
    text = output.read_text(encoding="utf-8")
    assert not [word for word in ("Traceback", "has died", "escalating") if word in text], text
    assert not wanted & registered(master), "they all said goodbye to the master"


def registered(master: Any) -> set[tuple[str, str]]:
    """Return what nodes have registered with the master: the names of topics and services, each with a node."""
    state = Graph(master).state()
    lists = (state.publishers, state.subscribers, state.services)
    return {(name, node) for names in lists for name, nodes in names.items() for node in nodes}
