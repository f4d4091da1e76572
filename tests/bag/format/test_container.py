"""The writer, and the reader on what it wrote (B01-B13)."""

from __future__ import annotations

import errno
import struct
from io import FileIO
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1.bag.format.files import Counts
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import BAG_HEADER_SIZE, RECORD_OVERHEAD
from pyros1.bag.format.writer import BagWriter
from pyros1.ground.errors import Error
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import AnyMsg, load_message

from ..conftest import Make, values
from ..made import header_of

HEADER = header_of(load_message("std_msgs/String"))


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_messages_come_back_in_order_b10(make_bag: Make, compression: str) -> None:
    path = make_bag(compression=compression)
    assert values(path, unindexed=False) == list(range(100))
    with BagReader(path) as bag:
        assert len(bag.chunks) > 5
        assert {bag.header(chunk).compression for chunk in bag.chunks} == {compression}


def test_bag_header_has_the_size_that_others_rewrite_b03(make_bag: Make) -> None:
    with BagReader(make_bag()) as bag:
        assert bag.file.begin == 13 + 4 + BAG_HEADER_SIZE + 4


def test_headers_are_kept_whole_b05(make_bag: Make) -> None:
    with BagReader(make_bag()) as bag:
        assert bag.connections[0].text("tcp_nodelay") == "0"
        assert bag.connections[0].latching and not bag.connections[1].latching
        assert bag.connections[1].callerid == "/other"


def test_unsorted_times_are_sorted_within_and_between_chunks_b12(tmp_path: Path) -> None:
    times = [5, 3, 9, 1, 7, 2, 8, 0, 6, 4]
    with BagWriter(tmp_path / "x.bag", chunk_threshold=300) as writer:
        conn = writer.add_connection("/x", HEADER)
        for time in times:
            writer.write(conn, time, bytes(60))
    with BagReader(tmp_path / "x.bag") as bag:
        assert len(bag.chunks) > 1
        assert [message.time for message in bag.messages()] == list(range(10))
        assert [message.time for message in bag.messages(start=3, end=6)] == [3, 4, 5, 6]
        indexed = (time for _, time in bag.times())
        for chunk in bag.chunks:
            stamps = list(islice(indexed, chunk.counts[conn]))
            assert stamps == sorted(stamps)


def test_equal_times_keep_the_files_order(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "x.bag", chunk_threshold=100) as writer:
        conns = [writer.add_connection(f"/{i}", HEADER) for i in range(2)]
        for i in range(10):
            writer.write(conns[i % 2], 7, bytes([i]))
    with BagReader(tmp_path / "x.bag") as bag:
        assert [message.data[0] for message in bag.messages()] == list(range(10))


