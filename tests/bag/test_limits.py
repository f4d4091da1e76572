"""Small bags that claim to hold much: what is read of them costs no more memory than the limit promises.

Feature: small bags and MCAP files that claim to have huge contents -- at most 256 MiB of a chunk is read, using up to
    four times as much memory if its messages are small; `--chunk-limit` raises the limit
"""

from __future__ import annotations

import base64
import os
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import pytest

import pyros1.bag
from pyros1.bag.errors import BagError
from pyros1.bag.export import mcap
from pyros1.bag.format.compression import compress
from pyros1.bag.format.contents import read_content
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import (
    MAGIC_20,
    MAX_CONNECTIONS,
    NS_PER_S,
    U32,
    U64,
    Connection,
    RecordError,
    make_bag_header,
    make_connection_record,
    make_record,
    pack_time,
)
from pyros1.bag.limits import DEFAULT_CHUNK_LIMIT, chunk_limit
from pyros1.ground.errors import Error
from pyros1.master import Master

from .made import write_bag
from .old_bags import old_bag, text

pytestmark = pytest.mark.once

MIB = 1 << 20

BZ2_CONTENT = 1992294605
BZ2 = zlib.decompress(
    base64.b85decode(
        b"c-nJ{%CIzaj8qGbyimOGAOnL+b<3YmEDR4D_CMla*uVI`f&&8shXKRs3{_vXfXm8XJh!qnFgvR?Txwsz00K-}Gkq"
        b"M4G8ir}FuOKK9gPnb5o~38uGqu;h{4vF<7l>rbI(b=|4aJ4d#<kfz24;JnPcn=TW36wcQicZ-lbhOS?iDsqo6>j%"
        b"Vh_SRa%QeO?NbDb*-3uuCp?C>uXi%#n0aIPo1($KUOvLT=0XvJ2tHHWS6k)P-R*2bkRv3L9N5S*8H1Km;GtcX|We"
        b"y<O4FI9^#urxmuqY<NFvH769F^z+lke>*lmTbtPBB^ilay`BC{%`B8a%@}EwdH8J!Z>SX9(P=Kg7!>YMlifJlu2U"
        b"mzq>`9S_PR_b)tR4V_r26j"
    )
)
"""A connection and one message of 1.9 GB, compressed to 1600 bytes."""

CONNECTION = Connection(
    0,
    "/a",
    {
        "topic": b"/a",
        "type": b"std_msgs/String",
        "md5sum": b"992ce8a1687cec8c8bd883ec73ca41d1",
        "message_definition": b"string data\n",
    },
)

RUN = """
import resource, sys
import lz4.frame, bz2, optparse, json
from pyros1.bag import api, info
from pyros1.bag.edit import editing as edit
from pyros1.bag.play import player
from pyros1.bag.edit import reindex
from pyros1.bag.format import writer as container
from pyros1.cli import help, registry
from pyros1.cli.running import run_command
from pyros1.bag.export import mcap_writer
import pyros1.msgs.dynamic, pyros1.msgs.yamltext
for name in ("bag", "topic"):
    for verb in registry.verbs(name):
        registry.load_verb(name, verb)
used = next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmSize")) << 10
limit = used + (int(sys.argv[1]) << 20)
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
if sys.argv[2] == "api":
    import pyros1.bag
    try:
        with pyros1.bag.open(sys.argv[3]) as opened:
            print(sum(1 for message in opened.messages(raw=True)))
    except pyros1.bag.BagError as error:
        sys.exit(str(error))
else:
    sys.exit(run_command(sys.argv[2], sys.argv[3:]))
"""


def packed(path: Path, compression: str, stored: bytes, size: int, count: int) -> Path:
    """Write a bag of one chunk; `size` is what it claims to hold, in bytes, and `count` messages."""
    chunk = make_record({"op": b"\5", "compression": compression.encode(), "size": U32.pack(size)}, stored)
    begin = len(MAGIC_20) + 8 + 4096
    info = {"op": b"\6", "ver": U32.pack(1), "chunk_pos": U64.pack(begin), "count": U32.pack(1)}
    info |= {"start_time": pack_time(NS_PER_S), "end_time": pack_time(9 * NS_PER_S)}
    end = make_connection_record(CONNECTION) + make_record(info, struct.pack("<II", 0, count))
    path.write_bytes(MAGIC_20 + make_bag_header(begin + len(chunk), 1, 1) + chunk + end)
    return path


