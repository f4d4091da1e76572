"""Converts the levels of log messages, whose values differ between ROS 1 and ROS 2. No I/O."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class ValueRule(NamedTuple):
    """Converts the values of a ``uint8`` or ``byte``.

    Attributes:
        to_ros2: the value in ROS 2 for each of the 256 values in ROS 1.
        to_ros1: the value in ROS 1 for each of the 256 values in ROS 2.
    """

    to_ros2: Sequence[int]
    to_ros1: Sequence[int]


# DEBUG, INFO, WARN, ERROR, FATAL in rosgraph_msgs/Log and in rcl_interfaces/msg/Log
_ROS1_LEVELS = (1, 2, 4, 8, 16)
_ROS2_LEVELS = (10, 20, 30, 40, 50)


def _level(value: int, levels: Sequence[int], others: Sequence[int]) -> int:
    """Return the other side's level for a value, which may lie between named levels."""
    return next((other for level, other in zip(levels[::-1], others[::-1], strict=True) if value >= level), others[0])


LOG_LEVELS = ValueRule(
    bytes(_level(value, _ROS1_LEVELS, _ROS2_LEVELS) for value in range(256)),
    bytes(_level(value, _ROS2_LEVELS, _ROS1_LEVELS) for value in range(256)),
)
"""The conversion of the levels of log messages."""
