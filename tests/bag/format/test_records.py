"""bag.format: records, and what is said of those that are malformed."""

from __future__ import annotations

import io
import random
import struct
from pathlib import Path

import pytest

from pyros1.bag.errors import UnindexedError
from pyros1.bag.format.compression import COMPRESSIONS, compress, decompress
from pyros1.bag.format.contents import read_content
from pyros1.bag.format.files import BagFile
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import (
    NS_PER_S,
    Connection,
    RecordError,
    make_bag_header,
    make_connection_record,
    make_record,
    parse_fields,
    time_of,
)
from pyros1.bag.format.scanner import Scanner
from pyros1.bag.format.version_1_2 import OldConnections

from ..conftest import values
from ..made import write_bag
from ..old_bags import number as old_number
from ..old_bags import old_bag

HEAD = b"#ROSBAG V2.0\n" + make_bag_header()
CONNECTION_HEADER = {"topic": b"/x", "type": b"a/B", "md5sum": b"*", "message_definition": b""}


def number(value: int) -> bytes:
    return struct.pack("<I", value)


def message(conn: int, data: bytes = b"data", *, conn_first: bool = False, secs: int = 7) -> bytes:
    """Return a message's record as C++ recorders write it, with sorted fields, or as Python's do."""
    fields = {"op": b"\2", "conn": number(conn), "time": struct.pack("<II", secs, 5)}
    return make_record(dict(sorted(fields.items())) if conn_first else fields, data)


def test_stray_bytes_after_the_fields() -> None:
    with pytest.raises(RecordError, match="stray bytes after the header's fields"):
        parse_fields(number(4) + b"op=\2" + b"abc")


def test_a_time_of_another_size() -> None:
    assert time_of({"time": struct.pack("<II", 7, 5)}) == 7_000_000_005
    with pytest.raises(RecordError, match="the record has no field time of 8 bytes"):
        time_of({"time": bytes(4)})


def test_a_bag_header_that_does_not_fit() -> None:
    with pytest.raises(RecordError, match=r"the bag header would need 5.* bytes, more than 4096"):
        make_bag_header(extra_fields={"encrypted_key": bytes(5000)})


@pytest.mark.parametrize("count", [0, 1, 3])
def test_message_headers_in_the_order_of_cpp_recorders(count: int) -> None:
    """The reader expects the order of the first one for those that follow, and reads the others all the same."""
    content = b"".join(message(i, bytes(i)) for i in range(count)) + b"".join(
        message(i, bytes(i), conn_first=i != 5) for i in range(count, 8)
    )
    messages, _ = read_content(content)
    assert list(messages.conns) == list(range(8)) and set(messages.times) == {7_000_000_005}
    assert [content[one.start : one.end] for one in messages] == [bytes(i) for i in range(8)]


def test_the_first_connection_of_an_id_is_used() -> None:
    first, second = (make_connection_record(Connection(3, topic, CONNECTION_HEADER)) for topic in ("/first", "/second"))
    assert {conn: found.topic for conn, found in read_content(first + second)[1].items()} == {3: "/first"}


def test_there_is_an_end_to_the_connections_of_a_chunk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bag.format.contents.MAX_CONNECTIONS", 2)
    content = b"".join(make_connection_record(Connection(i, "/x", CONNECTION_HEADER)) for i in range(3))
    with pytest.raises(RecordError, match=r"the chunk has more than 2 connections \(at byte"):
        read_content(content)
    assert set(read_content(content, partial=True)[1]) == {0, 1}


def test_there_is_an_end_to_the_connections_of_an_index(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "x.bag", count=5)
    data = bytearray(path.read_bytes())
    place = data.index(b"conn_count=") + len("conn_count=")
    data[place : place + 4] = number(1 << 20)
    path.write_bytes(data)
    with pytest.raises(UnindexedError, match="the number of connections, 1048576, is too large"):
        BagReader(path)
    assert values(path) == list(range(5))


