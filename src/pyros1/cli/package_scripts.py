"""The commands that scripts in pyros1's ROS packages run. All scripts are identical and look up their command here.

The scripts are files so that every ``rosrun`` and every launcher can find them. They are not links because wheels
cannot contain links. To add a script, copy any other one to ``packages/PACKAGE/scripts/`` and add its command here. The
scripts of minimal_nodes are different: they are examples for users.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from importlib import import_module

from pyros1.cli.shared.gui_programs import PROGRAMS_BY_PACKAGE
from pyros1.ground.errors import Error


def _program(module: str, function: str = "main") -> Callable[[], int]:
    """Return a function that imports a module, calls its function with the command line, and returns the exit code."""

    def run_program() -> int:
        code: int = getattr(import_module(module), function)(sys.argv)
        return code

    return run_program


def _xacro() -> int:
    from pyros1.launch.reading.xacro_tool import main  # noqa: PLC0415 - each process runs only one script

    return main()


_TOPIC_TOOLS = """
demux demux_add demux_delete demux_list demux_select drop mux mux_add mux_delete mux_list mux_select relay relay_field
switch_mux throttle transform
"""
_TEST_NODES = "advertisetest hztest paramtest publishtest subscribetest"

SCRIPTS: Mapping[str, Mapping[str, str | Callable[[], int]]] = {
    "cv_camera": {"cv_camera_node": _program("pyros1.robot_nodes.usb_cam.programs", "main_cv_camera")},
    "depthimage_to_laserscan": {
        "depthimage_to_laserscan": _program("pyros1.robot_nodes.depthimage_to_laserscan.node"),
    },
    "diagnostic_aggregator": {
        "add_analyzers": _program("pyros1.robot_nodes.diagnostic_aggregator.add_analyzers"),
        "aggregator_node": _program("pyros1.robot_nodes.diagnostic_aggregator.node"),
        "analyzer_loader": _program("pyros1.test_nodes.program"),
    },
    "dynamic_reconfigure": {"dynparam": "dynparam"},
    "image_proc": {
        "image_proc": _program("pyros1.robot_nodes.image_proc.programs"),
        **{
            name: _program("pyros1.robot_nodes.image_proc.programs", f"main_{name}")
            for name in ("crop_decimate", "debayer", "rectify", "resize")
        },
    },
    "image_transport": {"republish": _program("pyros1.topic_tools.republish")},
    "imu_complementary_filter": {
        "complementary_filter_node": _program("pyros1.robot_nodes.imu_complementary_filter.node"),
    },
    "imu_filter_madgwick": {"imu_filter_node": _program("pyros1.robot_nodes.imu_filter_madgwick.node")},
    "interactive_marker_twist_server": {
        "marker_server": _program("pyros1.robot_nodes.interactive_marker_twist_server.node")
    },
    "joint_state_publisher": {"joint_state_publisher": _program("pyros1.urdf.joint_publisher")},
    "joint_state_publisher_gui": {"joint_state_publisher_gui": _program("pyros1.cli.joint_sliders")},
    "joy": {
        "joy_node": _program("pyros1.robot_nodes.joy.node"),
        "joy_remap.py": _program("pyros1.robot_nodes.joy.remap_node"),
    },
    "laser_filters": {"scan_to_scan_filter_chain": _program("pyros1.robot_nodes.laser_filters.node")},
    "map_server": {name: _program(f"pyros1.robot_nodes.map_server.{name[4:]}") for name in ("map_saver", "map_server")},
    "nodelet": {"nodelet": _program("pyros1.cli.nodelet_program")},
    "pointcloud_to_laserscan": {
        "laserscan_to_pointcloud_node": _program("pyros1.robot_nodes.pointcloud_to_laserscan.node", "scan_to_cloud"),
        "pointcloud_to_laserscan_node": _program("pyros1.robot_nodes.pointcloud_to_laserscan.node", "cloud_to_scan"),
    },
    "robot_state_publisher": {
        "robot_state_publisher": _program("pyros1.urdf.state_publisher"),
        "state_publisher": _program("pyros1.urdf.state_publisher", "deprecated_main"),
    },
    "rosapi": {"rosapi_node": _program("pyros1.web.rosapi_node")},
    "robot_localization": {
        "ekf_localization_node": _program("pyros1.robot_nodes.robot_localization.ekf_node"),
        "navsat_transform_node": _program("pyros1.robot_nodes.robot_localization.navsat_node"),
        "ukf_localization_node": _program("pyros1.robot_nodes.robot_localization.ukf_node"),
    },
    "rosbag": {"play": "bag play", "record": "bag record"},
    "rosbridge_server": {
        **{
            f"rosbridge_{name}": _program("pyros1.web.rosbridge_server.node", "unsupported")
            for name in ("tcp", "tcp.py", "udp", "udp.py")
        },
        "rosbridge_websocket": _program("pyros1.web.rosbridge_server.node"),
        "rosbridge_websocket.py": _program("pyros1.web.rosbridge_server.node"),
    },
    "rosout": {"rosout": _program("pyros1.robot_nodes.rosout.node")},
    "rosparam": {"rosparam": "param"},
    "rosserial_python": {"serial_node.py": _program("pyros1.robot_nodes.rosserial_python.node")},
    "rosservice": {"rosservice": "service"},
    "rostest": dict.fromkeys(_TEST_NODES.split(), _program("pyros1.test_nodes.program")),
    "rostopic": {"rostopic": "topic"},
    "teleop_twist_joy": {"teleop_node": _program("pyros1.robot_nodes.teleop_twist_joy.node")},
    "teleop_twist_keyboard": {
        "teleop_twist_keyboard.py": _program("pyros1.robot_nodes.teleop_twist_keyboard.node"),
    },
    "tf": {
        "static_transform_publisher": "tf static_transform_publisher --tf",
        "tf_change_notifier": "tf change_notifier",
        "tf_echo": "tf echo",
        "tf_monitor": "tf monitor",
        "tf_remap": "tf remap",
        "view_frames": "tf view_frames",
    },
    "tf2_ros": {
        "buffer_server": "tf buffer_server",
        "static_transform_publisher": "tf static_transform_publisher --tf2",
    },
    "tf2_tools": {"echo.py": "tf echo --tf2", "view_frames.py": "tf view_frames"},
    "tf2_web_republisher": {"tf2_web_republisher": _program("pyros1.topic_tools.tf2_web_republisher")},
    "topic_tools": {name: f"topic_tools {name}" for name in _TOPIC_TOOLS.split()},
    "turtle_tf2": {
        "turtle_tf2_broadcaster": _program("pyros1.turtlesim.following", "broadcast"),
        "turtle_tf2_broadcaster.py": _program("pyros1.turtlesim.following", "broadcast"),
        "turtle_tf2_listener": _program("pyros1.turtlesim.following", "follow"),
        "turtle_tf2_listener.py": _program("pyros1.turtlesim.following", "follow"),
    },
    "turtlesim": {
        "draw_square": _program("pyros1.turtlesim.square"),
        "mimic": _program("pyros1.turtlesim.mimic"),
        "turtle_teleop_key": _program("pyros1.turtlesim.teleop"),
        "turtle_view": _program("pyros1.turtlesim.view"),
        "turtlesim_node": _program("pyros1.turtlesim.simulator"),
    },
    "twist_mux": {
        "joystick_relay.py": _program("pyros1.robot_nodes.twist_mux.relay"),
        "twist_marker": _program("pyros1.robot_nodes.twist_mux.marker"),
        "twist_mux": _program("pyros1.robot_nodes.twist_mux.node"),
    },
    "two_wheeler": {"flat_world": _program("pyros1.robot_nodes.flat_world.simulator")},
    "usb_cam": {"usb_cam_node": _program("pyros1.robot_nodes.usb_cam.programs", "main_usb_cam")},
    "web_video_server": {"web_video_server": _program("pyros1.web.web_video_server.node")},
    "xacro": {"xacro": _xacro},
    "yocs_cmd_vel_mux": {"cmd_vel_mux": _program("pyros1.robot_nodes.yocs_cmd_vel_mux.node")},
    "yocs_velocity_smoother": {"velocity_smoother": _program("pyros1.robot_nodes.yocs_velocity_smoother.node")},
    **{package: {name: f"web {name}" for name in names} for package, names in PROGRAMS_BY_PACKAGE.items()},
}
"""By package and script: the arguments of ``pyros1``, or a function that runs the script and returns an exit code."""


def run(file: str) -> None:
    """Run the command for a script with this process's arguments, and exit.

    Args:
        file: the script, or a link to it.
    """
    *folders, name = os.path.realpath(file).split(os.sep)
    package = next(folder for folder in reversed(folders) if folder in SCRIPTS)
    command = SCRIPTS[package][name]
    if callable(command):
        try:
            code = command()
        except Error as error:  # for example, the master's address is invalid
            sys.exit(f"ERROR: {name}: {error}")
        sys.exit(code)
    from pyros1.cli.dispatch import dispatch  # noqa: PLC0415 - not needed by the programs above

    sys.exit(dispatch(["pyros1", *command.split(), *sys.argv[1:]], alone=True))
