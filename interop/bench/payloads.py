"""The messages of the benchmarks: how they are filled, what changes from message to message, what a subscriber reads.

The same for every library; `roscpp_bench.cpp` says it again in C++.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

JOINTS = 7
TRANSFORMS = 20
RANGES = 720
POSES = MARKERS = 100
STATUSES, VALUES = 20, 5
TEXT_LENGTH = 100


@dataclass(frozen=True)
class Payload:
    """What travels on a topic.

    Attributes:
        type_name: the message type.
        fill: makes a fresh message what is published; given the message, a function from a type's name to its class,
            and the size of its data in bytes (images and clouds).
        change: what the publisher does before each message; given the message, how many there were, and a clock.
        read: what the subscriber's callback reads; the size in bytes for what is measured in MB/s.
    """

    type_name: str
    fill: Callable[[Any, Callable[[str], Any], int], None]
    change: Callable[[Any, int, Callable[[], Any]], None]
    read: Callable[[Any], Any]


def leave(message: Any, load: Callable[[str], Any], size: int) -> None:
    """The default values will do."""


def change_float(message: Any, count: int, clock: Callable[[], Any]) -> None:
    message.data += 0.001


def change_twist(message: Any, count: int, clock: Callable[[], Any]) -> None:
    message.linear.x += 0.001


def change_text(message: Any, count: int, clock: Callable[[], Any]) -> None:
    message.data = TEXTS[count & 1]


TEXTS = ("a" * TEXT_LENGTH, "b" * TEXT_LENGTH)


def stamp(message: Any, count: int, clock: Callable[[], Any]) -> None:
    message.header.stamp = clock()


def stamp_transform(message: Any, count: int, clock: Callable[[], Any]) -> None:
    message.transforms[0].header.stamp = clock()


def fill_joints(message: Any, load: Callable[[str], Any], size: int) -> None:
    message.header.frame_id = "base_link"
    message.name = [f"joint_{i}" for i in range(JOINTS)]
    message.position = [0.1 * i for i in range(JOINTS)]
    message.velocity = [0.2 * i for i in range(JOINTS)]
    message.effort = [0.3 * i for i in range(JOINTS)]


def fill_odometry(message: Any, load: Callable[[str], Any], size: int) -> None:
    message.header.frame_id, message.child_frame_id = "odom", "base_link"
    message.pose.pose.orientation.w = 1.0


def fill_transforms(message: Any, load: Callable[[str], Any], size: int) -> None:
    message.transforms = [load("geometry_msgs/TransformStamped")() for _ in range(TRANSFORMS)]
    for i, transform in enumerate(message.transforms):
        transform.header.frame_id, transform.child_frame_id = "base_link", f"link_{i}"
        transform.transform.rotation.w = 1.0


def fill_imu(message: Any, load: Callable[[str], Any], size: int) -> None:
    message.header.frame_id = "imu"
    message.orientation.w, message.linear_acceleration.z = 1.0, 9.81


def fill_scan(message: Any, load: Callable[[str], Any], size: int) -> None:
    message.header.frame_id = "laser"
    message.angle_min, message.angle_max, message.range_max = -1.5, 1.5, 10.0
    message.ranges = [0.01 * i for i in range(RANGES)]


def fill_poses(message: Any, load: Callable[[str], Any], size: int) -> None:
    message.header.frame_id = "map"
    message.poses = [load("geometry_msgs/Pose")() for _ in range(POSES)]
    for i, pose in enumerate(message.poses):
        pose.position.x, pose.orientation.w = 0.1 * i, 1.0


def fill_pose_columns(message: Any, load: Callable[[str], Any], size: int) -> None:
    """The same poses in a numpy array, for pyros1."""
    import numpy

    from pyros1.msgs import record_dtype

    message.header.frame_id = "map"
    message.poses = numpy.zeros(POSES, record_dtype(load("geometry_msgs/Pose")))
    message.poses["position"]["x"] = 0.1 * numpy.arange(POSES)
    message.poses["orientation"]["w"] = 1.0


def fill_markers(message: Any, load: Callable[[str], Any], size: int) -> None:
    marker_class = load("visualization_msgs/Marker")
    message.markers = [marker_class() for _ in range(MARKERS)]
    for i, marker in enumerate(message.markers):
        marker.header.frame_id, marker.ns, marker.id, marker.type = "map", "bench", i, marker_class.SPHERE
        marker.pose.position.x, marker.pose.orientation.w = 0.1 * i, 1.0
        marker.scale.x = marker.scale.y = marker.scale.z = 0.1
        marker.color.a = 1.0


def fill_diagnostics(message: Any, load: Callable[[str], Any], size: int) -> None:
    message.status = [load("diagnostic_msgs/DiagnosticStatus")() for _ in range(STATUSES)]
    for i, status in enumerate(message.status):
        status.name, status.message, status.hardware_id = f"bench: device {i}", "OK", f"device {i}"
        status.values = [load("diagnostic_msgs/KeyValue")(f"value {j}", str(10 * i + j)) for j in range(VALUES)]


def stamp_marker(message: Any, count: int, clock: Callable[[], Any]) -> None:
    message.markers[0].header.stamp = clock()


def fill_image(message: Any, load: Callable[[str], Any], size: int) -> None:
    message.height, message.width, message.step, message.encoding = 1, size, size, "mono8"
    message.data = bytes(size)


def fill_cloud(message: Any, load: Callable[[str], Any], size: int) -> None:
    message.height, message.width, message.point_step, message.row_step = 1, size // 16, 16, size
    message.fields = [load("sensor_msgs/PointField")(name, 4 * i, 7, 1) for i, name in enumerate("xyz")]
    message.data = bytes(size)


def read_position(message: Any) -> float:
    return float(message.position[0])


def read_transforms(message: Any) -> int:
    return len(message.transforms)


def read_range(message: Any) -> float:
    return float(message.ranges[-1])


def read_pose(message: Any) -> float:
    return float(message.poses[-1].position.x)


def read_pose_columns(message: Any) -> float:
    return float(message.poses["position"]["x"][-1])


def read_marker(message: Any) -> float:
    return float(message.markers[-1].pose.position.x)


def read_status(message: Any) -> str:
    return str(message.status[-1].values[-1].value)


def read_data(message: Any) -> int:
    """The last byte of an image too, and how many there are."""
    data = message.data
    size: int = len(data) + 0 * data[-1]
    return size


PAYLOADS = {
    "Float64": Payload("std_msgs/Float64", leave, change_float, attrgetter("data")),
    "String": Payload("std_msgs/String", leave, change_text, attrgetter("data")),
    "Twist": Payload("geometry_msgs/Twist", leave, change_twist, attrgetter("linear.x")),
    "JointState": Payload("sensor_msgs/JointState", fill_joints, stamp, read_position),
    "Odometry": Payload("nav_msgs/Odometry", fill_odometry, stamp, attrgetter("pose.pose.position.x")),
    "TFMessage": Payload("tf2_msgs/TFMessage", fill_transforms, stamp_transform, read_transforms),
    "Imu": Payload("sensor_msgs/Imu", fill_imu, stamp, attrgetter("linear_acceleration.z")),
    "LaserScan": Payload("sensor_msgs/LaserScan", fill_scan, stamp, read_range),
    "PoseArray": Payload("geometry_msgs/PoseArray", fill_poses, stamp, read_pose),
    "PoseColumns": Payload("geometry_msgs/PoseArray", fill_pose_columns, stamp, read_pose_columns),
    "MarkerArray": Payload("visualization_msgs/MarkerArray", fill_markers, stamp_marker, read_marker),
    "DiagnosticArray": Payload("diagnostic_msgs/DiagnosticArray", fill_diagnostics, stamp, read_status),
    "Image": Payload("sensor_msgs/Image", fill_image, stamp, read_data),
    "PointCloud2": Payload("sensor_msgs/PointCloud2", fill_cloud, stamp, read_data),
}