def test_there_is_an_end_to_connections_and_definitions_of_an_old_bag(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bag.format.version_1_2.MAX_CONNECTIONS", 2)
    connections: dict[int, Connection] = {}
    old = OldConnections(connections)
    assert [old.connection_id({"topic": topic, "type": b"a/B"}) for topic in (b"/0", b"/1", b"/0")] == [0, 1, 0]
    with pytest.raises(RecordError, match="the bag has more than 2 connections"):
        old.connection_id({"topic": b"/2", "type": b"a/B"})
    assert set(connections) == {0, 1}
    old.add_definition({"type": b"a/B", "md5": b"1", "def": b"int32 a"})  # also for messages that name no md5 sum
    with pytest.raises(RecordError, match="the bag has more than 2 definitions"):
        old.add_definition({"type": b"a/B", "md5": b"2", "def": b"int32 b"})


@pytest.mark.parametrize(
    ("name", "value", "error"),
    [
        (b"op", b"\x07", "this is not the expected kind of record"),
        (b"ver", number(2), "the chunk info is malformed"),
        (b"count", number(3), "the chunk info is malformed"),
    ],
)
def test_a_chunk_info_that_is_not_one(tmp_path: Path, name: bytes, value: bytes, error: str) -> None:
    path = write_bag(tmp_path / "x.bag", count=5)
    data = bytearray(path.read_bytes())
    with BagReader(path) as bag:
        _, begin, length = bag.file.record(bag.file.index_pos)
        begin, length = bag.file.record(begin + length)[1:]
        place = data.index(name + b"=", bag.file.record(begin + length)[1] - 120) + len(name) + 1
    data[place : place + len(value)] = value
    path.write_bytes(data)
    with pytest.raises(UnindexedError, match=rf"the index is damaged at byte \d+ \({error}\)"):
        BagReader(path)
    assert values(path) == list(range(5))


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("size", [0, 1, 3_000_000])
def test_what_was_compressed_is_decompressed(compression: str, size: int) -> None:
    """Zeros become so few bytes that one piece of them holds many pieces of content; noise follows in more pieces."""
    content = bytes(size) + random.Random(size).randbytes(min(size, 1_100_000 if compression == "lz4" else 1000))
    stored = b"".join(compress(compression, [content[: size // 3], content[size // 3 :]]))
    assert decompress(compression, stored, len(content), 1 << 23) == content


@pytest.mark.parametrize("compression", ["bz2", "lz4"])
def test_compressed_data_that_hold_less_or_more_than_they_claim(compression: str) -> None:
    stored = b"".join(compress(compression, [b"abc" * 1000]))
    with pytest.raises(RecordError, match="the chunk holds 3000 bytes instead of 3001"):
        decompress(compression, stored, 3001, 1 << 20)
    assert decompress(compression, stored, 3001, 1 << 20, partial=True) == b"abc" * 1000
    noise = random.Random(1).randbytes(100_000)
    stored = b"".join(compress(compression, [noise]))
    assert decompress(compression, stored, 10, 10) == noise[:10]
    assert decompress(compression, stored, 1 << 20, 10, partial=True) == noise[:10]


@pytest.mark.slow
@pytest.mark.parametrize("compression", ["bz2", "lz4"])
def test_of_damaged_data_the_part_before_the_damage_is_kept(compression: str) -> None:
    content = random.Random(1).randbytes(1_200_000 if compression == "lz4" else 950_000)  # a block, and another one
    stored = bytearray(b"".join(compress(compression, [content])))
    begin = len(stored) * 19 // 20
    stored[begin:] = b"\xff" * (len(stored) - begin)
    with pytest.raises(RecordError, match=f"the chunk's {compression} data are damaged: "):
        decompress(compression, bytes(stored), len(content), 1 << 22)
    kept = decompress(compression, bytes(stored), len(content), 1 << 22, partial=True)
    assert 800_000 <= len(kept) <= len(content) and content.startswith(kept[:800_000])


@pytest.mark.parametrize("owned", [True, False])
def test_what_is_fetched_ahead_may_be_behind_the_end(tmp_path: Path, owned: bool) -> None:
    """Damaged records name any place; a file that someone else opened is left to them."""
    path = write_bag(tmp_path / "x.bag", count=5)
    with BagReader(path if owned else io.BytesIO(path.read_bytes())) as bag:
        bag.file.prefetch([bag.chunks[0].pos, bag.file.size, 1 << 63])
        assert bag.count() == 5 == len(list(bag.messages()))


def scan(data: bytes) -> tuple[int, list[tuple[int, str]]]:
    """Return how many messages a scan finds, and the damage: offset and reason."""
    scanner = Scanner(BagFile(io.BytesIO(data)))
    count = sum(len(chunk.messages) for chunk in scanner.chunks())
    return count, [(damage.offset, damage.reason) for damage in scanner.damaged_places]


@pytest.mark.parametrize(("more", "damages"), [(b"", 0), (message(0)[:-2], 1), (b"x", 1)])
def test_messages_outside_of_chunks_up_to_the_end_of_the_file(more: bytes, damages: int) -> None:
    whole = HEAD + make_connection_record(Connection(0, "/x", CONNECTION_HEADER)) + message(0) + message(0)
    count, found = scan(whole + more)
    assert count == 2 and [offset for offset, _ in found] == [len(whole)] * damages


def test_a_message_of_an_old_bag_without_a_time_costs_only_itself() -> None:
    whole = old_bag([old_number("/a", i * NS_PER_S, i) for i in range(3)], indexed=False)
    place = whole.index(b"sec=", whole.index(b"sec=", whole.index(b"nsec=") + 5) + 4)
    place = whole.index(b"\x08\0\0\0sec=", place) + 4
    count, found = scan(whole[:place] + b"xxx=" + whole[place + 4 :])
    assert count == 2 and len(found) == 1


@pytest.mark.parametrize(
    "data",
    [number(4) + b"a=b", number(3) + b"abc", number(3) + b"a=b" + number(2) + b"cd", number(1) + b"a=bc"],
    ids=["runs past the end", "no '='", "no '=' later", "no '=' within its length"],
)
def test_fields_that_are_not_whole(data: bytes) -> None:
    with pytest.raises(RecordError, match="a header field runs past the header's end, or has no '='"):
        parse_fields(data)
