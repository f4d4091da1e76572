"""Bags that were not closed, are cut off or spoilt: what is said of them, and what is saved.

Feature: damaged bags are repaired -- `pyros1 bag reindex`, in time proportional to the size of the file; all other
    commands report the file and position
"""

from __future__ import annotations

import contextlib
import os
import random
import struct
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.bag.edit.reindex import reindex
from pyros1.bag.errors import BagError, NotABagError, UnindexedError
from pyros1.bag.format.files import BagFile
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import RecordError, make_bag_header, make_fields, make_record, parse_fields
from pyros1.bag.format.scanner import Scanner
from pyros1.bag.format.writer import BagWriter
from pyros1.bag.info import summarize
from pyros1.cli.running import run_command

from ..conftest import Make, values
from ..made import damaged_bags, write_bag

topic = partial(run_command, "topic")


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"", "the file is empty"),
        (b"#ROSBAG", "ends in its first line"),
        (b"hello\n", "not a bag file"),
        (bytes(5000), "begins with zeros"),
        (b"SQLite format 3\0", "a ROS 2 bag"),
        (b"\x89MCAP0\r\n", "an MCAP file"),
        (b"#ROSRECORD V1.1\n", "version 1.1 is not supported"),
        (b"#ROSLOG V1.0\n1\n", "version 1.0 is not supported"),
        (b"#ROSRECORD V1.", "ends in its first line"),
        (b"#ROSBAG V3.0\n", "version 3.0 is not supported"),
        (b"#ROSBAG V2.0\n\x10", "the bag header cannot be read"),
    ],
)
def test_what_is_no_bag_is_told_with_the_file_b44(tmp_path: Path, content: bytes, text: str) -> None:
    path = tmp_path / "x.bag"
    path.write_bytes(content)
    with pytest.raises(BagError, match=text) as caught:
        BagReader(path, unindexed=True)
    assert str(path) in str(caught.value)
    assert isinstance(caught.value, NotABagError) or "header" in text


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_an_open_bag_is_read_and_reindexed_l143(make_bag: Make, tmp_path: Path, compression: str) -> None:
    path = make_bag(compression=compression, close=False)
    with pytest.raises(UnindexedError, match=r"was not closed.*pyros1 bag reindex"):
        BagReader(path)
    assert values(path) == list(range(100))
    saved = reindex(path, tmp_path / "new.bag")
    assert (saved.messages, saved.lost, saved.damaged_places) == (100, 0, [])
    assert values(tmp_path / "new.bag", unindexed=False) == list(range(100))
    with BagReader(tmp_path / "new.bag") as bag:
        assert bag.connections[0].text("tcp_nodelay") == "0"


@pytest.mark.slow
@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_cut_anywhere_every_whole_chunk_comes_back(make_bag: Make, tmp_path: Path, compression: str) -> None:
    path = make_bag(compression=compression)
    whole = path.read_bytes()
    with BagReader(path) as bag:
        ends = []
        count = 0
        for chunk in bag.chunks:
            header = bag.header(chunk)
            count += sum(chunk.counts.values())
            ends.append((header.data_offset + header.stored_size, count))
    for size in random.Random(1).sample(range(4117, len(whole)), 60):
        path.write_bytes(whole[:size])
        saved = reindex(path, tmp_path / "new.bag")
        least = max((count for end, count in ends if end <= size), default=0)
        assert saved.messages >= least
        assert values(tmp_path / "new.bag", unindexed=False) == list(range(saved.messages))
        assert values(path) == list(range(saved.messages))  # read without reindexing, too


def test_of_an_uncompressed_chunk_that_is_cut_every_message_comes_back(make_bag: Make, tmp_path: Path) -> None:
    path = make_bag(count=40, chunk_threshold=1 << 20)
    whole = path.read_bytes()
    with BagReader(path) as bag:
        start = bag.header(bag.chunks[0]).data_offset
        messages = bag.content(bag.chunks[0])[1]
    path.write_bytes(whole[: start + messages[30].end])
    assert reindex(path, tmp_path / "new.bag").messages == 31


def test_a_chunk_that_the_recorder_had_open_is_saved(make_bag: Make, tmp_path: Path) -> None:
    """Stock's recorder writes messages behind a chunk header that says 0 bytes until the chunk is full."""
    with BagReader(make_bag(chunk_threshold=1 << 20)) as bag:
        content = bag.content(bag.chunks[0])[0]
    opened = make_record({"compression": b"none", "op": b"\5", "size": bytes(4)})
    path = tmp_path / "open.bag.active"
    path.write_bytes(b"#ROSBAG V2.0\n" + make_bag_header() + opened + content[:-3])
    saved = reindex(path, tmp_path / "new.bag")
    assert saved.messages == 99
    assert "not finished" in saved.damaged_places[0].reason
    assert values(tmp_path / "new.bag", unindexed=False) == list(range(99))
    assert values(path) == list(range(99))


