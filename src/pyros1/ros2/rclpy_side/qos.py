"""Converts QoS profiles to and from rclpy's. Does not import rclpy: its module is passed."""

from __future__ import annotations

from typing import Any

from pyros1.ros2.zenoh.qos import Qos

UNKNOWN_DEPTH = 100
"""The depth assumed for a publisher, since DDS does not announce it. With less, a bridge could miss messages when a
latched publisher sends many to a new subscriber at once.
"""
# rmw's numbers; "system default", "unknown" and "best available" are read as the usual values.
_BEST_EFFORT = 2
_TRANSIENT_LOCAL = 1
_KEEP_ALL = 2


def to_rclpy(qos: Qos, module: Any) -> Any:
    """Return a profile as rclpy's.

    Args:
        qos: the profile.
        module: ``rclpy.qos``.
    """
    history, durability, reliability = module.HistoryPolicy, module.DurabilityPolicy, module.ReliabilityPolicy
    return module.QoSProfile(
        depth=qos.depth,
        history=history.KEEP_ALL if qos.keep_all else history.KEEP_LAST,
        durability=durability.TRANSIENT_LOCAL if qos.transient_local else durability.VOLATILE,
        reliability=reliability.RELIABLE if qos.reliable else reliability.BEST_EFFORT,
    )


def from_rclpy(profile: Any) -> Qos:
    """Return the profile of another node's publisher or subscriber, given rclpy's."""
    return Qos(
        reliable=int(profile.reliability) != _BEST_EFFORT,
        transient_local=int(profile.durability) == _TRANSIENT_LOCAL,
        depth=int(profile.depth) or UNKNOWN_DEPTH,
        keep_all=int(profile.history) == _KEEP_ALL,
    )
