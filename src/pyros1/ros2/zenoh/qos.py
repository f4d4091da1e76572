"""The quality of service (QoS) of publishers, subscribers and services, as written in rmw_zenoh's tokens. No I/O."""

from __future__ import annotations

from typing import NamedTuple

from pyros1.ground.errors import SerializationError
from pyros1.ros2.zenoh.names import read_number

UNWRITTEN_DEPTH = 42
"""The depth that rmw_zenoh means if it writes none, or 0."""
_MAX_DEPTH = (1 << 64) - 1
_LENGTHS = (1, 1, 2, 2, 2, 3)  # how many numbers each field has
_BEST_EFFORT = 2
_TRANSIENT_LOCAL = 1
_KEEP_ALL = 2


class Qos(NamedTuple):
    """The parts of a QoS profile that matter for forwarding messages.

    Attributes:
        reliable: whether lost messages are sent again; otherwise *best effort*.
        transient_local: whether late subscribers get the last messages, as from a latched publisher in ROS 1;
            otherwise *volatile*.
        depth: number of messages that are kept.
        keep_all: whether all messages are kept, whatever the depth is.
    """

    reliable: bool = True
    transient_local: bool = False
    depth: int = 10
    keep_all: bool = False


def encode_qos(qos: Qos) -> str:
    """Return a QoS profile as the last part of a token.

    All fields of `Qos` are written, since the meaning of an empty field depends on the reader's version.

    Raises:
        SerializationError: the depth is out of range.
    """
    if not 0 <= qos.depth <= _MAX_DEPTH:
        raise SerializationError(f"a QoS profile cannot have a depth of {qos.depth}")
    reliability = 1 if qos.reliable else _BEST_EFFORT
    durability = _TRANSIENT_LOCAL if qos.transient_local else 2
    history = _KEEP_ALL if qos.keep_all else 1
    return f"{reliability}:{durability}:{history},{qos.depth}:,:,:,,"


def decode_qos(text: str) -> Qos | None:
    """Parse another program's QoS profile; None if it is not valid.

    Empty fields mean the same as in rmw_zenoh: reliable, volatile, keep last, UNWRITTEN_DEPTH. In its old versions, an
    empty durability meant *transient local*, but the text does not tell which version wrote it. Unknown numbers, such
    as those for *system default*, are read like empty fields.
    """
    fields = [field.split(",", 3) for field in text.split(":", len(_LENGTHS))[: len(_LENGTHS)]]
    if len(fields) < len(_LENGTHS) or any(len(field) < length for field, length in zip(fields, _LENGTHS, strict=True)):
        return None
    texts = [fields[0][0], fields[1][0], fields[2][0], fields[2][1]]
    reliability, durability, history, depth = (read_number(text or "0", _MAX_DEPTH) for text in texts)
    if reliability is None or durability is None or history is None or depth is None:
        return None
    return Qos(
        reliability != _BEST_EFFORT, durability == _TRANSIENT_LOCAL, depth or UNWRITTEN_DEPTH, history == _KEEP_ALL
    )
