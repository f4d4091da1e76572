"""bag filter, compress, reindex, merge, split, rename-topic, retime and info, as commands (L114-L116, L141-L143)."""

from __future__ import annotations

import errno
import json
import os
import signal
import stat
from collections.abc import Callable
from functools import partial
from io import FileIO
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1.bag.format import writer
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import BAG_HEADER_SIZE
from pyros1.cli.running import run_command
from pyros1.ground.timing import Duration

from ..conftest import Make, values

Run = Callable[..., tuple[int, str, str]]
BEGIN = 13 + 8 + BAG_HEADER_SIZE
"""Where the first chunk begins."""


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, call_main: Any, tmp_path: Path) -> Run:
    monkeypatch.chdir(tmp_path)
    return partial(call_main, partial(run_command, "bag"))


def headers(path: Path | str) -> list[tuple[str, dict[str, bytes]]]:
    with BagReader(path) as bag:
        return sorted((connection.topic, dict(connection.header)) for connection in bag.connections.values())


def test_info_l115(run: Run, make_bag: Make) -> None:
    make_bag()
    code, out, _ = run("info", "--freq", "x.bag")
    lines = out.splitlines()
    assert code == 0
    assert lines[:3] == ["path:        x.bag", "version:     2.0", "duration:    1.0s"]
    assert lines[-2:] == [
        "topics:      /a   50 msgs @ 50.0 Hz : std_msgs/Int32 ",
        "             /b   50 msgs @ 50.0 Hz : std_msgs/String",
    ]


def test_info_yaml_and_keys_l116(run: Run, make_bag: Make) -> None:
    make_bag(compression="bz2")
    assert run("info", "-y", "-k", "messages", "x.bag")[1] == "100\n"
    assert run("info", "-y", "-k", "topics[1].type", "x.bag")[1] == "std_msgs/String\n"
    assert run("info", "-y", "-k", "duration", "x.bag")[1] == "0.99\n"
    assert run("info", "-y", "-k", "__class__", "x.bag")[2] == 'Error getting key "__class__"\n'
    assert run("info", "-k", "messages", "x.bag")[0] == 2
    assert "compression: bz2\nuncompressed: " in run("info", "-y", "x.bag")[1]
    assert json.loads(run("info", "--json", "x.bag")[1])["topics"][0]["topic"] == "/a"


