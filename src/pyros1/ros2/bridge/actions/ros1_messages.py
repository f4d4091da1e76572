"""Reads and writes the parts of ROS 1's action messages that are the same for all actions. The goals, results and
feedback in them stay encoded. No I/O.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import NamedTuple

from pyros1.ground.errors import MessageError

MAX_STATUSES = 1000
"""Maximum number of goals in an array of statuses."""
MAX_NAME = 1000
"""Maximum number of bytes in the name of a goal."""
_MAX_TEXT = 10_000
_HEADER = struct.Struct("<III")
_TIME = struct.Struct("<II")
_LENGTH = struct.Struct("<I")
Stamp = tuple[int, int]
"""A time: seconds and nanoseconds."""
NO_STAMP: Stamp = (0, 0)


class GoalStatus(NamedTuple):
    """An actionlib_msgs/GoalStatus.

    Attributes:
        name: the goal's id.
        stamp: when it was sent.
        status: its status, see `pyros1.actions.states.Status`.
        text: the server's explanation.
    """

    name: str
    stamp: Stamp
    status: int
    text: str = ""


class _Reader:
    def __init__(self, body: bytes) -> None:
        self._body = body
        self._at = 0

    def unpack(self, form: struct.Struct) -> tuple[int, ...]:
        try:
            values = form.unpack_from(self._body, self._at)
        except struct.error:
            raise MessageError("a message of an action ends too early") from None
        self._at += form.size
        return values

    def text(self, maximum: int) -> str:
        (length,) = self.unpack(_LENGTH)
        end = self._at + length
        if end > len(self._body):
            raise MessageError("a message of an action ends too early")
        part = self._body[self._at : min(end, self._at + maximum)]
        self._at = end
        return part.decode("utf-8", "surrogateescape")

    def header(self) -> None:
        self.unpack(_HEADER)
        self.text(0)

    def goal_id(self) -> tuple[str, Stamp]:
        secs, nsecs = self.unpack(_TIME)
        name = self.text(MAX_NAME + 1)
        if len(name.encode("utf-8", "surrogateescape")) > MAX_NAME:
            raise MessageError(f"the id of a goal has more than {MAX_NAME} bytes")
        return name, (secs, nsecs)

    def status(self) -> GoalStatus:
        name, stamp = self.goal_id()
        (status,) = self.unpack(struct.Struct("<B"))
        return GoalStatus(name, stamp, status, self.text(_MAX_TEXT))

    def rest(self) -> bytes:
        return self._body[self._at :]


def decode_goal(body: bytes) -> tuple[str, Stamp, bytes]:
    """Return a goal's id and stamp, and the encoded goal; all functions raise MessageError for invalid messages."""
    reader = _Reader(body)
    reader.header()
    return *reader.goal_id(), reader.rest()


def decode_cancel(body: bytes) -> tuple[str, Stamp]:
    """Return the id and stamp in a cancel request."""
    return _Reader(body).goal_id()


def decode_result(body: bytes) -> tuple[GoalStatus, bytes]:
    """Return the status and the encoded result (or feedback) in a result (or feedback) message."""
    reader = _Reader(body)
    reader.header()
    return reader.status(), reader.rest()


def decode_statuses(body: bytes) -> list[GoalStatus]:
    """Return the statuses in an array."""
    reader = _Reader(body)
    reader.header()
    (length,) = reader.unpack(_LENGTH)
    if length > MAX_STATUSES:
        raise MessageError(f"an action server reports more than {MAX_STATUSES} goals")
    return [reader.status() for _ in range(length)]


def encode_goal(stamp: Stamp, name: str, goal: bytes) -> bytes:
    """Return the message of a goal, given what `decode_goal` returns."""
    # The goal id's stamp is zero, so the server sets it from its own clock, which may be simulated.
    return _header(stamp) + _TIME.pack(0, 0) + _text(name) + goal


def encode_cancel(name: str, stamp: Stamp) -> bytes:
    """Return a cancel request."""
    return _TIME.pack(*stamp) + _text(name)


def encode_result(now: Stamp, status: GoalStatus, result: bytes) -> bytes:
    """Return the message of a result, or of feedback."""
    return _header(now) + _status(status) + result


def encode_statuses(now: Stamp, statuses: Iterable[GoalStatus]) -> bytes:
    """Return an array of statuses."""
    parts = [*map(_status, statuses)]
    return b"".join((_header(now), _LENGTH.pack(len(parts)), *parts))


def _header(stamp: Stamp) -> bytes:
    return _HEADER.pack(0, *stamp) + _LENGTH.pack(0)


def _text(text: str) -> bytes:
    data = text.encode("utf-8", "surrogateescape")
    return _LENGTH.pack(len(data)) + data


def _status(status: GoalStatus) -> bytes:
    return _TIME.pack(*status.stamp) + _text(status.name) + bytes((status.status,)) + _text(status.text)
