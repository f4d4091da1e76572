"""The rosbags library as a second opinion: it reads what we write, and we read what it writes.

Feature: bags cross-checked -- the rosbags library reads our bags, and we read its bags
"""

from __future__ import annotations

from pathlib import Path

import pytest
from rosbags.rosbag1 import Reader, Writer

from pyros1.bag.edit import editing as edit
from pyros1.bag.edit.reindex import reindex
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.writer import BagWriter
from pyros1.bag.record.file import RecordWriter
from pyros1.msgs import load_message

from ..conftest import Make
from ..made import header_of

Content = list[tuple[str, str, str, int, bytes]]


def ours(path: Path) -> Content:
    with BagReader(path) as bag:
        return [
            (m.connection.topic, m.connection.type, m.connection.md5sum, m.time, bytes(m.data)) for m in bag.messages()
        ]


def theirs(path: Path) -> Content:
    with Reader(path) as bag:
        return [
            (connection.topic, connection.msgtype.replace("/msg/", "/"), connection.digest, time, bytes(data))
            for connection, time, data in bag.messages()
        ]


COMPRESSIONS = ["none", "bz2", "lz4"]


def same(path: Path) -> int:
    """Both must find the same in a bag; returns how many messages there are."""
    found = ours(path)
    assert found == theirs(path)
    return len(found)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_rosbags_reads_what_is_written_copied_and_saved(make_bag: Make, tmp_path: Path, compression: str) -> None:
    path = make_bag(compression=compression)
    assert same(path) == 100
    with BagReader(path) as bag, Reader(path) as other:
        assert [c.msgdef.data for c in other.connections] == [c.definition for c in bag.connections.values()]
        assert [c.ext for c in other.connections] == [("/talker", 1), ("/other", None)]
        for target in COMPRESSIONS:
            edit.copy(bag.messages(), tmp_path / "copy.bag", compression=target, chunk_threshold=2000)
            assert theirs(tmp_path / "copy.bag") == ours(path)
    killed = make_bag("killed.bag", compression=compression, close=False)
    reindex(killed, tmp_path / "saved.bag")
    assert same(tmp_path / "saved.bag") == 100


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_rosbags_reads_what_the_recorder_writes(tmp_path: Path, compression: str) -> None:
    path = tmp_path / "x.bag"
    with RecordWriter(str(path), compression, 1000) as writer:
        conn = writer.add_connection("/x", header_of(load_message("std_msgs/String")))
        for time in (5, 3, 9, 1, 7, 2, 8, 0, 6, 4):  # as when simulated time jumps
            writer.write(conn, time, bytes([time]) * 300)
        writer.flush()
        writer.write(conn, 10, bytes(300_000))
    assert same(path) == 11


def test_rosbags_reads_a_bag_without_messages(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "x.bag") as writer:
        writer.add_connection("/x", header_of(load_message("std_msgs/String")))
    assert same(tmp_path / "x.bag") == 0


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_what_rosbags_writes_is_read(tmp_path: Path, compression: str) -> None:
    path = tmp_path / "x.bag"
    with_compression = Writer(path)
    if compression != "none":
        with_compression.set_compression(Writer.CompressionFormat[compression.upper()])
    with_compression.chunk_threshold = 500
    with with_compression as writer:
        numbers = [
            writer.add_connection(
                f"/{name}",
                "std_msgs/msg/String",
                msgdef="string data\n",
                md5sum="992ce8a1687cec8c8bd883ec73ca41d1",
                callerid=f"/{name}",
                latching=1,
            )
            for name in "ab"
        ]
        for i in range(40):
            writer.write(numbers[i % 2], 10**9 + (i ^ 3), b"\1\0\0\0" + bytes([65 + i]))
    assert same(path) == 40
    with BagReader(path) as bag:
        assert len(bag.chunks) > 2
        assert [(c.callerid, c.latching) for c in bag.connections.values()] == [("/a", True), ("/b", True)]
