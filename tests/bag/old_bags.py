"""Bags of version 1.2, made as the recorders of 2009 and 2010 made them.

What is here was read off http://wiki.ros.org/Bags/Format/1.2 and the recorders of that time, not off our reader: header
fields are sorted by name; a topic's definition stands before its first message, and the topic's index names the place
of the definition; bags without an index have no file header either.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterable
from dataclasses import dataclass

FIRST_LINE = b"#ROSRECORD V1.2\n"

STRING = ("std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data\n")
INT32 = ("std_msgs/Int32", "da5909fbe378aeaf85e547e830cc1bb7", "int32 data\n")


@dataclass(frozen=True)
class Old:
    """A message.

    Attributes:
        topic: its topic.
        kind: name, md5 sum and definition of its type.
        time: when it was recorded, in nanoseconds.
        data: its bytes.
        callerid: the publisher, which recorders wrote down of latched messages only.
    """

    topic: str
    kind: tuple[str, str, str]
    time: int
    data: bytes
    callerid: str = ""


def text(topic: str, time: int, value: str, callerid: str = "") -> Old:
    """Return a String."""
    return Old(topic, STRING, time, struct.pack("<I", len(value)) + value.encode(), callerid)


def number(topic: str, time: int, value: int, callerid: str = "") -> Old:
    """Return an Int32."""
    return Old(topic, INT32, time, struct.pack("<i", value), callerid)


def old_bag(
    messages: Iterable[Old],
    *,
    indexed: bool = True,
    closed: bool = True,
    first_line: bytes = FIRST_LINE,
    undefined: Collection[str] = (),
) -> bytes:
    """Return a bag's bytes.

    Args:
        indexed: with a file header, and an index at its end.
        closed: False if the recorder was killed before it wrote the index.
        undefined: topics whose definitions are left out.
    """
    begin = len(first_line) + (8 + 4096 if indexed else 0)
    body = bytearray()
    index: dict[str, list[tuple[int, int]]] = {}
    kinds: dict[str, str] = {}
    for message in messages:
        name, md5, definition = message.kind
        position = begin + len(body)
        names = {"topic": message.topic.encode(), "type": name.encode(), "md5": md5.encode()}
        if message.topic not in index and message.topic not in undefined:
            body += _record({"op": b"\1", "def": definition.encode(), **names})
        kinds[message.topic] = name
        index.setdefault(message.topic, []).append((message.time, position))
        secs, nsecs = divmod(message.time, 1_000_000_000)
        latched = {"latching": b"1", "callerid": message.callerid.encode()} if message.callerid else {}
        stamp = {"sec": struct.pack("<I", secs), "nsec": struct.pack("<I", nsecs)}
        body += _record({"op": b"\2", **names, **stamp, **latched}, message.data)
    if not indexed:
        return first_line + bytes(body)
    tail = b""
    for topic, entries in sorted(index.items()):
        data = b"".join(struct.pack("<IIQ", *divmod(time, 1_000_000_000), position) for time, position in entries)
        counts = {"ver": bytes(4), "count": struct.pack("<I", len(entries))}
        tail += _record({"op": b"\4", "topic": topic.encode(), "type": kinds[topic].encode(), **counts}, data)
    position = begin + len(body) if closed else 0
    fields = _header({"op": b"\3", "index_pos": struct.pack("<Q", position)})
    padding = 4096 - len(fields)
    head = struct.pack("<I", len(fields)) + fields + struct.pack("<I", padding) + b" " * padding
    return first_line + head + bytes(body) + (tail if closed else b"")


def _header(fields: dict[str, bytes]) -> bytes:
    parts = (name.encode() + b"=" + value for name, value in sorted(fields.items()))
    return b"".join(struct.pack("<I", len(part)) + part for part in parts)


def _record(fields: dict[str, bytes], data: bytes = b"") -> bytes:
    header = _header(fields)
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data
