"""MCAP files with ROS 1 messages: bag export --ros1, and bag import of what the MCAP tools write.

Feature: small bags and MCAP files that claim to have huge contents
Feature: MCAP files with ROS 1 messages, exported and imported unchanged -- `pyros1 bag export --ros1`, `pyros1 bag
    import`
"""

from __future__ import annotations

import os
import random
import struct
import sys
import zlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import lz4.frame
import pytest

import pyros1.bag
from pyros1.bag import BagWriter
from pyros1.bag.errors import BagError
from pyros1.bag.export import mcap, mcap_writer
from pyros1.bag.export.mcap_reader import McapReader
from pyros1.bag.format.reader import BagReader, RawMessage
from pyros1.bag.format.records import U32, U64, Connection
from pyros1.cli.running import run_command
from pyros1.msgs import load_message

from ...bodies import encode
from ..conftest import Make
from ..made import header_of

Run = Callable[..., tuple[int, str, str]]
STRING = load_message("std_msgs/String")
START = 10**18
CHUNK = struct.Struct("<QQQI")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, call_main: Any, tmp_path: Path) -> Run:
    monkeypatch.chdir(tmp_path)
    return partial(call_main, partial(run_command, "bag"))


def zstd() -> Any:
    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    return zstd


def content(path: Path) -> list[tuple[Any, ...]]:
    """All that a bag's messages are, by time."""
    with BagReader(path) as bag:
        found = []
        for m in bag.messages():
            header = {**m.connection.header, "topic": m.connection.topic.encode()}
            found.append((m.connection.topic, m.time, bytes(m.data), sorted(header.items())))
        return found


def text(word: str) -> bytes:
    return bytes(encode(STRING(data=word)))


def schema(
    number: int = 1, name: str = "std_msgs/String", encoding: str = "ros1msg", data: bytes = b"string data\n"
) -> bytes:
    return mcap.pack_schema(mcap.Schema(number, name, encoding, data))


def channel(number: int, topic: str, encoding: str = "ros1", kind: int = 1, **metadata: str) -> bytes:
    return mcap.pack_channel(mcap.Channel(number, kind, topic, encoding, metadata))


def message(number: int, index: int, data: bytes | None = None) -> bytes:
    time = START + index * 10**7
    body = text(f"m{index}") if data is None else data
    return mcap.pack_record(mcap.OP_MESSAGE, mcap.MESSAGE_HEADER.pack(number, index, time, time - 5), body)


def chunk(records: bytes, compression: str = "", size: int | None = None, crc: int | None = None) -> bytes:
    pack = {"": bytes, "lz4": lz4.frame.compress, "zstd": lambda data: zstd().compress(data)}
    stored = pack.get(compression, bytes)(records)
    fields = CHUNK.pack(0, 0, len(records) if size is None else size, zlib.crc32(records) if crc is None else crc)
    return mcap.pack_record(mcap.OP_CHUNK, fields, mcap.pack_string(compression), U64.pack(len(stored)), stored)


def write(path: Path, *records: bytes, profile: str = "ros1", end: bytes | None = None) -> Path:
    """A file without index: that is optional."""
    footer = mcap.pack_record(mcap.OP_FOOTER, bytes(20)) + mcap.MAGIC
    last = mcap.pack_record(mcap.OP_DATA_END, bytes(4)) + footer if end is None else end
    path.write_bytes(mcap.MAGIC + mcap.pack_header(profile, "a test") + b"".join(records) + last)
    return path


