"""The sample messages that every peer builds for itself, field by field, from a seed.

``cpp/samples.hpp`` holds the same formulas. That equal seeds give equal bytes in roscpp, rospy and pyros1 is what the
type tests show. The functions here know message classes only through ``new(type_name)`` and the two time classes, so
that rospy and pyros1 share them.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any


def text(seed: int) -> str:
    """A string beyond ASCII and beyond the basic multilingual plane."""
    return f"Grüße 世界 🤖 {seed}"


def data(size: int) -> bytes:
    """*size* bytes whose pattern has a period of 251, which no power of two hides."""
    return (bytes(range(251)) * (size // 251 + 1))[:size]


def reals(size: int, seed: float) -> list[float]:
    """*size* numbers, an eighth apart, that float32 holds exactly."""
    return [seed + i / 8.0 for i in range(size)]


class Samples:
    """Builds sample messages with the classes of one implementation.

    Args:
        new: message instance with default values for a type name such as ``std_msgs/String``.
        time: class of time values, called with seconds and nanoseconds.
        duration: class of duration values, called with seconds and nanoseconds.
    """

    def __init__(self, new: Callable[[str], Any], time: Callable[[int, int], Any], duration: Callable[[int, int], Any]):
        self.new = new
        self.time = time
        self.duration = duration

    def stamp(self, seed: int) -> Any:
        return self.time(1700000000 + seed, 123456789)

    def span(self, seed: int) -> Any:
        return self.duration(-seed, 500000000)

    def build(self, type_name: str, seed: int) -> Any:
        """The sample of *type_name* for *seed*; KeyError when this module has no formula for the type."""
        message = self.new(type_name)
        FORMULAS[type_name](self, message, seed)
        return message

    def fill(self, message: Any, seed: int) -> None:
        FORMULAS[message._type](self, message, seed)


def _value(make: Callable[[Samples, int], Any]) -> Callable[[Samples, Any, int], None]:
    def fill(samples: Samples, m: Any, s: int) -> None:
        m.data = make(samples, s)

    return fill


def _nothing(_: Samples, __: Any, ___: int) -> None:
    return None


def _header(samples: Samples, m: Any, s: int) -> None:
    m.seq, m.stamp, m.frame_id = s, samples.stamp(s), f"map é {s}"


def _layout(samples: Samples, m: Any, s: int) -> None:
    m.dim = [samples.new("std_msgs/MultiArrayDimension") for _ in range(2)]
    m.dim[0].label, m.dim[0].size, m.dim[0].stride = text(s), 2, 4
    m.dim[1].size = 4294967295
    m.data_offset = s


def _array(make: Callable[[int], Any]) -> Callable[[Samples, Any, int], None]:
    def fill(samples: Samples, m: Any, s: int) -> None:
        samples.fill(m.layout, s)
        m.data = make(s)

    return fill


def _vector(_: Samples, m: Any, s: int) -> None:
    m.x, m.y, m.z = float(s), s + 0.25, float(-s)


def _quaternion(_: Samples, m: Any, s: int) -> None:
    m.x, m.y, m.z, m.w = 0.0, float(s), 0.5, 1.0


def _pose(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.position, s)
    samples.fill(m.orientation, s)


def _joint_state(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    m.name = [text(s), "", "joint"]
    m.position = reals(3, s)
    m.velocity = reals(1, -s)


def _imu(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    samples.fill(m.orientation, s)
    m.orientation_covariance = reals(9, s)
    samples.fill(m.angular_velocity, s + 1)
    m.angular_velocity_covariance = [0.0] * 8 + [float(s)]
    samples.fill(m.linear_acceleration, s + 2)
    m.linear_acceleration_covariance = reals(9, -s)


def _camera_info(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    m.height, m.width, m.distortion_model = 480, 640, "plumb_bob"
    m.D, m.K, m.R, m.P = reals(5, s), reals(9, s), reals(9, s + 1), reals(12, s + 2)
    m.binning_x = 2
    m.roi.x_offset, m.roi.do_rectify = s, True


def _laser_scan(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    m.angle_min, m.angle_max = -1.5, 1.5
    m.ranges = reals(100, s)
    m.ranges[7] = float("inf")


def _point_cloud(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    m.height, m.width = 1, 100
    for i, name in enumerate("xyz"):
        field = samples.new("sensor_msgs/PointField")
        field.name, field.offset, field.datatype, field.count = name, 4 * i, 7, 1
        m.fields.append(field)
    m.point_step, m.row_step, m.data, m.is_dense = 12, 1200, data(1200), True


def _image(samples: Samples, m: Any, s: int) -> None:  # the seed is the number of bytes
    m.header.frame_id, m.header.stamp = "camera", samples.stamp(7)
    m.height, m.width, m.step, m.encoding, m.data = 1, s, s, "mono8", data(s)


def _odometry(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    m.child_frame_id = "base_link"
    samples.fill(m.pose.pose, s)
    m.pose.covariance = reals(36, s)
    samples.fill(m.twist.twist.linear, s)
    samples.fill(m.twist.twist.angular, s + 1)
    m.twist.covariance = reals(36, -s)


def _transform(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    m.child_frame_id = text(s)
    samples.fill(m.transform.translation, s)
    samples.fill(m.transform.rotation, s)


def _tf(samples: Samples, m: Any, s: int) -> None:
    m.transforms = [samples.build("geometry_msgs/TransformStamped", s + i) for i in range(2)]


def _diagnostics(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    first, second = (samples.new("diagnostic_msgs/DiagnosticStatus") for _ in range(2))
    m.status = [first, second]
    first.level, first.name = 1, text(s)
    first.values = [samples.new("diagnostic_msgs/KeyValue") for _ in range(2)]
    first.values[1].key = "ключ"
    second.level, second.hardware_id = 3, text(s + 1)


def _marker(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    m.ns, m.id, m.type, m.action = text(s), -s, 10, 3
    samples.fill(m.pose, s)
    samples.fill(m.scale, s)
    m.color.r, m.color.a = 0.5, 1.0
    m.lifetime, m.frame_locked = samples.span(s), True
    m.points = [samples.new("geometry_msgs/Point"), samples.build("geometry_msgs/Point", s)]
    m.colors = [samples.new("std_msgs/ColorRGBA")]
    m.colors[0].b = 0.25
    m.text = text(s + 1)


def _trajectory(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    m.joint_names = ["a", text(s)]
    first, second = (samples.new("trajectory_msgs/JointTrajectoryPoint") for _ in range(2))
    m.points = [first, second]
    first.positions, first.time_from_start = reals(2, s), samples.duration(s, 1)
    second.effort, second.time_from_start = reals(4, s), samples.span(s)


def _log(samples: Samples, m: Any, s: int) -> None:
    samples.fill(m.header, s)
    m.level, m.name, m.msg, m.line, m.topics = 4, "/node", text(s), s, ["/rosout", ""]


def _statistics(samples: Samples, m: Any, s: int) -> None:
    m.topic = "/t"
    m.window_start, m.window_stop = samples.stamp(s), samples.stamp(s + 1)
    m.delivered_msgs, m.period_mean = -s, samples.span(s)
    m.stamp_age_max = samples.duration(s, 999999999)


def _get_plan(samples: Samples, m: Any, s: int) -> None:
    for pose, seed in ((m.start, s), (m.goal, s + 1)):
        samples.fill(pose.header, seed)
        samples.fill(pose.pose, seed)
    m.tolerance = 0.5


FORMULAS: dict[str, Callable[[Samples, Any, int], None]] = {
    "std_msgs/Empty": _nothing,
    "std_msgs/Bool": _value(lambda _, s: bool(s % 2)),
    "std_msgs/Int8": _value(lambda _, s: -(s % 100) - 1),
    "std_msgs/Int64": _value(lambda _, s: -(1 << 62) - s),
    "std_msgs/UInt64": _value(lambda _, s: (1 << 63) + s),
    "std_msgs/Float32": _value(lambda _, s: s + 0.125),
    "std_msgs/Float64": _value(lambda _, s: s + 0.1),
    "std_msgs/Time": _value(Samples.stamp),
    "std_msgs/Duration": _value(Samples.span),
    "std_msgs/String": _value(lambda _, s: text(s)),
    "std_msgs/Header": _header,
    "std_msgs/MultiArrayLayout": _layout,
    "std_msgs/ByteMultiArray": _array(lambda s: [-128, 0, 127, s % 100]),
    "std_msgs/UInt8MultiArray": _array(lambda s: data(300 + s)),
    "std_msgs/Int32MultiArray": _array(lambda s: [-(1 << 31), s, (1 << 31) - 1]),
    "geometry_msgs/Vector3": _vector,
    "geometry_msgs/Point": _vector,
    "geometry_msgs/Quaternion": _quaternion,
    "geometry_msgs/Pose": _pose,
    "geometry_msgs/TransformStamped": _transform,
    "sensor_msgs/JointState": _joint_state,
    "sensor_msgs/Imu": _imu,
    "sensor_msgs/CameraInfo": _camera_info,
    "sensor_msgs/LaserScan": _laser_scan,
    "sensor_msgs/PointCloud2": _point_cloud,
    "sensor_msgs/Image": _image,
    "nav_msgs/Odometry": _odometry,
    "tf2_msgs/TFMessage": _tf,
    "diagnostic_msgs/DiagnosticArray": _diagnostics,
    "visualization_msgs/Marker": _marker,
    "trajectory_msgs/JointTrajectory": _trajectory,
    "rosgraph_msgs/Log": _log,
    "rosgraph_msgs/TopicStatistics": _statistics,
}

# The types that the type tests send; the others above are parts of them.
TYPES = [name for name in FORMULAS if not name.startswith("geometry_msgs/") and name != "std_msgs/MultiArrayLayout"]

REQUESTS: dict[str, Callable[[Samples, Any, int], None]] = {
    "std_srvs/Empty": _nothing,
    "std_srvs/Trigger": _nothing,
    "std_srvs/SetBool": _value(lambda _, s: bool(s % 2)),
    "nav_msgs/GetPlan": _get_plan,
}


def reply(type_name: str, request: Any, response: Any) -> Any:
    """Fill *response* with what every peer's service answers to *request*, and return it."""
    if type_name == "std_srvs/Trigger":
        response.success, response.message = True, text(1)
    elif type_name == "std_srvs/SetBool":
        response.success, response.message = request.data, "on — é" if request.data else "off"
    elif type_name == "nav_msgs/GetPlan":
        response.plan.header, response.plan.poses = request.goal.header, [request.start, request.goal]
    return response


