"""Index of the messages in a chunk's content, stored in columns. Does no I/O.

A chunk of a few kilobytes can hold millions of small messages. As columns, their index takes half as much memory as the
content; as objects, it would take many times as much.
"""

from __future__ import annotations

import re
import struct
from array import array
from collections.abc import Callable, Iterator, Mapping
from itertools import compress, islice
from operator import eq, le

from pyros1.bag.format.records import (
    MAX_CONNECTIONS,
    MESSAGE_HEADER_PARTS,
    NS_PER_S,
    OP_CONNECTION,
    OP_MESSAGE,
    U32,
    Connection,
    Fields,
    Message,
    RecordError,
    op_of,
    parse_connection,
    split_record,
    time_of,
    u32_field,
)


class Messages:
    """Positions of n messages: the attributes of `Message` as columns of length n.

    Attributes:
        conns: ids of the connections.
        times: receive times in nanoseconds.
        offsets: offsets of the records in the content.
        starts: offsets of the first byte of the messages in the content.
        ends: offsets after the last byte of the messages in the content.
    """

    __slots__ = ("conns", "ends", "offsets", "starts", "times")

    BYTES_PER_MESSAGE = 24
    """Bytes of memory per message."""

    def __init__(self) -> None:
        self.conns, self.offsets, self.starts, self.ends = array("I"), array("I"), array("I"), array("I")
        self.times = array("Q")

    def add(self, conn: int, time: int, offset: int, start: int, end: int) -> None:
        """Add a message; arguments as for `Message`."""
        self.conns.append(conn)
        self.times.append(time)
        self.offsets.append(offset)
        self.starts.append(start)
        self.ends.append(end)

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, index: int) -> Message:
        return Message(*(column[index] for column in self._columns()))

    def __iter__(self) -> Iterator[Message]:
        return map(Message._make, zip(*self._columns(), strict=True))

    def where(self, is_wanted: Callable[[int, int], bool]) -> Messages:
        """Return the messages for which ``is_wanted(connection id, time)`` is true."""
        mask = bytearray(map(is_wanted, self.conns, self.times))
        return self if all(mask) else self._transform(lambda column: compress(column, mask))

    def sorted_by_time(self, ranks: Mapping[int, int] | None = None) -> Messages:
        """Return the messages in time order; messages with the same time keep their order.

        Args:
            ranks: connection id -> rank; if given, messages with the same time are sorted by rank first.
        """
        times = self.times
        ordered = times if ranks is None else sorted(times)
        if ranks is not None and any(map(eq, ordered, islice(ordered, 1, None))):
            conns = self.conns
            order = array("I", sorted(range(len(times)), key=lambda index: (times[index], ranks[conns[index]])))
        elif all(map(le, times, islice(times, 1, None))):
            return self
        else:
            order = array("I", sorted(range(len(times)), key=times.__getitem__))
        return self._transform(lambda column: map(column.__getitem__, order))

    def iter_range(self, first: int, end: int) -> Iterator[tuple[int, int, int, int]]:
        """Return (connection id, time, start, end) of the messages with indexes from `first` to ``end - 1``."""
        if end == first + 1:
            return iter(((self.conns[first], self.times[first], self.starts[first], self.ends[first]),))
        columns = (self.conns, self.times, self.starts, self.ends)
        return zip(*(column[first:end] for column in columns), strict=True)

    def _columns(self) -> tuple[array[int], ...]:
        return self.conns, self.times, self.offsets, self.starts, self.ends

    def _transform(self, transform: Callable[[array[int]], Iterator[int]]) -> Messages:
        transformed = Messages()
        for old, new in zip(self._columns(), transformed._columns(), strict=True):
            new.extend(transform(old))
        return transformed


# Nearly all message headers have one of two layouts: ``op`` first, from Python writers, or ``conn`` first, from C++
# writers, which sort the fields.
_CONN_FIRST_PARTS = (b"\x09\0\0\0conn=", b"\x04\0\0\0op=\x02\x0d\0\0\0time=")
_OP_FIRST_LAYOUT = struct.Struct("<I17sI9sIII")
_CONN_FIRST_LAYOUT = struct.Struct("<I9sI17sIII")
_MESSAGE_HEADER_PATTERN = re.compile(
    re.escape(U32.pack(38))
    + b"(?:%b....%b|%b....%b)" % tuple(re.escape(word) for word in (*MESSAGE_HEADER_PARTS, *_CONN_FIRST_PARTS)),
    re.DOTALL,
)


def read_content(data: bytes, *, partial: bool = False) -> tuple[Messages, dict[int, Connection]]:
    """Return the messages in the uncompressed content of a chunk, in order, and the connections defined there, by id.

    If several connections have the same id, the first one is used.

    Args:
        partial: whether the content may be cut off or damaged anywhere; if so, all complete messages are returned, and
            no error is raised.

    Raises:
        RecordError: a record is not complete (the message names its offset in the content), or there are too many
            connections.
    """
    messages = Messages()
    connections: dict[int, Connection] = {}
    add_conn, add_time, add_offset = messages.conns.append, messages.times.append, messages.offsets.append
    add_start, add_end = messages.starts.append, messages.ends.append
    position, end = 0, len(data)
    first_part, second_part, layout = *MESSAGE_HEADER_PARTS, _OP_FIRST_LAYOUT
    while position < end:
        if end - position >= 46:
            size, part1, conn, part2, secs, nsecs, length = layout.unpack_from(data, position)
            if size == 38 and part1 == first_part and part2 == second_part:
                start = position + 46
                stop = start + length
                if stop > end:
                    if not partial:
                        break
                    position = _find_next_message(data, position + 1)
                    continue
                add_conn(conn)
                add_time(secs * NS_PER_S + nsecs)
                add_offset(position)
                add_start(start)
                add_end(stop)
                position = stop
                continue
            if size == 38 and layout is _OP_FIRST_LAYOUT and data[position + 4 : position + 13] == _CONN_FIRST_PARTS[0]:
                first_part, second_part, layout = *_CONN_FIRST_PARTS, _CONN_FIRST_LAYOUT
                continue
        next_position = 0
        try:
            fields, start, stop = split_record(data, position)
            op = op_of(fields)
            next_position = stop  # from here on, the record is skipped as a whole even if other parts of it are wrong
            if op == OP_MESSAGE:
                messages.add(u32_field(fields, "conn"), time_of(fields), position, start, stop)
            elif op == OP_CONNECTION:
                _add_connection(connections, fields, data[start:stop])
        except RecordError as error:
            if not partial:
                raise RecordError(f"{error} (at byte {position} of the chunk's content)") from None
            next_position = next_position or _find_next_message(data, position + 1)
        position = next_position
    if position < end and not partial:
        raise RecordError(f"the message at byte {position} of the chunk's content runs past the chunk's end")
    return messages, connections


def _add_connection(connections: dict[int, Connection], fields: Fields, data: bytes) -> None:
    conn_id = u32_field(fields, "conn")
    if conn_id in connections:
        return
    if len(connections) >= MAX_CONNECTIONS:
        raise RecordError(f"the chunk has more than {MAX_CONNECTIONS} connections")
    connections[conn_id] = parse_connection(fields, data)


def _find_next_message(data: bytes, position: int) -> int:
    """Return the offset of the next message header from `position` on, or the end of the content."""
    match = _MESSAGE_HEADER_PATTERN.search(data, position)
    return len(data) if match is None else match.start()
