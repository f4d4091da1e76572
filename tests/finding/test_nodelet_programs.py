from __future__ import annotations

import pytest

from pyros1.cli.package_scripts import SCRIPTS
from pyros1.finding.nodelet_programs import find_program, is_throttle, package_of


@pytest.mark.parametrize(
    ("class_name", "programs", "program"),
    [
        ("image_proc/rectify", ["debayer", "rectify", "image_proc"], "rectify"),
        (
            "depthimage_to_laserscan/DepthImageToLaserScanNodelet",
            ["depthimage_to_laserscan"],
            "depthimage_to_laserscan",
        ),
        ("yocs_velocity_smoother/VelocitySmootherNodelet", ["velocity_smoother"], "velocity_smoother"),
        ("yocs_cmd_vel_mux/CmdVelMuxNodelet", ["cmd_vel_mux", "other"], "cmd_vel_mux"),
        (
            "pointcloud_to_laserscan/pointcloud_to_laserscan_nodelet",
            ["laserscan_to_pointcloud_node", "pointcloud_to_laserscan_node"],
            "pointcloud_to_laserscan_node",
        ),
        ("cv_camera/CvCameraNodelet", ["cv_camera_node"], "cv_camera_node"),
        ("imu_filter_madgwick/ImuFilterNodelet", ["imu_filter_node.py", "imu_filter_node"], "imu_filter_node"),
        ("demo::Talker", ["talker.py"], "talker.py"),
        ("RobotLocalization/EkfNodelet", ["ukf_localization_node", "ekf_localization_node"], "ekf_localization_node"),
        ("RobotLocalization/EkfNodelet", ["ekf"], ""),
        ("image_proc/crop", ["debayer", "rectify"], ""),
        ("demo/Nodelet", ["node", "nodelet", "x"], ""),
    ],
)
def test_programs(class_name: str, programs: list[str], program: str) -> None:
    assert find_program(class_name, programs) == program


@pytest.mark.parametrize(
    "class_name",
    [
        *(f"image_proc/{name}" for name in ("crop_decimate", "debayer", "rectify", "resize")),
        *(f"RobotLocalization/{name}Nodelet" for name in ("Ekf", "Ukf", "NavSatTransform")),
        "cv_camera/CvCameraNodelet",
        "depthimage_to_laserscan/DepthImageToLaserScanNodelet",
        "imu_filter_madgwick/ImuFilterNodelet",
        "laser_filters/ScanToScanFilterChain",
        "pointcloud_to_laserscan/laserscan_to_pointcloud_nodelet",
        "pointcloud_to_laserscan/pointcloud_to_laserscan_nodelet",
        "yocs_cmd_vel_mux/CmdVelMuxNodelet",
        "yocs_velocity_smoother/VelocitySmootherNodelet",
    ],
)
def test_nodelets_of_robots_have_a_program_here(class_name: str) -> None:
    assert find_program(class_name, SCRIPTS[package_of(class_name)])


def test_throttles() -> None:
    assert all(map(is_throttle, ["camera/NodeletThrottleImage", "NodeletThrottleImage", "a::NodeletThrottle"]))
    assert not any(map(is_throttle, ["pointcloud_to_laserscan/CloudThrottle", "NodeletThrottleImage/rectify", ""]))


def test_packages() -> None:
    assert package_of("image_proc/rectify") == package_of("image_proc::Rectify") == "image_proc"
    assert package_of("RobotLocalization/UkfNodelet") == "robot_localization"
    assert package_of("rectify") == package_of("") == ""
