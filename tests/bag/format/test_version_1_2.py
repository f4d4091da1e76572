"""Bags of version 1.2, as the recorders of that time made them.

Feature: bags of version 1.2 -- `info`, `play`, `reindex` and all other commands
"""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

import pyros1.bag
from pyros1.bag.edit.reindex import reindex
from pyros1.bag.errors import UnindexedError
from pyros1.bag.format.reader import BagReader
from pyros1.cli.running import run_command

from ..conftest import values
from ..made import old_messages, write_bag
from ..old_bags import Old, number, old_bag, text

NS = 1_000_000_000


def make(folder: Path, messages: list[Old], *, indexed: bool = True, closed: bool = True) -> Path:
    path = folder / "old.bag"
    path.write_bytes(old_bag(messages, indexed=indexed, closed=closed))
    return path


@pytest.mark.parametrize("indexed", [True, False])
def test_it_is_read_without_reindexing_b01(tmp_path: Path, indexed: bool) -> None:
    path = make(tmp_path, old_messages(), indexed=indexed)
    assert values(path, unindexed=False) == list(range(12))
    with pyros1.bag.open(path, unindexed=False) as bag:
        summary = bag.summary()
        assert summary.version == ("1.2" if indexed else "1.2 (unindexed)")
        assert (summary.messages, summary.start, summary.end, summary.storage) == (12, 100.0, 100.11, {})
        assert bag.topics == {"/a": "std_msgs/Int32", "/b": "std_msgs/String"}


@pytest.mark.parametrize("first_line", [b"#ROSBAG V1.2\n", b"#ROSRECORD V1.2\r\n"])
def test_the_word_in_the_first_line_does_not_matter(tmp_path: Path, first_line: bytes) -> None:
    (tmp_path / "old.bag").write_bytes(old_bag(old_messages(), first_line=first_line))
    assert values(tmp_path / "old.bag", unindexed=False) == list(range(12))


@pytest.mark.parametrize("indexed", [True, False])
def test_messages_come_by_time_and_publishers_of_latched_ones_are_kept(tmp_path: Path, indexed: bool) -> None:
    messages = [number("/a", (i + 1) * NS, i, "/talker" if i == 2 else "") for i in (2, 0, 1)]
    path = make(tmp_path, messages, indexed=indexed)
    assert values(path) == [0, 1, 2]
    assert reindex(path, tmp_path / "new.bag").messages == 3
    assert values(tmp_path / "new.bag", unindexed=False) == [0, 1, 2]
    with BagReader(tmp_path / "new.bag") as bag:
        latched = [connection for connection in bag.connections.values() if connection.latching]
        assert [connection.callerid for connection in latched] == ["/talker"]


def test_a_topic_without_definition_has_that_of_its_type(tmp_path: Path) -> None:
    """As stock reads it."""
    path = tmp_path / "old.bag"
    path.write_bytes(old_bag([number("/a", NS, 0), number("/c", 2 * NS, 1)], indexed=False, undefined=["/c"]))
    assert values(path) == [0, 1]


@pytest.mark.slow
@pytest.mark.parametrize("indexed", [True, False])
def test_cut_anywhere_every_whole_message_comes_back(tmp_path: Path, indexed: bool) -> None:
    messages = old_messages()
    path = make(tmp_path, messages, indexed=indexed)
    whole = path.read_bytes()
    begin = 8 + 4096 if indexed else 0
    ends = [begin + len(old_bag(messages[:count], indexed=False)) for count in range(1, len(messages) + 1)]
    for size in range(begin + 17, len(whole), 7):
        path.write_bytes(whole[:size])
        saved = reindex(path, tmp_path / "new.bag")
        assert saved.messages == sum(end <= size for end in ends)
        assert values(tmp_path / "new.bag", unindexed=False) == list(range(saved.messages))
        if indexed or saved.damaged_places:
            with pytest.raises(UnindexedError, match="pyros1 bag reindex"):
                BagReader(path)


def test_behind_spoilt_bytes_messages_are_found_again(tmp_path: Path) -> None:
    path = make(tmp_path, [text("/b", (i + 1) * NS, str(i)) for i in range(50)])
    data = bytearray(path.read_bytes())
    place = data.index(b"topic=", data.index(b"op=\2", 5500))
    data[place : place + 30] = b"\xff" * 30
    path.write_bytes(data)
    assert reindex(path, tmp_path / "new.bag").messages in (48, 49)


def test_the_next_message_is_found_wherever_the_blocks_of_the_search_end(tmp_path: Path) -> None:
    messages = [number("/a", (i + 1) * NS, i) for i in range(3)]
    whole, first = (old_bag(messages[:count], indexed=False) for count in (3, 1))
    path = tmp_path / "old.bag"
    for length in range(4096 - 50, 4096 + 20):
        path.write_bytes(first + b"\xff" * length + whole[len(first) :])
        assert reindex(path, tmp_path / "new.bag").messages == 3, length


def test_not_closed_it_says_so_and_is_reindexed(tmp_path: Path) -> None:
    path = make(tmp_path, old_messages(), closed=False)
    with pytest.raises(UnindexedError, match=r"was not closed.*pyros1 bag reindex"):
        BagReader(path)
    assert values(path) == list(range(12))
    assert reindex(path, tmp_path / "new.bag").messages == 12


def run(*words: str) -> tuple[int, str]:
    err = io.StringIO()
    with redirect_stdout(io.StringIO()), redirect_stderr(err):
        code = run_command("bag", [*words])
    return code, err.getvalue()


def test_what_ends_with_nothing_says_so_and_fails(tmp_path: Path) -> None:
    path = make(tmp_path, [])
    before = path.read_bytes()
    new = str(tmp_path / "new.bag")
    for words in (
        ["reindex", str(path)],
        ["fix", str(path), new],
        ["export", str(path), "-o", str(tmp_path / "x.mcap")],
    ):
        code, err = run(*words)
        assert code == 1
        assert "no messages" in err
        assert str(path) in err
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["old.bag"]


def test_reindexing_what_lost_its_connections_says_so(tmp_path: Path) -> None:

    path = write_bag(tmp_path / "x.bag", close=False, chunk_threshold=1 << 20)
    path.write_bytes(path.read_bytes().replace(b"md5sum=", b"xx5sum="))
    code, err = run("reindex", str(path))
    assert (code, "no connection record" in err) == (1, True)