# Out and back -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("threshold", [500, 1 << 20])
def test_what_goes_to_mcap_comes_back_as_it_was(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, threshold: int
) -> None:
    monkeypatch.setattr(mcap_writer, "CHUNK_THRESHOLD", threshold)
    with BagWriter(tmp_path / "x.bag") as writer:
        latched = header_of(STRING, callerid="/p", latching="1", tcp_nodelay="0")
        conns = [
            writer.add_connection("/a", latched),
            writer.add_connection("/a", header_of(STRING, callerid="/q", latching="0")),
            writer.add_connection("b", header_of(load_message("std_msgs/Int32"))),
            # Nobody has to understand it: comments in Latin-1, a type that is not there, a topic as it was sent.
            writer.add_connection(
                "/odd",
                {
                    "type": b"no/Where",
                    "md5sum": b"*",
                    "message_definition": b"Gone x # 5 \xb0C\n",
                    "topic": b"/remapped",
                },
            ),
        ]
        for i in range(200):
            time = START + (i ^ 3)
            writer.write(conns[i % 4], time, bytes([i]) * 3 if i % 4 == 3 else text(str(i)))
        writer.write(conns[3], START + 1000, bytes(300_000))
    assert run("export", "x.bag", "-o", "x.mcap", "--ros1") == (0, "x.mcap: 201 messages of 3 topics\n", "")
    assert run("import", "x.mcap", "-o", "y.bag") == (0, "y.bag: 201 messages of 3 topics\n", "")
    assert content(tmp_path / "y.bag") == content(tmp_path / "x.bag")


def test_what_is_not_utf_8_does_not_spoil_the_file(run: Run, tmp_path: Path) -> None:
    with BagWriter(tmp_path / "x.bag") as writer:
        header = {**header_of(STRING), "callerid": b"/\xff"}
        writer.write(writer.add_connection("/\udcfe", header), 5, text("x"))
    assert run("export", "x.bag", "-o", "x.mcap", "--ros1")[0] == 0
    with McapReader(tmp_path / "x.mcap") as reader:
        assert [(found.topic, found.metadata["callerid"]) for found, _, _ in reader.messages()] == [("/?", "/?")]