def test_info_of_what_cannot_be_read_l114(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag(close=False)
    code, out, err = run("info", "x.bag")
    assert (code, out) == (1, "")
    assert err.startswith("ERROR bag unindexed: x.bag: ") and "pyros1 bag reindex" in err
    assert run("info", "nope.bag") == (1, "", "ERROR reading nope.bag: No such file or directory\n")
    assert run("info", tmp_path)[2] == f"ERROR reading {tmp_path}: Is a directory\n"
    (tmp_path / "empty.bag").touch()
    assert "the file is empty" in run("info", "empty.bag")[2]
    assert run("info")[0] == 2


def test_compress_keeps_a_backup_and_every_header_l142(run: Run, make_bag: Make, tmp_path: Path) -> None:
    path = make_bag()
    before = headers(path)
    assert run("compress", "x.bag")[0] == 0
    assert headers(path) == before
    assert values(path) == values(tmp_path / "x.orig.bag") == list(range(100))
    with BagReader(path) as bag:
        assert bag.header(bag.chunks[0]).compression == "bz2"
    assert run("compress", "--lz4", "x.bag")[2] == "Skipping x.bag. Backup path x.orig.bag already exists.\n"
    assert run("decompress", "-f", "-q", "x.bag") == (0, "", "")
    assert values(path) == list(range(100))
    assert run("compress", "nope.bag")[0] == 1
    (tmp_path / "out").mkdir()
    assert run("compress", "--lz4", "--output-dir", "out", "x.bag")[0] == 0
    assert values(tmp_path / "out" / "x.bag") == list(range(100))
    assert "same file" in run("compress", "--output-dir", ".", "x.bag")[2]
    assert not list(tmp_path.glob("*.tmp"))


def test_reindex_leaves_a_file_alone_that_it_cannot_read_l143(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag(name="x.bag.active", close=False)
    assert run("reindex", "x.bag.active") == (0, "x.bag.active: 100 messages\n", "")
    assert values(tmp_path / "x.bag.active", unindexed=False) == list(range(100))
    assert (tmp_path / "x.bag.orig.active").exists()
    (tmp_path / "text.bag").write_text("hello")
    assert run("reindex", "text.bag")[0] == 1
    assert sorted(path.name for path in tmp_path.glob("text*")) == ["text.bag"]


def test_filter_l141(run: Run, make_bag: Make, tmp_path: Path) -> None:
    path = make_bag()
    assert run("filter", "x.bag", "y.bag", "topic == '/a' and m.data > 90")[:2] == (0, "y.bag: 4 of 100 messages\n")
    assert values(tmp_path / "y.bag") == [92, 94, 96, 98]
    assert headers("y.bag") == [header for header in headers(path) if header[0] == "/a"]
    _, out, _ = run("filter", "-p", "m.data", "x.bag", "y.bag", "t.to_sec() < 100.015")
    assert out.splitlines()[:3] == ["MATCH 0", "MATCH 1", "NO MATCH 2"]
    assert run("filter", "x.bag", "y.bag", "--topics", "/b", "--from", "0.5", "--to", "@100.57")[0] == 0
    assert values(tmp_path / "y.bag") == [51, 53, 55, 57]
    assert run("filter", "x.bag", "y.bag", "--drop-connections", "/talker", "--from", "-0.05")[0] == 0
    assert values(tmp_path / "y.bag") == [95, 97, 99]


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["x.bag"], 2, "an out bag and an expression"),
        (["x.bag", "y.bag"], 2, "must specify an expression"),
        (["nope.bag", "y.bag", "True"], 2, "Cannot locate input bag file [nope.bag]"),
        (["x.bag", "./x.bag", "True"], 3, "Cannot use same file"),
        (["x.bag", "y.bag", "m.nope == 1"], 1, "/a at 100.000000 (std_msgs/Int32)"),
        (["x.bag", "y.bag", "__import__('os')"], 1, "unknown function __import__"),
        (["x.bag", "y.bag", "m.__class__"], 1, "not accessible"),
        (["x.bag", "y.bag", "topic ="], 1, "not an expression"),
        (["x.bag", "y.bag", "--from", "yesterday"], 2, "'yesterday' is not a time"),
        (["x.bag", "nodir/y.bag", "True"], 1, "No such file or directory"),
    ],
)
def test_filter_refuses(run: Run, make_bag: Make, tmp_path: Path, words: list[str], code: int, text: str) -> None:
    make_bag()
    result = run("filter", *words)
    assert (result[0], text in result[2]) == (code, True), result
    assert [path.name for path in tmp_path.iterdir()] == ["x.bag"]


@pytest.mark.slow
def test_filter_names_the_message_and_what_is_wrong(run: Run, make_bag: Make) -> None:
    make_bag("x.bag")
    _, _, err = run("filter", "x.bag", "y.bag", "x > 1")
    assert "unknown name 'x'; known names: m, t, topic (in the message on /" in err and "come first" not in err
    _, _, err = run("filter", "x.bag", "y.bag", "m.nope > 1")
    assert "has no attribute 'nope' (in the message on /" in err and err.endswith("need to come first?\n")
    for text, reason in (
        ("'x' * 10 ** 7", "too large; use fewer fields, items or characters"),
        ("[x for x in range(10 ** 6) for y in range(10)]", "too much work; use fewer fields or items"),
    ):
        _, _, err = run("filter", "x.bag", "y.bag", text)
        assert reason in err and "come first" not in err