@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_spoilt_bytes_cost_only_their_chunk(make_bag: Make, tmp_path: Path, compression: str) -> None:
    path = make_bag(compression=compression)
    with BagReader(path) as bag:
        victim = bag.chunks[3]
        survivors = [c for c in bag.chunks if c is not victim]
    data = bytearray(path.read_bytes())
    data[victim.pos : victim.pos + 120] = bytes(120)
    path.write_bytes(data)
    with BagReader(path) as bag, pytest.raises(BagError, match=rf"at byte {victim.pos}: .*reindex"):
        list(bag.messages())
    saved = reindex(path, tmp_path / "new.bag")
    assert saved.messages == sum(sum(c.counts.values()) for c in survivors)
    assert saved.damaged_places


@pytest.mark.parametrize("spoilt", [b"\xff" * 60, bytes(60)], ids=["ones", "zeros"])
@pytest.mark.parametrize("cut", [False, True])
def test_spoilt_bytes_in_an_uncompressed_chunk_cost_only_their_messages(
    make_bag: Make, tmp_path: Path, spoilt: bytes, cut: bool
) -> None:
    path = make_bag(chunk_threshold=100_000)
    data = bytearray(path.read_bytes())
    begin = data.index(b"\x02\0\0\x0051") + 6  # two records, in the middle
    data[begin : begin + len(spoilt)] = spoilt
    end = data.index(b"\x02\0\0\x0099") + 6
    path.write_bytes(data[:end] if cut else data)
    saved = reindex(path, tmp_path / "new.bag")
    assert saved.damaged_places
    assert values(tmp_path / "new.bag") == [i for i in range(100) if i not in (52, 53)]


@pytest.mark.parametrize("place", [13, 17, 30, 86, 87])
def test_behind_a_spoilt_bag_header_all_is_found(make_bag: Make, tmp_path: Path, place: int) -> None:
    path = make_bag()
    data = bytearray(path.read_bytes())
    data[place : place + 4] = b"\xff\x80\xff\x7f"
    path.write_bytes(data)
    assert reindex(path, tmp_path / "new.bag").messages == 100
    assert values(path) == list(range(100))


def test_a_spoilt_connection_record_costs_only_its_messages(make_bag: Make, tmp_path: Path) -> None:
    path = make_bag(close=False, chunk_threshold=1 << 20)
    data = bytearray(path.read_bytes())
    data[data.index(b"md5sum=")] = 0
    path.write_bytes(data)
    saved = reindex(path, tmp_path / "new.bag")
    assert (saved.messages, saved.lost) == (50, 50)
    assert values(tmp_path / "new.bag") == list(range(1, 100, 2))


def test_noise_neither_hangs_nor_raises(make_bag: Make, tmp_path: Path) -> None:
    path = make_bag()
    whole = path.read_bytes()
    chance = random.Random(2)
    for _ in range(60):
        data = bytearray(whole)
        for _ in range(chance.randint(1, 20)):
            place = chance.randrange(4117, len(data))
            data[place : place + 8] = chance.randbytes(8)
        path.write_bytes(data)
        saved = reindex(path, tmp_path / "new.bag")
        with BagReader(tmp_path / "new.bag") as bag:
            assert sum(1 for _ in bag.messages()) == saved.messages


def test_lengths_of_damaged_records_cost_no_memory(make_bag: Make, tmp_path: Path) -> None:
    huge = struct.pack("<I", 0xFFFFFFF0)
    fields = make_fields({"op": b"\5", "compression": b"lz4", "size": huge})
    path = tmp_path / "x.bag"
    path.write_bytes(b"#ROSBAG V2.0\n" + make_bag_header() + struct.pack("<I", len(fields)) + fields + huge + b"abc")
    assert reindex(path, tmp_path / "new.bag").messages == 0
    path.write_bytes(b"#ROSBAG V2.0\n" + make_bag_header() + huge + b"abc")
    assert reindex(path, tmp_path / "new.bag").messages == 0


