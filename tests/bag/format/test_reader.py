"""bag.format.reader: messages with their places, in the order of ranks, and what is said of a damaged chunk."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from pyros1.bag.errors import BagError
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.writer import BagWriter

from ..conftest import Make
from ..made import write_bag


def test_a_message_is_found_again_at_its_place(make_bag: Make) -> None:
    with BagReader(make_bag()) as bag:
        located = list(bag.located_messages())
        assert [place[:3] for place in located] == [tuple(message) for message in bag.messages()]
        assert len({place.location for place in located}) == 100
        for place in located[::7]:
            assert bag.at(place.location) == place[:3]


def test_no_message_at_a_place_is_an_error(make_bag: Make) -> None:
    with BagReader(make_bag()) as bag:
        pos, offset = next(bag.located_messages()).location
        end = len(bag.content(bag.chunks[0])[0])
        for place in ((pos + 1, offset), (pos, offset + 1), (pos, end)):
            with pytest.raises(BagError, match=rf"there is no message at {place[1]} in a chunk at {place[0]}$"):
                bag.at(place)


@pytest.mark.parametrize("chunk_threshold", [1, 1 << 20], ids=["a chunk each", "one chunk"])
def test_messages_of_the_same_time_come_by_rank(tmp_path: Path, chunk_threshold: int) -> None:
    header = {"type": b"a/B", "md5sum": b"*", "message_definition": b""}
    with BagWriter(tmp_path / "x.bag", chunk_threshold=chunk_threshold) as writer:
        conns = [writer.add_connection(f"/{i}", header) for i in range(2)]
        for i, time in enumerate((9, 7, 7, 7, 7, 5)):
            writer.write(conns[i % 2], time, bytes([i]))
    with BagReader(tmp_path / "x.bag") as bag:

        def found(first: int, second: int) -> list[int]:
            return [place.data[0] for place in bag.located_messages(ranks={conns[0]: first, conns[1]: second})]

        assert found(0, 1) == [5, 2, 4, 1, 3, 0]
        assert found(1, 0) == [5, 1, 3, 2, 4, 0]
        assert found(0, 0) == [5, 1, 2, 3, 4, 0]


def test_a_bag_is_read_while_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    with BagWriter(path) as writer:
        conn = writer.add_connection("/x", {"type": b"a/B", "md5sum": b"*", "message_definition": b""})
        writer.write(conn, 1, b"one")
        writer.flush()
        writer.write(conn, 2, b"two")  # is not in the file yet
        with BagReader(path, unfinished_writer=writer) as bag:
            assert [message.data for message in bag.messages()] == [b"one"]
            assert bag.connections[conn].topic == "/x"


def put_length(path: Path, place: int, length: int) -> None:
    data = bytearray(path.read_bytes())
    data[place : place + 4] = struct.pack("<I", length)
    path.write_bytes(data)


@pytest.mark.parametrize(
    ("length", "reason"),
    [(1 << 30, "the chunk runs past the end of the file"), (70_000, "the chunk's lengths contradict each other")],
)
def test_what_is_wrong_with_a_chunks_length_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, length: int, reason: str
) -> None:
    monkeypatch.setattr("pyros1.bag.format.files.TRUSTED_SIZE", 1 << 16)
    path = write_bag(tmp_path / "x.bag", chunk_threshold=1 << 20)
    with BagReader(path) as bag:
        pos = bag.chunks[0].pos
        place = bag.header(bag.chunks[0]).data_offset - 4
    put_length(path, place, length)
    path.write_bytes(path.read_bytes() + bytes(100_000))
    with BagReader(path) as bag, pytest.raises(BagError, match=rf"at byte {pos}: {reason}; .*reindex"):
        next(bag.messages())


def test_an_index_may_name_a_place_without_chunk(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "x.bag", count=5)
    with BagReader(path) as bag:
        header = bag.header(bag.chunks[0])
    place = path.read_bytes().index(b"chunk_pos=") + len("chunk_pos=")
    behind = header.data_offset + header.stored_size
    put_length(path, place, behind)
    with BagReader(path) as bag, pytest.raises(BagError, match=rf"at byte {behind}: there is no chunk here; .*reindex"):
        next(bag.messages())


def test_of_a_chunk_above_the_limit_it_is_said_how_to_raise_it_not_to_reindex(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "x.bag", chunk_threshold=1 << 20)
    with BagReader(path, chunk_limit=1000) as bag, pytest.raises(BagError, match="the limit is 1000 ") as caught:
        next(bag.messages())
    assert "--chunk-limit" in str(caught.value) and "reindex" not in str(caught.value)


@pytest.mark.parametrize("what", [b"op=\x04", b"count="], ids=["no index record", "another number of messages"])
def test_times_are_those_of_the_content_if_the_index_contradicts_the_chunk(tmp_path: Path, what: bytes) -> None:
    """The times in it are wrong, too."""
    path = write_bag(tmp_path / "x.bag", count=5)
    with BagReader(path) as bag:
        header = bag.header(bag.chunks[0])
        behind = header.data_offset + header.stored_size
        entries = bag.file.record(behind)[1]
        end = bag.file.index_pos
        expected = sorted(bag.times())
    data = bytearray(path.read_bytes())
    place = data.rindex(what, behind, end) + len(what) - 1 + what.startswith(b"count")
    data[place] ^= 1
    data[entries : entries + 8] = bytes(8)
    path.write_bytes(data)
    with BagReader(path) as bag:
        assert sorted(bag.times()) == expected


def test_chunks_that_overlap_are_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    header = {"type": b"a/B", "md5sum": b"*", "message_definition": b""}
    with BagWriter(tmp_path / "x.bag") as writer:
        conn = writer.add_connection("/x", header)
        for first in range(3):
            for time in range(first, 30, 3):
                writer.write(conn, time, bytes([time]))
            writer.flush()
    read: list[int] = []
    with BagReader(tmp_path / "x.bag") as bag:
        content = bag.content
        monkeypatch.setattr(bag, "content", lambda chunk: (read.append(chunk.pos), content(chunk))[1])
        assert [message.data[0] for message in bag.messages()] == list(range(30))
        assert read == [chunk.pos for chunk in bag.chunks] and len(read) == 3
