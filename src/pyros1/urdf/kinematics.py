"""Computes the poses of a robot's links from the positions of its joints. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, sin
from typing import NamedTuple

from pyros1.ground.terminal_text import one_line
from pyros1.tf.rotation import IDENTITY, Transform, chain_normalized
from pyros1.urdf.model import MOVING, Joint, Robot, UrdfError

FIXED = frozenset({"fixed", "planar"})
"""Types of joints that are published once, as in stock; for planar joints, only the origin is known."""


class Edge(NamedTuple):
    """A link and its parent.

    Attributes:
        joint: the joint between them.
        pose_at: returns the child's pose in the parent for a position of the joint, in radians or metres.
    """

    joint: Joint
    pose_at: Callable[[float], Transform]


class Kinematics:
    """The tree of a robot's links.

    Args:
        robot: the robot.

    Attributes:
        root: name of the link at the top of the tree.
        fixed: joint and pose of each link that does not move.
        moving: the links that move, by the names of their joints.

    Raises:
        UrdfError: the links do not form a tree.
    """

    def __init__(self, robot: Robot) -> None:
        self.root = _root(robot)
        joints = robot.joints.values()
        self.fixed = [(joint, chain_normalized(joint.origin, IDENTITY)) for joint in joints if joint.type in FIXED]
        self.moving = {joint.name: Edge(joint, pose_function(joint)) for joint in joints if joint.type in MOVING}
        self._followers = _ordered_followers(robot)

    def complete(self, positions: dict[str, float]) -> None:
        """Add the positions of joints that mimic other joints. Existing positions are not changed.

        Args:
            positions: joint -> radians or metres.
        """
        for name, leader, multiplier, offset in self._followers:
            position = positions.get(leader)
            if position is not None and name not in positions:
                positions[name] = position * multiplier + offset

    def transforms(self, positions: Mapping[str, float]) -> dict[str, tuple[str, Transform]]:
        """Return the poses of links: child -> (parent, transform).

        Args:
            positions: joint -> radians or metres. Links of joints that are not included, and do not follow an included
                joint, are left out unless they are fixed.
        """
        all_positions = dict(positions)
        self.complete(all_positions)
        poses = {joint.child: (joint.parent, pose) for joint, pose in self.fixed}
        for name, (joint, pose_at) in self.moving.items():
            if name in all_positions:
                poses[joint.child] = (joint.parent, pose_at(all_positions[name]))
        return poses


def pose_function(joint: Joint) -> Callable[[float], Transform]:
    """Return a function that returns the child's pose in the parent for a position of the joint.

    Args:
        joint: a joint of a type in `MOVING`.
    """
    x, y, z, qx, qy, qz, qw = chain_normalized(joint.origin, IDENTITY)
    ax, ay, az = joint.axis
    if joint.type == "prismatic":
        dx, dy, dz, *_ = chain_normalized((0.0, 0.0, 0.0, qx, qy, qz, qw), (ax, ay, az, 0.0, 0.0, 0.0, 1.0))
        return lambda position: (x + dx * position, y + dy * position, z + dz * position, qx, qy, qz, qw)
    if not (ax or ay or az):
        return lambda position: (x, y, z, qx, qy, qz, qw)
    # The product of the origin's rotation and the axis, as quaternions: the coefficient of the sine.
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


def _root(robot: Robot) -> str:
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
        each = link
        while each not in reached:
            if each in path:
                raise UrdfError(f"the joints form a cycle: {', '.join(one_line(name, 100) for name in list(path)[:5])}")
            path[each] = None
            each = parents[each]
        reached.update(path)
    return roots[0]


def _ordered_followers(robot: Robot) -> list[tuple[str, str, float, float]]:
    """Return (joint, leader, multiplier, offset) of the joints that mimic other joints, leaders first."""
    ordered: dict[str, tuple[str, str, float, float]] = {}
    for joint in robot.joints.values():
        path = []
        each: Joint | None = joint
        while each is not None and each.mimic is not None and each.name not in ordered:
            path.append(each)
            each = robot.joints.get(each.mimic.joint)
        for follower in reversed(path):
            if follower.mimic is not None:
                mimic = follower.mimic
                ordered[follower.name] = (follower.name, mimic.joint, mimic.multiplier, mimic.offset)
    return list(ordered.values())