def run(room: int, *words: str, folder: Path, **environ: str) -> subprocess.CompletedProcess[str]:
    """Run a command with so many MiB of memory beside what it has once all is imported."""
    source = str(Path(pyros1.__file__).parents[1])
    return subprocess.run(
        [sys.executable, "-c", RUN, str(room), *words],
        capture_output=True,
        text=True,
        cwd=folder,
        timeout=60,
        check=False,
        env={**os.environ, "PYTHONPATH": source, "ROS_MASTER_URI": "http://127.0.0.1:9", **environ},
    )


@pytest.fixture(scope="module")
def bombs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bombs")
    packed(folder / "bz2.bag", "bz2", BZ2, BZ2_CONTENT, 1)
    packed(folder / "lies.bag", "bz2", BZ2, 10 * MIB, 1)
    head = BZ2_CONTENT.to_bytes(4, "little")
    message = make_record({"op": b"\2", "conn": U32.pack(0), "time": pack_time(NS_PER_S)})[:-4] + head
    packed(
        folder / "lz4.bag",
        "lz4",
        b"".join(compress("lz4", [make_connection_record(CONNECTION) + message + bytes(200 * MIB)])),
        1 << 31,
        1,
    )
    return folder


COMMANDS = [
    "bag info --freq",
    "bag filter {} out.bag True",
    "bag compress --output-dir .",
    "bag export --ros1 -o out.mcap",
    "bag export -o out.csv",
    "bag reindex --output-dir .",
    "bag split --count 1 --output-dir .",
    "topic echo -b {} /a",
    "topic list -b {} /",
    "api",
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "command"),
    [
        *(("bz2", command) for command in COMMANDS),
        *((name, command) for name in ("lz4", "lies") for command in ("api", "bag reindex --output-dir .")),
    ],
)
def test_a_chunk_that_claims_much_costs_little(bombs: Path, tmp_path: Path, command: str, name: str) -> None:
    path = bombs / f"{name}.bag"
    words = [word.replace("{}", str(path)) for word in command.split()]
    done = run(90, *words, *([] if "{}" in command else [str(path)]), folder=tmp_path, PYROS1_BAG_CHUNK_LIMIT="16")
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "MemoryError" not in done.stderr
    assert str(path) in done.stderr
    if name != "lies":
        assert "the limit is 16777216 (--chunk-limit MIB raises it" in done.stderr


@pytest.mark.slow
def test_play_too(bombs: Path, tmp_path: Path, master: Master) -> None:
    environ = {"ROS_MASTER_URI": master.uri, "ROS_HOSTNAME": "127.0.0.1", "ROS_HOME": str(tmp_path)}
    done = run(250, "bag", "play", "-d", "0", str(bombs / "bz2.bag"), folder=tmp_path, **environ)
    assert done.returncode == 1
    assert "--chunk-limit MIB raises it" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("command", ["api", "bag reindex --output-dir .", "bag info --freq"])