@pytest.mark.slow
@pytest.mark.parametrize("what", ["content", "stored", "index", "open chunk", "connection"])
def test_a_length_that_lies_reads_little_of_a_large_file(
    make_bag: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    """The file is so long that the length would fit into it; what lies behind is found all the same."""
    path = make_bag(chunk_threshold=2000)
    with BagReader(path) as bag:
        chunk = bag.chunks[1]
        rest = sum(sum(other.counts.values()) for other in bag.chunks if other is not chunk)
        header = bag.header(chunk)
        content = path.read_bytes().index(b"size=", chunk.pos) + len("size=")
        stored = header.data_offset - 4
        index = bag.file.record(header.data_offset + header.stored_size)[1] - 4
        connection = bag.file.record(bag.file.index_pos)[1] - 4
    data = bytearray(path.read_bytes())
    places = {"content": content, "stored": stored, "index": index, "connection": connection}
    if what == "open chunk":
        data[content : content + 4] = data[stored : stored + 4] = bytes(4)
    place = places.get(what, header.data_offset + 42)
    data[place : place + 4] = struct.pack("<I", 90 << 20)
    path.write_bytes(data)
    os.truncate(path, 100 << 20)
    longest = 0
    read = BagFile.read

    def watched(self: BagFile, position: int, size: int) -> bytes:
        nonlocal longest
        found = read(self, position, size)
        longest = max(longest, len(found))
        return found

    monkeypatch.setattr(BagFile, "read", watched)
    assert reindex(path, tmp_path / "new.bag").messages >= rest
    with contextlib.suppress(BagError), BagReader(path) as bag:
        summarize(bag, frequencies=True)
        list(bag.messages())
    assert longest <= 64 << 20


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "x.bag")
    with pytest.raises(NotABagError, match="pipe"):
        BagReader(tmp_path / "x.bag")


def test_an_index_that_names_a_chunk_twice_is_damaged(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "x.bag", count=5)
    with BagReader(path) as bag:
        assert len(bag.chunks) == 1
        begin, (info,) = bag.file.index_pos, bag.chunks
        connections = len(bag.connections)
    fields = {"op": b"\6", "ver": struct.pack("<I", 1), "chunk_pos": struct.pack("<Q", info.pos)}
    fields |= {"start_time": struct.pack("<II", 0, 0), "count": struct.pack("<I", 1)}
    again = make_record({**fields, "end_time": struct.pack("<II", 2**32 - 1, 0)}, struct.pack("<II", 0, 5))
    head = make_bag_header(begin, connections, 2)
    content = path.read_bytes()
    path.write_bytes(content[:13] + head + content[13 + len(head) :] + again)
    with pytest.raises(UnindexedError, match="lists a chunk twice"):
        BagReader(path)
    assert values(path) == list(range(5))


def chunk_head(compression: bytes, stored: int, size: int) -> bytes:
    """A chunk's record up to its data, of which it claims to have so many bytes, and so many when they are unpacked."""
    fields = {"op": b"\5", "compression": compression, "size": struct.pack("<I", size)}
    return make_record(fields)[:-4] + struct.pack("<I", stored)


MESSAGE = make_record({"op": b"\2", "conn": bytes(4), "time": bytes(8)}, b"abcd")
INDEX = make_record({"op": b"\4", "ver": b"\1\0\0\0", "conn": bytes(4), "count": bytes(4)})
OLD = b"#ROSRECORD V1.2\n"


@pytest.mark.parametrize(
    ("begin", "record"),
    [
        (b"", chunk_head(b"none", 1 << 30, 5)),
        (b"", chunk_head(b"lz4", 1 << 30, 1 << 20)),
        (b"", chunk_head(b"lz4", 0, 0)),
        (b"", MESSAGE + INDEX),
        (b"", MESSAGE[:-8] + struct.pack("<I", 1 << 30)),
        (b"", struct.pack("<II", 0xF00000, 16) + b"compression=none"),
        (OLD, struct.pack("<II", 0xF000, 3) + b"op="),
    ],
    ids=["cut", "cut lz4", "open", "loose", "long", "word", "old"],
)
def test_records_in_each_other_are_not_read_again_and_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, begin: bytes, record: bytes
) -> None:
    """Each claims that it holds the rest of the file; a file of some megabytes would take hours."""
    monkeypatch.setattr("pyros1.bag.format.scanner.MIN_READ_BUDGET", 1 << 20)
    path = tmp_path / "x.bag"
    count = (1 << 18) // len(record)
    path.write_bytes((begin or b"#ROSBAG V2.0\n" + make_bag_header()) + record * count)
    file = BagFile(path)
    with contextlib.closing(file):
        for _ in Scanner(file).chunks():
            pass
        assert file.bytes_read < (65 << 18) + (3 << 20)


def test_what_was_not_searched_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bag.format.scanner.MIN_READ_BUDGET", 0)
    (tmp_path / "x.bag").write_bytes(b"#ROSBAG V2.0\n" + make_bag_header() + chunk_head(b"none", 1 << 30, 5) * 500)
    saved = reindex(tmp_path / "x.bag", tmp_path / "new.bag")
    assert "there is so much damage that the rest of the file was not searched" in saved.damaged_places[-1].reason