def test_filter_of_misspelt_names(run: Run, make_bag: Make) -> None:
    make_bag("x.bag")
    code, out, err = run("filter", "x.bag", "y.bag", "--topics", "/a,/aa", "--drop-connections", "nobody")
    assert (code, out) == (0, "y.bag: 50 of 100 messages\n")
    first, second = err.splitlines()
    assert first.startswith("WARNING: /aa is not in the bag (did you mean '/a'")
    assert second == "WARNING: the bag has no connection from nobody"
    code, _, err = run("filter", "x.bag", "y.bag", "--from", "2", "--to", "1")
    assert (code, "--from 2 is later than --to 1" in err) == (2, True)


def test_merge(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag("x.bag")
    run("filter", "x.bag", "a.bag", "topic == '/a'")
    run("filter", "x.bag", "b.bag", "topic == '/b'")
    assert run("merge", "m.bag", "b.bag", "a.bag")[:2] == (0, "m.bag: 100 messages\n")
    assert values(tmp_path / "m.bag") == list(range(100))
    assert headers("m.bag") == headers("x.bag")
    assert run("merge", "twice.bag", "x.bag", "a.bag")[0] == 0
    assert headers("twice.bag") == headers("x.bag")  # equal connections become one
    assert run("merge", "x.bag", "x.bag")[0] == 1
    assert run("merge", "new.bag")[0] == 2


def test_split(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag()
    assert run("split", "x.bag", "--duration", "0.4")[1].split() == ["x_0.bag", "x_1.bag", "x_2.bag"]
    assert [len(values(tmp_path / f"x_{i}.bag")) for i in range(3)] == [40, 40, 20]
    code, out, err = run("split", "x.bag", "--count", "30", "--repeat-latched")
    assert (code, out) == (1, "") and "x_0.bag already exists: use --force" in err
    assert run("split", "x.bag", "--count", "30", "--repeat-latched", "--force")[0] == 0
    assert values(tmp_path / "x_1.bag")[:3] == [28, 30, 31]
    with pyros1.bag.open("x_1.bag") as bag:
        assert bag.start == next(iter(bag.messages("/b"))).time - Duration(0, 10_000_000)
    assert run("split", "x.bag")[0] == 2
    assert run("split", "x.bag", "--count", "0")[0] == 2


def test_rename_topic(run: Run, make_bag: Make) -> None:
    make_bag()
    assert run("rename-topic", "x.bag", "y.bag", "/a", "/ns/c")[0] == 0
    assert [(topic, header["topic"]) for topic, header in headers("y.bag")] == [("/b", b"/b"), ("/ns/c", b"/ns/c")]
    assert run("rename-topic", "y.bag", "z.bag", "/ns/", "/")[0] == 0
    assert [topic for topic, _ in headers("z.bag")] == ["/b", "/c"]
    assert run("rename-topic", "x.bag", "q.bag", "/a", "not legal")[0] == 1
    code, _, err = run("rename-topic", "x.bag", "q.bag", "/aa", "/c")
    assert (code, "has no topic /aa" in err) == (1, True)


def test_retime(run: Run, make_bag: Make) -> None:
    make_bag()
    assert run("retime", "x.bag", "y.bag", "--offset", "-99.5")[0] == 0
    with pyros1.bag.open("y.bag") as bag:
        assert (bag.start.to_nsec(), bag.end.to_nsec()) == (500_000_000, 1_490_000_000)
    assert run("retime", "x.bag", "y.bag", "--start", "@1000000000", "--rate", "2")[0] == 0
    with pyros1.bag.open("y.bag") as bag:
        assert (bag.start.to_nsec(), bag.end.to_nsec()) == (10**18, 10**18 + 495_000_000)
    assert "cannot be stored" in run("retime", "x.bag", "z.bag", "--offset", "-200")[2]
    assert run("retime", "x.bag", "z.bag", "--rate", "0")[0] == 2
    assert "You must specify --offset" in run("retime", "x.bag", "z.bag")[2]


def test_usage(run: Run) -> None:
    assert run()[0] == 0
    assert "reindex" in run("help")[1]
    assert "--output-dir" in run("help", "compress")[1]
    assert run("reindx")[0] == 64


@pytest.mark.parametrize(
    "words",
    [
        ["compress", "x.bag"],
        ["filter", "x.bag", "new.bag", "True"],
        ["merge", "new.bag", "x.bag"],
        ["retime", "x.bag", "new.bag", "--offset", "1"],
        ["rename-topic", "x.bag", "new.bag", "/a", "/c"],
        ["reindex", "x.bag"],
        ["split", "x.bag", "--count", "1000"],
    ],
    ids=lambda words: str(words[0]),
)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda number: str(number.name))
def test_a_signal_in_the_middle_leaves_nothing_half(
    run: Run, make_bag: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], number: signal.Signals
) -> None:
    """Feature: a signal or a full disk while writing -- leaves no incomplete file"""
    path = make_bag()
    before = path.read_bytes()

    class Interrupted(FileIO):
        def write(self, data: Any) -> int:
            count = super().write(data)
            if self.tell() > BEGIN:
                signal.raise_signal(number)
            return count

    monkeypatch.setattr(writer, "FileIO", Interrupted)
    code, _, err = run(*words)
    assert code == 128 + number and "interrupted" in err
    assert [file.name for file in tmp_path.iterdir()] == ["x.bag"] and path.read_bytes() == before
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_a_full_disk_leaves_nothing_half(
    run: Run, make_bag: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_bag()

    class Full(FileIO):
        def write(self, data: Any) -> int:
            if self.tell() + len(data) > BEGIN:
                raise OSError(errno.ENOSPC, "No space left on device")
            return super().write(data)

    monkeypatch.setattr(writer, "FileIO", Full)
    for words in (["compress", "x.bag"], ["merge", "new.bag", "x.bag"], ["split", "x.bag", "--count", "9"]):
        code, out, err = run(*words)
        assert (code, out) == (1, "") and "No space left" in err
        assert [file.name for file in tmp_path.iterdir()] == ["x.bag"]


def test_a_folder_in_the_place_of_a_file(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag()
    (tmp_path / "folder").mkdir()
    for words in (["merge", "folder", "x.bag"], ["filter", "x.bag", "folder", "True"], ["info", "folder"]):
        code, out, err = run(*words)
        assert (code, out) == (1, "") and "Is a directory" in err
    assert {file.name for file in tmp_path.iterdir()} == {"x.bag", "folder"}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
@pytest.mark.parametrize(
    "words",
    [
        ["merge", "pipe", "x.bag"],
        ["filter", "x.bag", "pipe", "True"],
        ["export", "x.bag", "--format", "csv", "-f", "-o", "pipe"],
    ],
)
def test_a_pipe_or_device_is_not_replaced(run: Run, make_bag: Make, tmp_path: Path, words: list[str]) -> None:
    """For root, /dev/null would become a bag, and the machine useless."""
    make_bag()
    os.mkfifo(tmp_path / "pipe")
    code, out, err = run(*words)
    assert (code, out) == (1, "") and "pipe is a device or a pipe: give the name of a file" in err
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    assert {file.name for file in tmp_path.iterdir()} == {"x.bag", "pipe"}


def test_a_link_is_kept(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag()
    (tmp_path / "folder").mkdir()
    (tmp_path / "link.bag").symlink_to(Path("folder", "new.bag"))
    assert run("merge", "link.bag", "x.bag")[:2] == (0, "link.bag: 100 messages\n")
    assert (tmp_path / "link.bag").is_symlink()
    assert [file.name for file in (tmp_path / "folder").iterdir()] == ["new.bag"]


def test_split_into_nothing(run: Run, make_bag: Make) -> None:
    make_bag(count=0)
    for limit in ("nan", "inf", "0"):
        code, _, err = run("split", "x.bag", "--size", limit)
        assert code == 2 and "greater than 0" in err
    code, out, err = run("split", "x.bag", "--count", "5")
    assert (code, out) == (0, "") and "nothing was written" in err
