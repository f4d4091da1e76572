"""By hand: how long it takes to convert messages between ROS 1's encoding and ROS 2's, beside the rosbags library.

`python interop/ros2/conversion_speed.py` prints a table in half a minute; see interop/ros2.md.
"""

from __future__ import annotations

import timeit
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from pyros1.msgs import load_message
from pyros1.ros2.pairs.type_pairs import TypePairs

ROUNDS = 7


def messages() -> dict[str, Any]:
    """Return messages that robots send, by the names of their types."""

    def make(type_name: str, /, **given: Any) -> Any:
        return load_message(type_name)(**given)

    joints = [float(number) for number in range(12)]
    names = [f"joint_{number}" for number in range(12)]
    poses = [make("geometry_msgs/Pose") for _ in range(100)]
    transforms = [make("geometry_msgs/TransformStamped", child_frame_id="child") for _ in range(10)]
    fields: dict[str, dict[str, Any]] = {
        "nav_msgs/Odometry": {},
        "sensor_msgs/LaserScan": {"ranges": [1.0] * 720},
        "sensor_msgs/Image": {"height": 480, "width": 640, "encoding": "rgb8", "step": 1920, "data": bytes(921_600)},
        "sensor_msgs/JointState": {"name": names, "position": joints, "velocity": joints, "effort": joints},
        "geometry_msgs/PoseArray": {"poses": poses},
        "tf2_msgs/TFMessage": {"transforms": transforms},
    }
    return {name: make(name, **given) for name, given in fields.items()}


def store() -> Any:
    """Return rosbags' ROS 2 types."""
    found = get_typestore(Stores.ROS2_JAZZY)
    if "tf2_msgs/msg/TFMessage" not in found.fielddefs:
        found.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
    return found


def microseconds(call: Any, data: bytes) -> float:
    """Return how long a call takes, at best."""
    number = 50 if len(data) > 100_000 else 1000
    return min(timeit.repeat(lambda: call(data), number=number, repeat=ROUNDS)) / number * 1e6


def main() -> None:
    """Print the table."""
    ros2 = store()
    pairs = TypePairs()
    print("| µs per message | to ROS 2, rosbags | pyros1 | to ROS 1, rosbags | pyros1 |")
    print("|---|---|---|---|---|")
    for name, message in messages().items():
        message_class = load_message(name)
        pair = pairs.for_ros1(name, message_class._md5sum, message_class._full_text)
        body = message_class._encode(message)
        cdr = pair.transcoder.to_cdr(body)
        assert bytes(ros2.ros1_to_cdr(body, pair.ros2)) == cdr
        cells = (
            microseconds(lambda data, type=pair.ros2: ros2.ros1_to_cdr(data, type), body),
            microseconds(pair.transcoder.to_cdr, body),
            microseconds(lambda data, type=pair.ros2: ros2.cdr_to_ros1(data, type), cdr),
            microseconds(pair.transcoder.from_cdr, cdr),
        )
        print(f"| {name} |", " | ".join(f"{cell:.1f}" for cell in cells), "|", flush=True)


if __name__ == "__main__":
    main()
