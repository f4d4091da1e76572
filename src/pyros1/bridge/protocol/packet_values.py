"""The values in packets from other sites, each checked before it is used. No I/O.

All `read_` functions and `load` raise PacketError if a value is invalid.
"""

from __future__ import annotations

import json
import re
from typing import Any

from pyros1.bridge.names import SharedName, SiteNameError, is_topic_name, parse_shared_name
from pyros1.ground.errors import Error

MAX_BODY = 1 << 20
"""Maximum size in bytes of a packet that is not a message."""
MAX_NUMBER = 1 << 63
"""The exclusive upper limit of all numbers in packets."""
_MAX_SECONDS = 1e10
"""The exclusive upper limit of times and durations; clocks that begin in 1970 are far below it."""
_LEAST_RATE = 1 / 86_400
_MAX_RATE = 1e6
_MAX_TYPE_LENGTH = 255
_MD5 = re.compile(r"[0-9a-f]{32}\Z")
_TYPE = re.compile(r"[A-Za-z]\w*/[A-Za-z]\w*\Z", re.ASCII)


class PacketError(Error, ValueError):
    """A packet from another site is not valid."""


def dump(value: Any) -> bytes:
    """Return a value as JSON."""
    return json.dumps(value, separators=(",", ":")).encode()


def load(body: bytes, length: int | None) -> list[Any]:
    """Return the list in a packet's body.

    Args:
        body: the body.
        length: the required length of the list; None for any.
    """
    if len(body) > MAX_BODY:
        raise PacketError("a packet that is too large")
    try:
        value = json.loads(body)
    except (ValueError, RecursionError):
        raise PacketError("a packet that is not JSON") from None
    if not isinstance(value, list) or length not in (None, len(value)):
        raise PacketError("a packet with the wrong structure")
    return value


def read_rows(value: Any, width: int, maximum: int) -> list[list[Any]]:
    """Return a list of lists, at most `maximum`, each of `width` values."""
    if not isinstance(value, list) or len(value) > maximum:
        raise PacketError("not a list, or too long")
    if not all(isinstance(row, list) and len(row) == width for row in value):
        raise PacketError("a list with the wrong structure")
    return value


def read_integer(value: Any, minimum: int = 0) -> int:
    """Return a whole number that is not less than `minimum`."""
    if type(value) is not int or not minimum <= value < MAX_NUMBER:
        raise PacketError("not a number in range")
    return value


def read_time(value: Any) -> float:
    """Return a time of another site's clock, or a duration, in seconds; it may be negative, but not huge."""
    if type(value) not in (int, float) or not abs(value) < _MAX_SECONDS:
        raise PacketError("not a time in range")
    return float(value)


def read_rate(value: Any) -> float:
    """Return a number of messages per second, at least one per day; 0 for no limit."""
    if type(value) not in (int, float) or not 0 <= value <= _MAX_RATE:
        raise PacketError("not a rate in range")
    return max(_LEAST_RATE, float(value)) if value else 0.0


def read_topic(value: Any) -> SharedName:
    """Return a topic's name between sites."""
    try:
        return parse_shared_name(value if isinstance(value, str) and len(value) <= 400 else "")
    except SiteNameError:
        raise PacketError("not a topic's name") from None


def read_nodes(value: Any, maximum: int) -> tuple[str, ...]:
    """Return the full names of nodes, at most `maximum`."""
    if not isinstance(value, list) or len(value) > maximum:
        raise PacketError("not a list, or too long")
    if not all(isinstance(name, str) and is_topic_name(name) for name in value):
        raise PacketError("not the name of a node")
    return tuple(value)


def read_type(value: Any) -> str:
    """Return the name of a message type."""
    if not (isinstance(value, str) and len(value) <= _MAX_TYPE_LENGTH and _TYPE.match(value)):
        raise PacketError("not a message type")
    return value


def read_md5(value: Any) -> str:
    """Return an md5 sum."""
    if not (isinstance(value, str) and _MD5.match(value)):
        raise PacketError("not an md5 sum")
    return value


def read_bools(values: list[Any]) -> list[bool]:
    """Return values that are true or false."""
    if not all(isinstance(value, bool) for value in values):
        raise PacketError("not true or false")
    return values
