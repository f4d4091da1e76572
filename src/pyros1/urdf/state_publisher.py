"""robot_state_publisher: publishes the poses of a robot's links, computed from the positions of its joints.

See https://wiki.ros.org/robot_state_publisher.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import AnyMsg
from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.node import Node
from pyros1.node.topic_type import topic_type
from pyros1.tf.rotation import Transform
from pyros1.urdf.description import check_number, robot_description
from pyros1.urdf.kinematics import Kinematics
from pyros1.urdf.reading import read_robot
from pyros1.urdf.tf_encoder import TransformBatch

_QUEUE_SIZE = 100
_LEAD_TIME_NS = 500_000_000
"""Nanoseconds by which poses of fixed links on /tf are dated ahead, so that they are valid until the next message."""
_OLD_MESSAGE_AGE = 30.0
"""Age in seconds above which a message is reported as old."""
_MAX_UNKNOWN_NAMES = 1_000
"""Maximum number of names that a message may have in addition to the robot's joints."""
_MAX_JOINT_SETS = 32
"""Maximum number of different sets of joints whose encoders are cached."""


@dataclass(frozen=True)
class Settings:
    """The parameters of robot_state_publisher.

    Attributes:
        publish_frequency: maximum number of messages per second with the same joint; values below 1 count as 1.
        ignore_timestamp: whether every message is used, even if its stamp is earlier than the last message's, or too
            soon after it.
        use_tf_static: whether fixed links are published once, on /tf_static, instead of repeatedly, on /tf.
        prefix: prefix of frame names; empty for none.
    """

    publish_frequency: float = 50.0
    ignore_timestamp: bool = False
    use_tf_static: bool = True
    prefix: str = ""


@dataclass(frozen=True)
class _JointSet:
    """Cached data for all JointState messages that contain the same joints.

    Attributes:
        batch: the encoder for the message with the links' poses.
        joints: names of the joints of these links, in the encoder's order.
        unknown: a name in these messages that is not in the description; empty if there is none.
    """

    batch: TransformBatch
    joints: tuple[str, ...]
    unknown: str


class RobotStatePublisher:
    """Publishes the poses of a robot's links whenever joint states arrive, until the node shuts down.

    Args:
        node: the node that subscribes to joint_states and publishes on /tf and /tf_static.
        kinematics: computes the links' poses.
        settings: the node's parameters.
    """

    def __init__(self, node: Node, kinematics: Kinematics, settings: Settings) -> None:
        self._node = node
        self._kinematics = kinematics
        self._settings = settings
        self._min_interval = int(1e9 / max(settings.publish_frequency, 1.0))
        self._max_joints = len(kinematics.moving) + len(kinematics.fixed) + _MAX_UNKNOWN_NAMES
        self._published_stamps: dict[str, int] = {}  # joint -> stamp in nanoseconds of the last message used
        self._last_received_at = 0
        self._joint_sets: dict[tuple[str, ...], _JointSet] = {}
        self._lock = threading.Lock()
        tf_type = topic_type(TFMessage)
        self._tf_publisher = node.advertise("/tf", AnyMsg, queue_size=_QUEUE_SIZE, raw_type=tf_type)
        static_publisher = node.advertise("/tf_static", AnyMsg, queue_size=_QUEUE_SIZE, latch=True, raw_type=tf_type)
        if kinematics.fixed:
            poses = [pose for _, pose in kinematics.fixed]
            self._fixed_batch = self._make_batch(
                [(joint.parent, joint.child, _constant_pose(pose)) for joint, pose in kinematics.fixed]
            )
            self._zero_positions = [0.0] * len(poses)
            if settings.use_tf_static:
                static_publisher.publish(self._fixed_message(0))
            else:
                node.timer(
                    self._min_interval / 1e9,
                    lambda event: self._tf_publisher.publish(self._fixed_message(_LEAD_TIME_NS)),
                )
        node.subscribe("joint_states", JointState, self._receive, queue_size=_QUEUE_SIZE)

    def _fixed_message(self, lead_time: int) -> AnyMsg:
        return AnyMsg(
            self._fixed_batch.encode(*divmod(self._node.now().to_nsec() + lead_time, 10**9), self._zero_positions)
        )

    def _receive(self, message: Any) -> None:
        with self._lock:
            self._publish_moving_links(message)

    def _publish_moving_links(self, message: Any) -> None:
        names, positions, stamp = message.name, message.position, message.header.stamp
        if len(names) != len(positions) or len(names) > self._max_joints:
            self._report_invalid(names, positions)
            return
        now, stamp_ns = self._node.now().to_nsec(), stamp.to_nsec()
        if now < self._last_received_at:
            self._node.log.warn("Moved backwards in time, re-publishing joint transforms!")
            self._published_stamps.clear()
        self._last_received_at = now
        if now - stamp_ns > _OLD_MESSAGE_AGE * 1e9:
            self._node.log.warn("Received JointState is %f seconds old.", (now - stamp_ns) / 1e9, throttle=30)
        published_stamps = self._published_stamps
        last_stamp = min(map(published_stamps.get, names, [0] * len(names)), default=0)
        if not names or (stamp_ns < last_stamp + self._min_interval and not self._settings.ignore_timestamp):
            return
        joint_names = tuple(names)
        joint_set = self._joint_sets.get(joint_names) or self._new_joint_set(joint_names)
        if joint_set.unknown:
            text = 'Joint state with name: "%s" was received but not found in URDF'
            self._node.log.warn(text, one_line(joint_set.unknown, 200), throttle=10)
        positions_by_name = dict(zip(names, positions, strict=True))
        self._kinematics.add_mimic_joints(positions_by_name)
        joint_positions = [positions_by_name[name] for name in joint_set.joints]
        if not isfinite(sum(joint_positions)) and not all(map(isfinite, joint_positions)):
            self._node.log.warn("joint states with positions that are NaN or infinite are ignored", throttle=10)
            return
        if joint_positions:
            self._tf_publisher.publish(AnyMsg(joint_set.batch.encode(stamp.secs, stamp.nsecs, joint_positions)))
        published_stamps.update(dict.fromkeys(names, stamp_ns))
        if len(published_stamps) > 2 * self._max_joints:  # some node keeps sending new names
            self._published_stamps = {}

    def _report_invalid(self, names: Sequence[str], positions: Sequence[float]) -> None:
        if positions:
            self._node.log.error("Robot state publisher ignored an invalid JointState message", throttle=1)
            return
        text = (
            'Robot state publisher ignored a JointState message about joint(s) "%s"(,...) whose position member was '
            "empty. This message will not reappear for 300 seconds."
        )
        self._node.log.warn(text, one_line(names[0], 200), throttle=300)

    def _new_joint_set(self, names: tuple[str, ...]) -> _JointSet:
        positions = dict.fromkeys(names, 0.0)
        self._kinematics.add_mimic_joints(positions)
        moving = self._kinematics.moving
        joints = tuple(name for name in positions if name in moving)
        edges = [(moving[name].joint.parent, moving[name].joint.child, moving[name].pose_at) for name in joints]
        fixed = {joint.name for joint, _ in self._kinematics.fixed}
        unknown = next((name for name in names if name not in moving and name not in fixed), "")
        if len(self._joint_sets) >= _MAX_JOINT_SETS:
            del self._joint_sets[next(iter(self._joint_sets))]
        joint_set = self._joint_sets[names] = _JointSet(self._make_batch(edges), joints, unknown)
        return joint_set

    def _make_batch(self, edges: Sequence[tuple[str, str, Callable[[float], Transform]]]) -> TransformBatch:
        prefix = self._settings.prefix
        return TransformBatch(
            (frame_name(prefix, parent), frame_name(prefix, child), pose_at) for parent, child, pose_at in edges
        )


