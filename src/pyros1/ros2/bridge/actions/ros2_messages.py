"""Reads and writes, as CDR, the messages that are the same for all ROS 2 actions. No I/O."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from enum import IntEnum
from typing import Any, NamedTuple

from pyros1.ground.errors import MessageError
from pyros1.ros2.bridge.actions.ros1_messages import NO_STAMP, Stamp

UUID_SIZE = 16
NO_UUID = bytes(UUID_SIZE)
"""The UUID that stands for any goal in a cancel request."""
MAX_STATUSES = 1000
_HEAD = b"\0\1\0\0"
_ORDERS = {b"\0\0": ">", b"\0\1": "<"}
_MAX_SECONDS = 0x7FFF_FFFF
_MAX_NANOSECONDS = 999_999_999


class Ros2Status(IntEnum):
    """The values of action_msgs/msg/GoalStatus."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    @property
    def ended(self) -> bool:
        """Whether this status is final."""
        return self >= Ros2Status.SUCCEEDED


class CancelCode(IntEnum):
    """A server's response to a cancel request: the values of action_msgs/srv/CancelGoal."""

    NONE = 0
    REJECTED = 1
    UNKNOWN_GOAL = 2
    ENDED = 3


class GoalInfo(NamedTuple):
    """A goal: its UUID, and when it was accepted."""

    uuid: bytes
    stamp: Stamp = NO_STAMP


class ReportedGoal(NamedTuple):
    """A goal in an array of statuses."""

    info: GoalInfo
    status: int


class _Reader:
    def __init__(self, data: bytes) -> None:
        order = _ORDERS.get(data[:2])
        if order is None:
            raise MessageError("a message of a ROS 2 action is not CDR")
        self._order = order
        self._data = data
        self._at = len(_HEAD)

    def unpack(self, form: str, align: int = 1) -> Any:
        self._at += -self._at % align
        packed = struct.Struct(self._order + form)
        try:
            values = packed.unpack_from(self._data, self._at)
        except struct.error:
            raise MessageError("a message of a ROS 2 action ends too early") from None
        self._at += packed.size
        return values

    def info(self) -> GoalInfo:
        (uuid,) = self.unpack("16s")
        seconds, nanoseconds = self.unpack("iI", 4)
        return GoalInfo(uuid, (max(0, seconds), min(nanoseconds, _MAX_NANOSECONDS)))


def decode_uuid(data: bytes) -> bytes:
    """Return the UUID in a request for a result; all functions raise MessageError if the message is invalid."""
    (uuid,) = _Reader(data).unpack("16s")
    return bytes(uuid)


def decode_cancel(data: bytes) -> GoalInfo:
    """Return the goal and stamp in a cancel request."""
    return _Reader(data).info()


def decode_goal_response(data: bytes) -> tuple[bool, Stamp]:
    """Return whether a goal was accepted, and when."""
    reader = _Reader(data)
    (accepted,) = reader.unpack("B")
    seconds, nanoseconds = reader.unpack("iI", 4)
    return accepted != 0, (max(0, seconds), min(nanoseconds, _MAX_NANOSECONDS))


def decode_cancel_response(data: bytes) -> tuple[int, list[GoalInfo]]:
    """Return the code (a `CancelCode`, or any other number that a server sends) and the goals being cancelled."""
    reader = _Reader(data)
    (code,) = reader.unpack("b")
    return code, [reader.info() for _ in range(_length(reader))]


def decode_statuses(data: bytes) -> list[ReportedGoal]:
    """Return the statuses in an array."""
    reader = _Reader(data)
    return [ReportedGoal(reader.info(), reader.unpack("b")[0]) for _ in range(_length(reader))]


def _length(reader: _Reader) -> int:
    (length,) = reader.unpack("I", 4)
    if length > MAX_STATUSES:
        raise MessageError(f"a ROS 2 action server reports more than {MAX_STATUSES} goals")
    return int(length)


def encode_uuid(uuid: bytes) -> bytes:
    """Return a request for a result."""
    return _HEAD + uuid


def encode_cancel(info: GoalInfo) -> bytes:
    """Return a cancel request."""
    return _HEAD + _info(info)


def encode_goal_response(accepted: bool, stamp: Stamp) -> bytes:
    """Return the response to a goal."""
    return _HEAD + struct.pack("<?3x", accepted) + _stamp(stamp)


def encode_cancel_response(code: int, goals: Sequence[GoalInfo]) -> bytes:
    """Return the response to a cancel request."""
    return _HEAD + struct.pack("<b3xI", code, len(goals)) + b"".join(map(_info, goals))


def encode_statuses(goals: Iterable[ReportedGoal]) -> bytes:
    """Return an array of statuses."""
    goals = [*goals]
    data = bytearray(_HEAD + struct.pack("<I", len(goals)))
    for goal in goals:
        data += goal.info.uuid
        data += bytes(-len(data) % 4) + _stamp(goal.info.stamp) + struct.pack("<b", goal.status)
    return bytes(data)


def _info(info: GoalInfo) -> bytes:
    return info.uuid + _stamp(info.stamp)


def _stamp(stamp: Stamp) -> bytes:
    return struct.pack("<iI", min(stamp[0], _MAX_SECONDS), stamp[1])