PARAMETERS: dict[str, Any] = {
    "int": 42,
    "negative": -2147483647,
    "float": 0.1,
    "whole": 3.0,
    "true": True,
    "false": False,
    "text": text(1) + " <&>",
    "empty": "",
    "list": [1, "two", 3.5, [True]],
    "dict": {"a": 1, "b": {"c": text(2), "d": [0.25]}},
    "binary": b"\x00\x01\xff\n",
}


def show(value: Any) -> str:
    """A parameter value in the one form that all peers print: JSON, sorted keys, %.17g, binary as ``<hex>``."""
    if isinstance(value, list | tuple):
        out = "[" + ", ".join(show(item) for item in value) + "]"
    elif isinstance(value, dict):
        out = "{" + ", ".join(f"{show(key)}: {show(value[key])}" for key in sorted(value)) + "}"
    elif isinstance(value, bool):
        out = "true" if value else "false"
    elif isinstance(value, float):
        out = f"{value:.17g}"
        out += "" if "." in out or "e" in out or "n" in out else ".0"
    elif isinstance(value, str):
        out = '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    elif isinstance(value, bytes):
        out = f"<{value.hex()}>"
    else:
        out = str(value)
    return out


def unpack_log(body: str) -> tuple[int, str, str]:
    """Level, node name and text of a serialized rosgraph_msgs/Log given in hexadecimal."""
    raw = bytes.fromhex(body)
    offset = 12 + 4 + int(struct.unpack_from("<I", raw, 12)[0])
    level = raw[offset]
    offset += 1
    strings = []
    for _ in range(2):
        (size,) = struct.unpack_from("<I", raw, offset)
        strings.append(raw[offset + 4 : offset + 4 + size].decode())
        offset += 4 + size
    return level, strings[0], strings[1]