def test_chunks_that_all_overlap_are_not_all_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bag sorted by topic: every chunk spans all of the time."""
    with BagWriter(tmp_path / "x.bag") as writer:
        for topic in range(10):
            conn = writer.add_connection(f"/{topic}", HEADER)
            for i in range(10):
                writer.write(conn, 10 * i + topic, bytes(200))
            writer.flush()
    monkeypatch.setattr("pyros1.bag.format.reader.MAX_OPEN_BYTES", 5000)
    with BagReader(tmp_path / "x.bag") as bag:
        assert [message.time for message in bag.messages()] == list(range(100))


def test_counts_are_packed_and_a_mapping() -> None:
    counts = Counts(struct.pack("<6I", 7, 2, 1, 5, 300, 1))
    assert counts == {7: 2, 1: 5, 300: 1} and len(counts) == 3 and 300 in counts and 2 not in counts
    assert counts.keys() & {1, 2} == {1} and dict(counts.items()) == counts
    assert not Counts(b"")


def test_a_time_that_does_not_fit_does_not_spoil_the_bag(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "x.bag") as writer:
        conn = writer.add_connection("/x", HEADER)
        for time in (-1, (1 << 32) * 10**9, 1 << 63):
            with pytest.raises(pyros1.bag.BagError, match="cannot be stored"):
                writer.write(conn, time, b"")
        writer.write(conn, 1, b"")
        writer.write(conn, (1 << 32) * 10**9 - 1, b"")
    with BagReader(tmp_path / "x.bag") as bag:
        assert bag.count() == 2


class FullDisk(FileIO):
    """A file on a disk that is full after some bytes; a part of what does not fit is written."""

    room = 6000

    def write(self, data: Any) -> int:
        if self.room <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        part = data[: self.room]
        self.room -= len(part)
        return super().write(part)


def test_a_full_disk_leaves_a_bag_that_can_be_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files: list[FullDisk] = []
    monkeypatch.setattr("pyros1.bag.format.writer.FileIO", lambda *words: files.append(FullDisk(*words)) or files[0])
    writer = BagWriter(tmp_path / "x.bag", chunk_threshold=500)
    conn = writer.add_connection("/x", HEADER)
    written = 0
    with pytest.raises(OSError, match="No space"):
        while True:
            writer.write(conn, written, bytes(50))
            written += 1
    files[0].room = 1 << 20  # what was cut off, or someone else's files, make room for the index
    writer.close()
    with BagReader(tmp_path / "x.bag") as bag:
        assert 0 < bag.count() == writer.messages < written
        assert [message.time for message in bag.messages()] == list(range(bag.count()))


def test_no_chunk_becomes_larger_than_readers_accept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bag.format.writer.MAX_CHUNK_SIZE", 1000)
    with BagWriter(tmp_path / "x.bag", chunk_threshold=1 << 20) as writer:
        conn = writer.add_connection("/x", HEADER)
        for time in range(50):
            writer.write(conn, time, bytes(60))
        assert writer.chunks
    with BagReader(tmp_path / "x.bag") as bag:
        assert bag.count() == 50 and max(header.size for header in bag.headers()) <= 1000 + RECORD_OVERHEAD


def test_a_file_object_that_cannot_be_written_is_named_and_left_as_it_is(make_bag: Make) -> None:
    path = make_bag()
    before = path.read_bytes()
    with path.open("rb") as file, pytest.raises(OSError) as caught:
        BagWriter(file)
    assert caught.value.filename == str(path) and path.read_bytes() == before
    with pytest.raises(ValueError, match="closed file"):
        BagWriter(file)


# pyros1.bag.open --------------------------------------------------------------------------------------------------


def test_open_gives_messages_of_topics_and_times(make_bag: Make) -> None:
    with pyros1.bag.open(make_bag()) as bag:
        assert (bag.start, bag.end) == (Time(100), Time(100, 990_000_000))
        assert bag.topics == {"/a": "std_msgs/Int32", "/b": "std_msgs/String"}
        assert (len(bag), bag.count("/a"), bag.count(["b"]), bag.count("/nope")) == (100, 50, 50, 0)

        def found(*args: Any) -> list[int]:
            return [int(item.message.data) for item in bag.messages(*args)]

        assert found("/a", 0.5, 0.55) == [50, 52, 54]
        assert found("a", Time(100, 970_000_000)) == [98]
        assert found(None, -0.02) == [97, 98, 99]
        assert found(["/a", "/b"], Duration(0, 10_000_000), 0.02) == [1, 2]
        assert [item.topic for item in bag][:2] == ["/a", "/b"]


def test_raw_messages_decode_later(make_bag: Make) -> None:
    with pyros1.bag.open(make_bag()) as bag:
        item = next(iter(bag.messages("/b", raw=True)))
        assert isinstance(item.message, AnyMsg)
        decoded: Any = item.message.decode()
        assert decoded.data == "1"


def test_at_is_the_last_message_of_each_topic(make_bag: Make) -> None:
    with pyros1.bag.open(make_bag()) as bag:
        assert {topic: int(item.message.data) for topic, item in bag.at(0.5).items()} == {"/a": 50, "/b": 49}
        assert {topic: int(item.message.data) for topic, item in bag.at(None).items()} == {"/a": 98, "/b": 99}
        assert list(bag.at(0.0)) == ["/a"]


def test_columns_are_for_numpy_and_pandas(make_bag: Make) -> None:
    with pyros1.bag.open(make_bag(count=6)) as bag:
        assert bag.columns("/a") == {"time": [100.0, 100.02, 100.04], "data": [0, 2, 4]}
        assert bag.columns("/b", ["data"], end=0.01)["data"] == ["1"]


def test_a_wrong_definition_says_where(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "x.bag") as writer:
        writer.write(writer.add_connection("/x", HEADER), 5, b"\xff\xff\xff")
    with pyros1.bag.open(tmp_path / "x.bag") as bag, pytest.raises(Error, match=r"x\.bag: message on /x at .*std_msgs"):
        next(iter(bag.messages()))