def test_chunks_in_each_other_are_not_read(tmp_path: Path) -> None:
    """A message holds a chunk, whose message holds a chunk ...: read one by one, each would be most of the file."""
    path = write_bag(tmp_path / "x.bag", count=20, chunk_threshold=200)
    data = path.read_bytes()
    with BagReader(path) as bag:
        first, second = bag.chunks[:2]
        place = bag.header(first).data_offset - 4
    path.write_bytes(data[:place] + struct.pack("<I", second.pos + 9 - place) + data[place + 4 :])
    with BagReader(path) as bag, pytest.raises(BagError, match=rf"at byte {first.pos}: .*overlaps the one at byte"):
        list(bag.messages())


def test_there_is_an_end_to_fields_and_definitions(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="more than 4096 fields"):
        parse_fields(b"".join(struct.pack("<I", 6) + b"%05x=" % i for i in range(5000)))
    header = {"type": b"a/B", "md5sum": b"*", "message_definition": bytes(27)}  # with the topic 33 bytes
    with BagWriter(tmp_path / "x.bag") as writer:
        for number in range(9):
            writer.write(writer.add_connection(f"/{number}", header), 0, b"")
    file = BagFile(tmp_path / "x.bag", limit=100)
    scanner = Scanner(file)
    with contextlib.closing(file):
        for _ in scanner.chunks():
            pass
    assert len(scanner.connections) == 3


def swap_times(path: Path) -> Path:
    """Let the index say that the first chunk ends before it begins."""
    data = bytearray(path.read_bytes())
    info = data.index(b"start_time=") + len("start_time=")
    data[info : info + 8] = struct.pack("<II", 4_000_000_000, 0)
    path.write_bytes(data)
    return path


def lie_of_content(path: Path) -> Path:
    """Let the first chunk claim to hold more than it does."""
    data = bytearray(path.read_bytes())
    place = data.index(b"size=") + len("size=")
    data[place : place + 4] = struct.pack("<I", 90_000)
    path.write_bytes(data)
    return path


PLAY = """
import sys
from pyros1.cli.running import run_command
for path in sys.argv[1:]:
    print(path, run_command("bag", ["play", "-d", "0", "--immediate", "--quiet", path]), file=sys.stderr)
"""


@pytest.mark.slow
def test_play_names_a_damaged_bag_and_ends(tmp_path: Path, environ: dict[str, str]) -> None:
    bags = damaged_bags(tmp_path)
    bags["times"] = swap_times(write_bag(tmp_path / "times.bag"))
    bags["content"] = lie_of_content(write_bag(tmp_path / "content.bag"))
    source = str(Path(pyros1.__file__).parents[1])
    done = subprocess.run(
        [sys.executable, "-c", PLAY, *map(str, bags.values())],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env={**os.environ, **environ, "PYTHONPATH": source},
    )
    said = iter(done.stderr.splitlines())
    for kind, path in bags.items():
        line = next(said)
        assert line.startswith("ERROR ") and f" {path}: " in line and "--start" not in line, (kind, line)
        assert next(said) == f"{path} 1"
    assert not list(said)


def test_echo_scans_a_bag_whose_index_is_damaged(tmp_path: Path, call_main: Any) -> None:
    code, out, err = call_main(topic, "echo", "-b", swap_times(write_bag(tmp_path / "x.bag")), "/a")
    assert (code, out.count("---"), err) == (0, 50, "")


def test_echo_names_the_bag_in_which_a_message_cannot_be_shown(tmp_path: Path, call_main: Any) -> None:
    path = write_bag(tmp_path / "x.bag", count=1)
    path.write_bytes(
        path.read_bytes().replace(b"da5909fbe378aeaf85e547e830cc1bb7", b"0" * 32).replace(b"int32 data", b"int64 data")
    )
    code, _, err = call_main(topic, "echo", "-b", path, "/a")
    assert code == 1
    assert err.startswith(f"ERROR: {path}: at 100.000000: a message of type [std_msgs/Int32] on /a cannot be printed: ")


def test_a_byte_too_many_before_a_chunk_costs_nothing_else(make_bag: Make) -> None:
    path = make_bag()
    with BagReader(path) as bag:
        place = bag.chunks[2].pos
    whole = path.read_bytes()
    path.write_bytes(whole[:place] + b"x" + whole[place:])
    with path.open("rb") as file:
        scanner = Scanner(BagFile(file))
        assert sum(len(chunk.messages) for chunk in scanner.chunks()) == 100
    assert [damage.offset for damage in scanner.damaged_places] == [place]
