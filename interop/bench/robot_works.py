"""The nodes of robots whose processor time robot_nodes.py measures: what each is given, how often, and what it makes.

All names are in one namespace, as in a robot's launch file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from robot_devices import Board, Stick

from pyros1.ground.timing import Time
from pyros1.msgs import load_message

PACKAGES = Path(__file__).resolve().parents[2] / "src" / "pyros1" / "packages"
MAP = PACKAGES / "two_wheeler" / "maps" / "flat.yaml"


@dataclass(frozen=True)
class Feed:
    """Messages that are published at a rate.

    Attributes:
        topic, type: where, and of what type.
        hz: the rate.
        make: returns the message, with everything that stays the same.
        change: changes it before it is published, given the seconds since the first.
    """

    topic: str
    type: str
    hz: float
    make: Callable[[Any], Any] = lambda message: message
    change: Callable[[Any, float], object] = lambda message, seconds: None

    def open(self, node: Any, values: Mapping[str, str]) -> Callable[[float], object]:
        """Return a function that publishes the next message, given the seconds since the first."""
        cls = load_message(self.type)
        message, begun = self.make(cls()), float(values["begun"])
        publisher = node.advertise(self.topic, cls, queue_size=2)

        def publish(seconds: float) -> None:
            self.change(message, seconds)
            if hasattr(message, "header"):
                message.header.stamp = Time.from_sec(begun + seconds)  # an image and its camera_info: the same
            publisher.publish(message)

        return publish


@dataclass(frozen=True)
class Work:
    """What a node does.

    Attributes:
        ours: its package, program and arguments; here and in the parameters, ``{home}`` is a folder and ``{port}`` a
            free port.
        feeds: what it is given.
        outputs: topics that it publishes, and their types.
        hz: how many messages it publishes there per second; 0 if it has nothing to do.
        params: its private parameters.
        stock: stock's program below /usr/lib, if Debian has it.
    """

    ours: tuple[str, ...]
    feeds: tuple[Feed | Stick | Board, ...]
    outputs: Mapping[str, str]
    hz: float
    params: Mapping[str, Any] = field(default_factory=dict)
    stock: str = ""


def _image(encoding: str, channels: int, dtype: str = "u1") -> Callable[[Any], Any]:
    """Return what makes an image of 640 x 480 pixels."""

    def make(image: Any) -> Any:
        y, x, place = np.mgrid[0:480, 0:640, 0:channels]
        pixels = ((np.sin(x / (9 + place)) * np.cos(y / 11) + 1.5) * (100 if dtype == "u1" else 1200)).astype(dtype)
        image.height, image.width, image.encoding, image.step = 480, 640, encoding, pixels.nbytes // 480
        image.data = pixels.tobytes()
        image.header.frame_id = "camera"
        return image

    return make


def _camera_info(info: Any) -> Any:
    info.height, info.width, info.distortion_model = 480, 640, "plumb_bob"
    info.D = [-0.32, 0.11, 0.002, -0.001, 0.0]
    info.K = [525.0, 0.0, 319.5, 0.0, 525.0, 239.5, 0.0, 0.0, 1.0]
    info.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    info.P = [525.0, 0.0, 319.5, 0.0, 0.0, 525.0, 239.5, 0.0, 0.0, 0.0, 1.0, 0.0]
    info.header.frame_id = "camera"
    return info


def _scan(scan: Any) -> Any:
    angles = np.linspace(-2.35, 2.35, 720)
    scan.angle_min, scan.angle_max, scan.angle_increment = -2.35, 2.35, 4.7 / 719
    scan.range_max, scan.header.frame_id = 30.0, "laser"
    scan.ranges = (3.0 + np.sin(5 * angles) + 0.5 * (np.arange(720) % 90 == 0)).tolist()
    scan.intensities = [100.0] * 720
    return scan


def _cloud(cloud: Any) -> Any:
    points = np.random.default_rng(1).uniform(-5.0, 5.0, (30_000, 4)).astype("<f4")
    fields = [load_message("sensor_msgs/PointField")(axis, 4 * place, 7, 1) for place, axis in enumerate("xyz")]
    cloud.height, cloud.width, cloud.fields, cloud.point_step = 1, len(points), fields, 16
    cloud.row_step, cloud.data, cloud.header.frame_id = points.nbytes, points.tobytes(), "lidar"
    return cloud


def _imu(imu: Any) -> Any:
    imu.header.frame_id, imu.orientation.w, imu.linear_acceleration.z = "base_link", 1.0, 9.80665
    for name in ("orientation", "angular_velocity", "linear_acceleration"):
        setattr(imu, f"{name}_covariance", [0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.01])
    return imu


def _odometry(odometry: Any) -> Any:
    odometry.header.frame_id, odometry.child_frame_id, odometry.pose.pose.orientation.w = "odom", "base_link", 1.0
    odometry.pose.covariance = odometry.twist.covariance = [0.01 if place % 7 == 0 else 0.0 for place in range(36)]
    return odometry


def _joy(joy: Any) -> Any:
    joy.axes, joy.buttons = [0.0, 0.5, 0.0, 0.3, 0.0, 0.0], [1] * 12
    return joy


def _drive(twist: Any, seconds: float) -> None:
    twist.linear.x, twist.angular.z = math.sin(seconds), math.cos(seconds)


def _statuses(first: int) -> Callable[[Any], Any]:
    """Return what makes an array of five statuses with five values each."""
    status, value = load_message("diagnostic_msgs/DiagnosticStatus"), load_message("diagnostic_msgs/KeyValue")

    def make(array: Any) -> Any:
        values = [value(f"value {number}", str(number)) for number in range(5)]
        names = (f"driver{number % 4}: item {number}" for number in range(first, first + 5))
        array.status = [status(0, name, "OK", "none", values) for name in names]
        return array

    return make


INFO = Feed("camera_info", "sensor_msgs/CameraInfo", 30, _camera_info)
IMU = Feed("imu/data_raw", "sensor_msgs/Imu", 100, _imu)
TWIST, SCAN, IMAGE = "geometry_msgs/Twist", "sensor_msgs/LaserScan", "sensor_msgs/Image"


def _filters(*names_and_params: tuple[str, dict[str, Any]]) -> list[dict[str, Any]]:
    return [{"name": name, "type": f"laser_filters/{name}", "params": params} for name, params in names_and_params]


def _mask(*used: int) -> list[bool]:
    return [place in used for place in range(15)]


WORKS: Mapping[str, Work] = {
    "joy_node: 50 events/s": Work(
        ("joy", "joy_node"), (Stick("{home}/js0", 50),), {"joy": "sensor_msgs/Joy"}, 50, {"dev": "{home}/js0"}
    ),
    "teleop_twist_joy: 50 Hz": Work(
        ("teleop_twist_joy", "teleop_node"), (Feed("joy", "sensor_msgs/Joy", 50, _joy),), {"cmd_vel": TWIST}, 50
    ),
    "twist_mux: 3 inputs, 20 Hz each": Work(
        ("twist_mux", "twist_mux"),
        tuple(Feed(f"in{number}", TWIST, 20, change=_drive) for number in range(3)),
        {"cmd_vel_out": TWIST},
        20,
        {
            "topics": [
                {"name": f"in{number}", "topic": f"in{number}", "timeout": 0.5, "priority": number}
                for number in range(3)
            ]
        },
    ),
    "velocity_smoother: 20 Hz": Work(
        ("yocs_velocity_smoother", "velocity_smoother"),
        (Feed("tool/raw_cmd_vel", TWIST, 20, change=_drive),),
        {"tool/smooth_cmd_vel": TWIST},
        20,
        {"speed_lim_v": 0.8, "speed_lim_w": 5.4, "accel_lim_v": 0.3, "accel_lim_w": 3.5},
    ),
    "laser_filters: 3 filters, 720 rays, 40 Hz": Work(
        ("laser_filters", "scan_to_scan_filter_chain"),
        (Feed("scan", SCAN, 40, _scan),),
        {"scan_filtered": SCAN},
        40,
        {
            "scan_filter_chain": _filters(
                ("LaserScanRangeFilter", {"lower_threshold": 0.2, "upper_threshold": 10.0}),
                ("ScanShadowsFilter", {"min_angle": 10, "max_angle": 170, "neighbors": 2, "window": 1}),
                ("LaserScanAngularBoundsFilter", {"lower_angle": -2.0, "upper_angle": 2.0}),
            )
        },
    ),
    "depthimage_to_laserscan: 640 x 480, 30 Hz": Work(
        ("depthimage_to_laserscan", "depthimage_to_laserscan"),
        (Feed("image", IMAGE, 30, _image("16UC1", 1, "u2")), INFO),
        {"scan": SCAN},
        30,
    ),
    "pointcloud_to_laserscan: 30,000 points, 10 Hz": Work(
        ("pointcloud_to_laserscan", "pointcloud_to_laserscan_node"),
        (Feed("cloud_in", "sensor_msgs/PointCloud2", 10, _cloud),),
        {"scan": SCAN},
        10,
    ),
    "image_proc: rectify bgr8, 640 x 480, 30 Hz": Work(
        ("image_proc", "image_proc"),
        (Feed("image_raw", IMAGE, 30, _image("bgr8", 3)), INFO),
        {"image_rect_color": IMAGE},
        30,
        stock="image_proc/image_proc",
    ),
    "image_proc: rectify mono8, 640 x 480, 30 Hz": Work(
        ("image_proc", "image_proc"),
        (Feed("image_raw", IMAGE, 30, _image("mono8", 1)), INFO),
        {"image_rect": IMAGE},
        30,
        stock="image_proc/image_proc",
    ),
    "image_proc: debayer, 640 x 480, 30 Hz": Work(
        ("image_proc", "image_proc"),
        (Feed("image_raw", IMAGE, 30, _image("bayer_rggb8", 1)), INFO),
        {"image_color": IMAGE},
        30,
        stock="image_proc/image_proc",
    ),
    "image_proc: debayer and rectify, 640 x 480, 30 Hz": Work(
        ("image_proc", "image_proc"),
        (Feed("image_raw", IMAGE, 30, _image("bayer_rggb8", 1)), INFO),
        {"image_rect_color": IMAGE},
        30,
        stock="image_proc/image_proc",
    ),
    "imu_filter_madgwick: 100 Hz": Work(
        ("imu_filter_madgwick", "imu_filter_node"), (IMU,), {"imu/data": "sensor_msgs/Imu"}, 100, {"use_mag": False}
    ),
    "imu_complementary_filter: 100 Hz": Work(
        ("imu_complementary_filter", "complementary_filter_node"), (IMU,), {"imu/data": "sensor_msgs/Imu"}, 100
    ),
    "ekf_localization_node: odometry 50 Hz, IMU 100 Hz, output 30 Hz": Work(
        ("robot_localization", "ekf_localization_node"),
        (Feed("odom", "nav_msgs/Odometry", 50, _odometry), IMU),
        {"odometry/filtered": "nav_msgs/Odometry"},
        30,
        {
            "frequency": 30,
            "two_d_mode": True,
            "odom0": "odom",
            "odom0_config": _mask(6, 7, 11),
            "imu0": "imu/data_raw",
            "imu0_config": _mask(5, 11, 12),
            "world_frame": "odom",
        },
    ),
    "diagnostic_aggregator: 20 items, 1 Hz each": Work(
        ("diagnostic_aggregator", "aggregator_node"),
        tuple(Feed("/diagnostics", "diagnostic_msgs/DiagnosticArray", 1, _statuses(first)) for first in (0, 5, 10, 15)),
        {"/diagnostics_agg": "diagnostic_msgs/DiagnosticArray"},
        1,
        {
            "analyzers": {
                f"driver{number}": {
                    "type": "diagnostic_aggregator/GenericAnalyzer",
                    "path": f"Driver {number}",
                    "startswith": f"driver{number}",
                }
                for number in range(4)
            }
        },
        stock="diagnostic_aggregator/aggregator_node",
    ),
    "rosserial_python: IMU 100 Hz": Work(
        ("rosserial_python", "serial_node.py", "tcp", "{port}"),
        (Board("{port}", "imu/data_raw", "sensor_msgs/Imu", 100, _imu),),
        {"imu/data_raw": "sensor_msgs/Imu"},
        100,
    ),
    "map_server: idle": Work(("map_server", "map_server", str(MAP)), (), {"map": "nav_msgs/OccupancyGrid"}, 0),
    "flat_world: 10 robots, 360 rays, 20 Hz": Work(
        ("two_wheeler", "flat_world"),
        tuple(Feed(f"robot{number}/cmd_vel", TWIST, 10, change=_drive) for number in range(1, 11)),
        {f"robot{number}/scan": SCAN for number in range(1, 11)},
        200,
        {"map": str(MAP), "robots": 10, "rays": 360, "scan_rate": 20.0, "localization": True},
    ),
}
"""By what is measured."""