def test_many_small_messages_cost_four_times_the_content(tmp_path: Path, command: str) -> None:
    message = make_record({"op": b"\2", "conn": U32.pack(0), "time": pack_time(NS_PER_S)}, bytes(4))
    count = 8 * MIB // len(message)
    content = make_connection_record(CONNECTION) + message * count
    path = packed(tmp_path / "x.bag", "lz4", b"".join(compress("lz4", [content])), len(content), count)
    assert path.stat().st_size < MIB
    (tmp_path / "out").mkdir()
    done = run(40, *command.split(), str(path), folder=tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert str(count) in done.stdout


def test_chunks_that_overlap_are_dropped_and_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pyros1.bag.BagWriter(tmp_path / "x.bag", chunk_threshold=500) as writer:
        conn = writer.add_connection("/a", CONNECTION.header)
        for i in range(300):
            writer.write(conn, (i * 37 % 300) * NS_PER_S, struct.pack("<I", i * 37 % 300))
    monkeypatch.setattr("pyros1.bag.format.reader.MAX_OPEN_BYTES", 2000)
    with BagReader(tmp_path / "x.bag") as bag:
        assert len(bag.chunks) > 20
        assert [message.time // NS_PER_S for message in bag.messages()] == list(range(300))


@pytest.mark.slow
def test_the_limit_is_raised_by_option_variable_and_argument(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_bag(tmp_path / "x.bag", count=40_000, chunk_threshold=1 << 30)
    with BagReader(path) as bag:
        assert MIB < bag.header(bag.chunks[0]).size < 3 * MIB
    monkeypatch.setenv("PYROS1_BAG_CHUNK_LIMIT", "1")
    with BagReader(path) as bag, pytest.raises(BagError, match="--chunk-limit") as caught:
        list(bag.messages())
    assert "reindex" not in str(caught.value)  # which reads no more
    with BagReader(path, chunk_limit=3 * MIB) as bag:
        assert sum(1 for _ in bag.messages()) == 40_000
    with pyros1.bag.open(path, chunk_limit=3 * MIB) as opened:
        assert sum(1 for _ in opened.messages(raw=True)) == 40_000
    done = run(200, "bag", "info", "--freq", "--chunk-limit", "3", str(path), folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.slow
def test_limits_are_numbers(tmp_path: Path) -> None:
    assert chunk_limit({}) == chunk_limit({"PYROS1_BAG_CHUNK_LIMIT": ""}) == DEFAULT_CHUNK_LIMIT
    assert chunk_limit({"PYROS1_BAG_CHUNK_LIMIT": "512"}) == 512 * MIB
    for bad in ("0", "-1", "x", "1.5", "4096", "\u0663"):
        with pytest.raises(Error, match=r"PYROS1_BAG_CHUNK_LIMIT: .* is not a number of MiB"):
            chunk_limit({"PYROS1_BAG_CHUNK_LIMIT": bad})
    done = run(200, "bag", "info", "--chunk-limit", "many", "x.bag", folder=tmp_path)
    assert (done.returncode, "--chunk-limit: 'many' is not a number" in done.stderr) == (2, True)


def test_messages_outside_of_chunks_have_the_same_limit(tmp_path: Path) -> None:
    path = tmp_path / "old.bag"
    path.write_bytes(old_bag([text("/a", NS_PER_S, "x" * 2 * MIB), text("/a", 2 * NS_PER_S, "y")]))
    with BagReader(path, unindexed=True, chunk_limit=MIB) as bag:
        assert "--chunk-limit" in bag.damaged_places[0].reason
        assert [message.data[4:] for message in bag.messages()] == [b"y"]


@pytest.mark.slow
def test_an_mcap_file_costs_no_more_than_the_limit_either(tmp_path: Path) -> None:
    """It is of ROS 2, so that rosbags would read it: which unpacks chunks to whatever is in them."""
    stored = b"".join(compress("lz4", [bytes(500 * MIB)]))
    head = struct.pack("<QQQI", 0, 0, MIB, 0) + mcap.pack_string("lz4") + U64.pack(len(stored))
    parts = (mcap.MAGIC, mcap.pack_header("ros2", ""), mcap.pack_record(mcap.OP_CHUNK, head, stored))
    end = mcap.pack_record(mcap.OP_FOOTER, bytes(20)) + mcap.MAGIC
    (tmp_path / "x.mcap").write_bytes(b"".join(parts) + end)
    done = run(250, "bag", "import", str(tmp_path / "x.mcap"), folder=tmp_path)
    assert (done.returncode, "does not hold the 1048576 bytes" in done.stderr) == (1, True), done.stderr


@pytest.mark.slow
def test_there_is_an_end_to_connections() -> None:
    record = make_connection_record(CONNECTION)
    place = record.index(b"conn=") + 5
    content = b"".join(record[:place] + U32.pack(i) + record[place + 4 :] for i in range(MAX_CONNECTIONS + 1))
    with pytest.raises(RecordError, match="more than 65536 connections"):
        read_content(content)
    assert len(read_content(content, partial=True)[1]) == MAX_CONNECTIONS
    assert len(read_content(record * 1000)[1]) == 1