def test_several_bags_and_a_choice_of_messages(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag("x.bag", count=6)
    make_bag("y.bag", count=6)
    words = ["export", "x.bag", "y.bag", "-o", "x.mcap", "--ros1", "--topics", "/b", "--to", "0.03"]
    assert run(*words) == (0, "x.mcap: 4 messages of 1 topic\n", "")
    with McapReader(tmp_path / "x.mcap") as reader:
        assert [(found.id, time) for found, time, _ in reader.messages()] == [
            (0, 100_010_000_000),
            (0, 100_010_000_000),
            (0, 100_030_000_000),
            (0, 100_030_000_000),
        ], "connections of which nothing tells one from another are one channel"


def test_the_index_leads_to_every_message(
    run: Run, make_bag: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As https://mcap.dev/spec says: from the footer to the summary, from there to the chunks and their messages."""
    monkeypatch.setattr(mcap_writer, "CHUNK_THRESHOLD", 500)
    make_bag(count=60)
    assert run("export", "x.bag", "-o", "x.mcap", "--ros1")[0] == 0
    data = (tmp_path / "x.mcap").read_bytes()
    assert data[: len(mcap.MAGIC)] == data[-len(mcap.MAGIC) :] == mcap.MAGIC
    footer = len(data) - len(mcap.MAGIC) - 29
    op, size, summary, offsets, crc = struct.unpack_from("<BQQQI", data, footer)
    assert (op, size, crc) == (mcap.OP_FOOTER, 20, zlib.crc32(data[summary : footer + 25]))
    groups = {}
    for op, part in mcap.iter_records(data[offsets:footer]):
        assert op == mcap.OP_SUMMARY_OFFSET
        kind, start, length = struct.unpack("<BQQ", part)
        groups[kind] = list(mcap.iter_records(data[start : start + length]))
        assert {op for op, _ in groups[kind]} == {kind}
    assert [mcap.parse_schema(part).name for _, part in groups[mcap.OP_SCHEMA]] == ["std_msgs/Int32", "std_msgs/String"]
    topics = {found.id: found.topic for _, part in groups[mcap.OP_CHANNEL] if (found := mcap.parse_channel(part))}
    assert topics == {0: "/a", 1: "/b"}
    begin, end = 100_000_000_000, 100_590_000_000
    ((_, statistics),) = groups[mcap.OP_STATISTICS]
    counts = struct.unpack_from("<QHIIIIQQ", statistics)
    assert counts == (60, 2, 2, 0, 0, len(groups[mcap.OP_CHUNK_INDEX]), begin, end)
    assert counts[5] > 2
    found = []
    for _, part in groups[mcap.OP_CHUNK_INDEX]:
        cursor = mcap.Cursor(part)
        first, last, start, length = (cursor.read_number(U64) for _ in range(4))
        indexes = mcap.Cursor(cursor.read_block())
        index_length, compression = cursor.read_number(U64), cursor.read_string()
        size, unpacked = cursor.read_number(U64), cursor.read_number(U64)
        ((op, whole),) = mcap.iter_records(data[start : start + length])
        assert (op, compression, size) == (mcap.OP_CHUNK, "", unpacked)
        assert CHUNK.unpack_from(whole)[:3] == (first, last, unpacked)
        records = bytes(whole[-unpacked:])
        covered = 0
        while indexes:
            number, place = indexes.read_number(mcap.U16), indexes.read_number(U64)
            op, length = mcap.RECORD_HEADER.unpack_from(data, place)
            covered += mcap.RECORD_HEADER.size + length
            inner = mcap.Cursor(data[place + mcap.RECORD_HEADER.size : place + mcap.RECORD_HEADER.size + length])
            assert (op, inner.read_number(mcap.U16)) == (mcap.OP_MESSAGE_INDEX, number)
            entries = mcap.Cursor(inner.read_block())
            while entries:
                time, offset = entries.read_number(U64), entries.read_number(U64)
                op, body = next(mcap.iter_records(records[offset:]))
                fields = mcap.MESSAGE_HEADER.unpack_from(body)
                assert (op, fields[0], fields[2]) == (mcap.OP_MESSAGE, number, time) and first <= time <= last
                found.append((topics[number], fields[1], time, bytes(body[mcap.MESSAGE_HEADER.size :])))
        assert covered == index_length
    with BagReader(tmp_path / "x.bag") as bag:
        stored = [(m.connection.topic, i // 2, m.time, bytes(m.data)) for i, m in enumerate(bag.messages())]
    assert sorted(found, key=lambda each: each[2]) == stored


# What others write ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("compression", [None, "", "lz4", "zstd"])
@pytest.mark.parametrize("profile", ["ros1", ""])
def test_files_of_others_are_imported(run: Run, tmp_path: Path, compression: str | None, profile: str) -> None:
    """In chunks or not, with types and channels repeated in each, and what nobody asked for in between."""
    known = schema() + channel(7, "/a", callerid="/p", latching="true", md5sum=STRING._md5sum) + channel(9, "/b")
    records = [known + b"".join(message(7 + 2 * (i % 2), 10 * n + i) for i in range(10)) for n in range(3)]
    between = mcap.pack_record(0x09, bytes(3000)) + mcap.pack_record(0x0C, b"metadata") + mcap.pack_record(0x93, b"own")
    parts = [(part if compression is None else chunk(part, compression)) + between for part in records]
    write(tmp_path / "x.mcap", *parts, profile=profile)
    assert run("import", "x.mcap") == (0, "x.bag: 30 messages of 2 topics\n", "")
    with pyros1.bag.open(tmp_path / "x.bag") as bag:
        assert [(m.topic, m.time.to_nsec(), m.message.data) for m in bag.messages()] == [
            (("/a", "/b")[i % 2], START + i * 10**7, f"m{i}") for i in range(30)
        ]
        a, b = bag.connections
    assert (a.type, a.md5sum, a.definition) == ("std_msgs/String", STRING._md5sum, "string data\n")
    assert (a.callerid, a.latching) == ("/p", True)
    assert (b.md5sum, b.callerid, b.latching) == (STRING._md5sum, "", False), "calculated, as nobody said it"


def test_compressed_data_may_be_in_several_frames(tmp_path: Path) -> None:
    parts = [schema() + channel(1, "/a"), message(1, 0) + message(1, 1)]
    stored = b"".join(zstd().compress(part) for part in parts)
    fields = CHUNK.pack(0, 0, sum(map(len, parts)), 0)
    record = mcap.pack_record(mcap.OP_CHUNK, fields, mcap.pack_string("zstd"), U64.pack(len(stored)), stored)
    with McapReader(write(tmp_path / "x.mcap", record)) as reader:
        assert [time - START for _, time, _ in reader.messages()] == [0, 10**7]


@pytest.mark.parametrize("compression", ["", "lz4", "zstd"])
def test_chunks_that_are_decompressed_in_several_pieces(tmp_path: Path, compression: str) -> None:
    """Of random bytes, which stay as large, and of zeros, which become small."""
    bodies = [text("x"), random.Random(1).randbytes(1_500_000), bytes(3_000_000), text("y")]
    records = [message(1, index, body) for index, body in enumerate(bodies)]
    large = chunk(b"".join([schema(), channel(1, "/a"), *records]), compression)
    with McapReader(write(tmp_path / "x.mcap", large)) as reader:
        assert [bytes(body) for _, _, body in reader.messages()] == bodies
        reader.check()


def test_what_is_not_ros_1_is_left_out_and_named(run: Run, tmp_path: Path) -> None:
    parts = [
        schema(),
        channel(1, "/a", **{"md5sum": "?", "no name": "x", "ö": "x", "a=b": "x", "my-field": "y", "latching": "1"}),
    ]
    parts += [channel(2, "/json", "json", 0), channel(3, "/none", kind=0)]
    parts += [schema(2, "p/Idl", "ros2idl"), channel(4, "/idl", kind=2), channel(8, "/quiet")]
    parts += [schema(4, "std_msgs/msg/String"), channel(9, "/ros2", kind=4)]
    parts += [schema(3, "p/Wrong", data=b"Nowhere x"), channel(5, "/wrong", kind=3)]
    write(tmp_path / "x.mcap", *parts, *(message(n, n) for n in (1, 2, 3, 4, 9, 5, 1)), profile="")
    code, out, err = run("import", "x.mcap")
    assert (code, out) == (0, "x.bag: 2 messages of 2 topics\n")
    assert err.splitlines()[:4] == [
        "WARNING: /json is left out: its messages are encoded as 'json', not 'ros1'",
        "WARNING: /none is left out: the definition of its type is missing",
        "WARNING: /idl is left out: the definition of p/Idl is encoded as 'ros2idl', not 'ros1msg'",
        "WARNING: /ros2 is left out: 'std_msgs/msg/String' is not a ROS 1 type name",
    ]
    assert err.splitlines()[4].startswith("WARNING: /wrong is left out: the definition of its type is wrong: ")
    with pyros1.bag.open(tmp_path / "x.bag") as bag:
        assert bag.topics == {"/a": "std_msgs/String", "/quiet": "std_msgs/String"}
        assert bag.connections[0].latching and bag.connections[0].header["my-field"] == b"y"
        assert not {"no name", "ö", "a=b", "a"} & bag.connections[0].header.keys()
    write(tmp_path / "y.mcap", channel(2, "/json", "json", 0), message(2, 0), profile="")
    code, _, err = run("import", "y.mcap")
    assert (code, "no ROS 1 messages that can be imported: /json: its messages" in err) == (1, True), err
    assert not (tmp_path / "y.bag").exists()


def test_topics_are_chosen(run: Run, tmp_path: Path) -> None:
    write(tmp_path / "x.mcap", schema(), channel(1, "/scan"), channel(2, "/b"), message(1, 0), message(2, 1))
    assert run("import", "x.mcap", "--topics", "/b", "--lz4", "-q") == (0, "", "")
    with pyros1.bag.open(tmp_path / "x.bag") as bag:
        assert bag.topics == {"/b": "std_msgs/String"}
    code, _, err = run("import", "x.mcap", "--topics", "/scam", "-o", "y.bag")
    assert (code, "no topic /scam in x.mcap (did you mean '/scan'?)" in err) == (1, True), err
    assert not (tmp_path / "y.bag").exists()


# What is wrong ----------------------------------------------------------------------------------------------------

KNOWN = schema() + channel(1, "/a")
FINE = KNOWN + message(1, 0)


@pytest.mark.parametrize(
    ("records", "words"),
    [
        (message(1, 0), "channel 1, which is not defined"),
        (KNOWN + mcap.pack_record(mcap.OP_MESSAGE, b"short"), "a message's record is too short"),
        (KNOWN + channel(1, "/b"), "channel 1 is defined twice, with different contents"),
        (KNOWN + schema(name="std_msgs/Int8"), "type 1 is defined twice, with different contents"),
        (mcap.pack_record(mcap.OP_SCHEMA, b"\1\0" + U32.pack(1 << 30)), "runs past its end"),
        (mcap.RECORD_HEADER.pack(mcap.OP_MESSAGE, 1 << 60), "cut off or damaged; `mcap recover`"),
        (bytes(100), "this is not a record: the file is cut off or damaged"),
        (chunk(chunk(FINE)), "a chunk contains another chunk"),
        (chunk(FINE, crc=5), "its checksum is wrong"),
        (chunk(FINE, size=len(FINE) + 1), "does not hold the"),
        (chunk(FINE, "zstd", size=len(FINE) - 1), "does not hold the"),
        (chunk(FINE, "lz4", size=1 << 40), "claims to hold 1099511627776 bytes"),
        (chunk(FINE, "snappy"), "the chunk's compression 'snappy' is unknown; lz4 and zstd are supported"),
        (chunk(FINE, "zstd").replace(b"\x28\xb5\x2f\xfd", b"abcd"), "the chunk's zstd data are damaged"),
        (chunk(FINE, "lz4").replace(b"\x04\x22\x4d\x18", b"abcd"), "the chunk's lz4 data are damaged"),
        (chunk(FINE[:-3]), "runs past its end"),
        (
            FINE + mcap.pack_record(mcap.OP_MESSAGE, mcap.MESSAGE_HEADER.pack(1, 0, 1 << 63, 0)),
            "bags can store 0 to 2^32 s",
        ),
    ],
)
def test_what_is_damaged_is_named_and_leaves_nothing(run: Run, tmp_path: Path, records: bytes, words: str) -> None:
    write(tmp_path / "x.mcap", records)
    code, out, err = run("import", "x.mcap", "-o", "y.bag")
    assert (code, out, len(err.splitlines())) == (1, "", 1)
    assert words in err, err
    assert [path.name for path in tmp_path.iterdir()] == ["x.mcap"]


def entry(offset: int, record: bytes, **lies: Any) -> bytes:
    """The index record of a chunk without messages that is not compressed."""
    size = len(record) - 49
    facts = mcap.ChunkIndex(0, 0, offset, len(record), "", size, size)._replace(**lies)
    numbers = [U64.pack(number) for number in (*facts[:4], 0, facts.stored_size, facts.size)]
    return mcap.pack_record(
        mcap.OP_CHUNK_INDEX, *numbers[:4], U32.pack(0), numbers[4], mcap.pack_string(facts.compression), *numbers[5:]
    )


BEGIN = len(mcap.MAGIC + mcap.pack_header("ros2", "a test"))
SMALL, BIG = chunk(KNOWN), chunk(bytes(630_000))


@pytest.mark.parametrize(
    ("records", "index", "words"),
    [
        ([chunk(bytes(2 << 20))], [], "claims to hold 2097192 bytes"),
        ([chunk(bytes(2 << 20), "zstd", size=100, crc=0)], [], "does not hold the 100 bytes"),
        ([chunk(bytes(2 << 20), "lz4", size=100, crc=0)], [], "does not hold the 100 bytes"),
        ([mcap.RECORD_HEADER.pack(mcap.OP_MESSAGE, 1 << 60)], [], "runs past the end"),
        ([SMALL], [entry(BEGIN, SMALL, size=1 << 40)], f"is wrong about the chunk at byte {BEGIN}"),
        ([SMALL], [entry(BEGIN, SMALL, stored_size=1 << 60)], "is wrong about"),
        ([SMALL], [entry(BEGIN, SMALL, compression="zstd")], "is wrong about"),
        ([SMALL], [entry(BEGIN + 9, SMALL)], "is wrong about"),
        ([SMALL], [entry(BEGIN, SMALL)] * 2, "lists a chunk twice"),
        ([BIG, BIG], [entry(BEGIN, BIG), entry(BEGIN + len(BIG), BIG)], "hold 1260000 bytes"),
        (
            [SMALL, mcap.pack_record(mcap.OP_FOOTER, U64.pack(BEGIN), bytes(12))],
            [],
            "not where the footer says",
        ),
    ],
)
def test_what_lies_is_refused_before_rosbags_believes_it(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, records: list[bytes], index: list[bytes], words: str
) -> None:
    monkeypatch.setenv("PYROS1_BAG_CHUNK_LIMIT", "1")
    start = BEGIN + len(b"".join(records)) + 13
    footer = mcap.pack_record(mcap.OP_FOOTER, U64.pack(start), bytes(12)) + mcap.MAGIC
    end = b"".join((mcap.pack_record(mcap.OP_DATA_END, bytes(4)), *index, footer))
    write(tmp_path / "x.mcap", *records, profile="ros2", end=end)
    code, _, err = run("import", "x.mcap", "-o", "y.bag")
    assert (code, len(err.splitlines())) == (1, 1), err
    assert words in err and "rosbags" not in err, err


def test_files_that_are_no_mcap(run: Run, tmp_path: Path) -> None:
    for data, words in [
        (b"", "x.mcap: the file is empty"),
        (b"#ROSBAG V2.0\n", "x.mcap: this is not an MCAP file"),
        (mcap.MAGIC, "x.mcap: at byte 8: the file is cut off"),
        (mcap.MAGIC + mcap.pack_record(mcap.OP_FOOTER, bytes(20)), "x.mcap: at byte 8: the file has no header"),
        (mcap.MAGIC + mcap.pack_record(mcap.OP_HEADER, b"\5"), "x.mcap: at byte 8: a field of the record runs past"),
    ]:
        (tmp_path / "x.mcap").write_bytes(data)
        code, _, err = run("import", "x.mcap", "-o", "y.bag")
        assert (code, words in err) == (1, True), err


def test_a_pipe_is_refused(run: Run, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "x.mcap")  # nobody writes into it
    code, _, err = run("import", "x.mcap", "-o", "y.bag")
    assert (code, "x.mcap: this is a pipe" in err) == (1, True), err


@pytest.mark.parametrize("compression", ["", "lz4", "zstd"])
def test_no_damage_is_worse_than_an_error(tmp_path: Path, compression: str) -> None:
    """A file cut off anywhere before the end of its data, and one with any byte changed."""
    path = write(tmp_path / "x.mcap", chunk(FINE, compression), FINE, end=b"")
    whole = path.read_bytes() + mcap.pack_record(mcap.OP_DATA_END, bytes(4))
    for end in range(len(whole) - mcap.RECORD_HEADER.size - 4):
        path.write_bytes(whole[:end])
        with pytest.raises(BagError), McapReader(path) as reader:
            list(reader.messages())
    for place in range(len(whole)):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x55]) + whole[place + 1 :])
        try:
            with McapReader(path) as reader:
                assert len(list(reader.messages())) <= 2
        except BagError as error:
            assert "x.mcap: " in str(error)


@pytest.mark.parametrize(("compression", "package"), [("lz4", "lz4"), ("zstd", "backports.zstd")])
def test_a_module_that_is_missing_is_named(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compression: str, package: str
) -> None:
    write(tmp_path / "x.mcap", chunk(FINE, compression))
    for name in ("compression.zstd", "backports.zstd", "lz4.frame"):
        monkeypatch.setitem(sys.modules, name, None)
    code, _, err = run("import", "x.mcap", "-o", "y.bag")
    assert code == 1 and f"x.mcap: it is compressed with {compression}; to read it: pip install {package}\n" in err


def test_there_is_an_end_to_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mcap_writer, "MAX_ID", 2)
    writer = mcap_writer.Ros1McapWriter(tmp_path / "x.mcap")
    for number, topic in enumerate(["/a", "/b", "/c"]):
        stored = RawMessage(Connection(number, topic, header_of(STRING)), 5, text(topic))
        if number < 2:
            writer.write_raw(stored)
        else:
            with pytest.raises(BagError, match=r"x\.mcap: an MCAP file can hold at most 2 connections and types"):
                writer.write_raw(stored)
    writer.abort()


def test_usage(run: Run, make_bag: Make) -> None:
    make_bag(count=2)
    code, _, err = run("export", "x.bag", "--format", "csv", "--ros1")
    assert (code, "--ros1 needs --format mcap, not csv" in err) == (2, True)
    assert "--ros1" in run("export", "-h")[1]
