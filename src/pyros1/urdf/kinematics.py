"""Computes the poses of a robot's links from the positions of its joints (no I/O)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, sin
from typing import NamedTuple

from pyros1.ground.terminal_text import one_line
from pyros1.tf.rotation import IDENTITY, Transform, multiply_normalized
from pyros1.urdf.model import MOVING_TYPES, Joint, Robot, UrdfError

FIXED_TYPES = frozenset({"fixed", "planar"})
"""Types of joints whose child is published with a fixed pose, as in stock ROS. Of a planar joint, only the origin is
known.
"""


class Edge(NamedTuple):
    """The connection between a moving link and its parent.

    Attributes:
        joint: the joint between the two links.
        pose_at: takes the joint's position in radians or metres; returns the child's pose in the parent.
    """

    joint: Joint
    pose_at: Callable[[float], Transform]


class Kinematics:
    """The tree of a robot's links.

    Args:
        robot: the robot's description.

    Attributes:
        root: name of the link at the top of the tree.
        fixed: the joint and the pose of each link that does not move.
        moving: name of a joint that moves -> the connection between its links.

    Raises:
        UrdfError: the links do not form a tree.
    """

    def __init__(self, robot: Robot) -> None:
        self.root = _find_root(robot)
        joints = robot.joints.values()
        self.fixed = [
            (joint, multiply_normalized(joint.origin, IDENTITY)) for joint in joints if joint.type in FIXED_TYPES
        ]
        self.moving = {
            joint.name: Edge(joint, make_pose_function(joint)) for joint in joints if joint.type in MOVING_TYPES
        }
        self._ordered_mimic_joints = _order_mimic_joints(robot)

    def add_mimic_joints(self, positions: dict[str, float]) -> None:
        """Add the positions of joints that mimic other joints to ``positions``, unless they are already there.

        Args:
            positions: joint -> position in radians or metres.
        """
        for name, leader, multiplier, offset in self._ordered_mimic_joints:
            position = positions.get(leader)
            if position is not None and name not in positions:
                positions[name] = position * multiplier + offset

    def transforms(self, positions: Mapping[str, float]) -> dict[str, tuple[str, Transform]]:
        """Return the poses of links in their parents: child -> (parent, transform).

        Args:
            positions: joint -> position in radians or metres. Links are omitted from the result if their joint's
                position is neither given nor determined by another joint's.
        """
        all_positions = dict(positions)
        self.add_mimic_joints(all_positions)
        poses = {joint.child: (joint.parent, pose) for joint, pose in self.fixed}
        for name, (joint, pose_at) in self.moving.items():
            if name in all_positions:
                poses[joint.child] = (joint.parent, pose_at(all_positions[name]))
        return poses


def make_pose_function(joint: Joint) -> Callable[[float], Transform]:
    """Return a function that takes a joint's position, and returns the child's pose in the parent.

    Args:
        joint: a joint whose type is in `MOVING_TYPES`.
    """
    x, y, z, qx, qy, qz, qw = multiply_normalized(joint.origin, IDENTITY)
    ax, ay, az = joint.axis
    if joint.type == "prismatic":
        dx, dy, dz, *_ = multiply_normalized((0.0, 0.0, 0.0, qx, qy, qz, qw), (ax, ay, az, 0.0, 0.0, 0.0, 1.0))
        return lambda position: (x + dx * position, y + dy * position, z + dz * position, qx, qy, qz, qw)
    if not (ax or ay or az):
        return lambda position: (x, y, z, qx, qy, qz, qw)
    # The pose's quaternion is q cos(position / 2) + s sin(position / 2): q is the origin's, s is q times the axis.
    sx = qw * ax + qy * az - qz * ay
    sy = qw * ay + qz * ax - qx * az
    sz = qw * az + qx * ay - qy * ax
    sw = -qx * ax - qy * ay - qz * az

    def pose_at(position: float) -> Transform:
        half = position * 0.5
        s, c = sin(half), cos(half)
        i, j, k, w = sx * s + qx * c, sy * s + qy * c, sz * s + qz * c, sw * s + qw * c
        if w < 0.5 and (max(i, j, k, key=abs) if w > -0.5 else w) < 0.0:
            return (x, y, z, -i, -j, -k, -w)  # the same rotation, with the sign that conversion from a matrix gives
        return (x, y, z, i, j, k, w)

    return pose_at


def _find_root(robot: Robot) -> str:
    parents = {joint.child: joint.parent for joint in robot.joints.values()}
    roots = [link for link in robot.links if link not in parents]
    if len(roots) > 1:
        raise UrdfError(
            f"the robot has {len(roots)} links without a parent: {', '.join(one_line(name, 100) for name in roots[:5])}"
            f"{' ...' if len(roots) > 5 else ''}. Join them with joints, for example fixed ones"
        )
    if not roots:
        raise UrdfError("no link is the root: the joints form a cycle")
    reached = {roots[0]}
    for link in robot.links:
        path: dict[str, None] = {}
        ancestor = link
        while ancestor not in reached:
            if ancestor in path:
                raise UrdfError(f"the joints form a cycle: {', '.join(one_line(name, 100) for name in list(path)[:5])}")
            path[ancestor] = None
            ancestor = parents[ancestor]
        reached.update(path)
    return roots[0]


def _order_mimic_joints(robot: Robot) -> list[tuple[str, str, float, float]]:
    """Return (joint, leader, multiplier, offset) of each joint that mimics another joint, leaders before followers."""
    ordered: dict[str, tuple[str, str, float, float]] = {}
    for joint in robot.joints.values():
        path = []
        current: Joint | None = joint
        while current is not None and current.mimic is not None and current.name not in ordered:
            path.append(current)
            current = robot.joints.get(current.mimic.joint)
        for follower in reversed(path):
            if follower.mimic is not None:
                mimic = follower.mimic
                ordered[follower.name] = (follower.name, mimic.joint, mimic.multiplier, mimic.offset)
    return list(ordered.values())