def frame_name(prefix: str, link: str) -> str:
    """Return the name of a link's frame.

    Args:
        prefix: the parameter tf_prefix.
        link: the link's name; if it begins with a slash, it gets no prefix.
    """
    prefix = prefix.strip("/")
    return f"{prefix}/{link}" if prefix and not link.startswith("/") else link.removeprefix("/")


def read_settings(node: Node) -> Settings:
    """Read the node's parameters.

    Raises:
        UrdfError: a value has the wrong type.
    """
    params = node.params
    prefix = params.search("tf_prefix")
    return Settings(
        publish_frequency=check_number(params.get("~publish_frequency", 50.0), "publish_frequency"),
        ignore_timestamp=bool(params.get("~ignore_timestamp", False)),
        use_tf_static=bool(params.get("~use_tf_static", True)),
        prefix=str(params[prefix]) if prefix else "",
    )


def _constant_pose(pose: Transform) -> Callable[[float], Transform]:
    return lambda position: pose


def main(argv: list[str]) -> int:
    """Run robot_state_publisher; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("robot_state_publisher", argv=argv[1:]) as node:
        try:
            robot = read_robot(robot_description(node))
            for warning in robot.warnings:
                node.log.warn("%s", warning)
            for joint in robot.joints.values():
                if joint.type in ("floating", "planar"):
                    node.log.warn(
                        "joint %s is %s, which joint states cannot describe: %s",
                        joint.name,
                        joint.type,
                        _UNSUPPORTED_HINTS[joint.type],
                    )
            RobotStatePublisher(node, Kinematics(robot), read_settings(node))
        except Error as error:
            node.log.fatal("%s", error)
            return 1
        node.spin()
    return 0


def deprecated_main(argv: list[str]) -> int:
    """Run robot_state_publisher under its old, deprecated name, state_publisher."""
    sys.stderr.write("WARNING: the program state_publisher is deprecated: use robot_state_publisher instead\n")
    return main(argv)


_UNSUPPORTED_HINTS = {
    "floating": "another node must publish the pose of its link",
    "planar": "its link stays at the origin",
}

if __name__ == "__main__":
    sys.exit(main(sys.argv))
