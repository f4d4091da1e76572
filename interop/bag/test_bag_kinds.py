"""Every kind of bag that our own tests read, whole and damaged, before stock rosbag: they must be bags to it, too.

Feature: bags of version 1.2
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from harness import SOURCE, Master, stock_tools

from pyros1.bag.format.reader import BagReader

sys.path.append(str(Path(__file__).resolve().parents[2]))

from tests.bag.made import damaged_bags, whole_bags

MAKER = Path(__file__).resolve().parents[1] / "peers" / "stock_bags.py"
INDEXED_12 = ("1.2", "1.2, latched", "1.2 with 2.0's word")
UNREADABLE = (*INDEXED_12, "1.2, not closed", "1.2, cut")
"""Stock's Python library knows their index, but ends with a TypeError of its own where it should read messages."""

pytestmark = pytest.mark.ours_only


def stock(folder: Path, *words: object) -> tuple[int, str, str]:
    return stock_tools().ask(["rosbag", *map(str, words)], os.environ, cwd=folder, timeout=60)


def ours(folder: Path, *words: object) -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, "-m", "pyros1", "bag", *map(str, words)],
        capture_output=True,
        text=True,
        cwd=folder,
        timeout=60,
        check=False,
        env={**os.environ, "PYTHONPATH": str(SOURCE)},
    )
    return done.returncode, done.stdout, done.stderr


def dump(folder: Path, path: object) -> list[str]:
    """All messages of a bag with their connection headers, as stock reads them, sorted."""
    code, out, err = stock_tools().ask([str(MAKER), "dump", str(path)], os.environ, cwd=folder, timeout=60)
    assert code == 0, err
    return sorted(line.replace("', b'", "', '") for line in out.splitlines())  # of 1.2 its headers are bytes


def test_whole_ones_are_whole_to_stock(tmp_path: Path) -> None:
    """The same `info`, and the same messages; without an index stock's `info` tells little of 1.2."""
    made = whole_bags(tmp_path)
    assert len(made) >= 9
    for kind, path in made.items():
        theirs, mine = stock(tmp_path, "info", path.name), ours(tmp_path, "info", path.name)
        assert theirs[0] == mine[0] == 0, kind
        assert theirs[1] == mine[1] or "without index" in kind, kind
        assert theirs[1].splitlines()[1].split() == mine[1].splitlines()[1].split(), kind
        if kind == "empty" or kind in UNREADABLE:
            continue
        shutil.copy(path, tmp_path / "copy.bag")
        assert ours(tmp_path, "decompress", "-q", "-f", "copy.bag")[0] == 0, kind
        assert dump(tmp_path, "copy.bag") == dump(tmp_path, path.name), kind


def test_damaged_ones_are_damaged_to_stock_and_what_it_saves_we_save(tmp_path: Path) -> None:
    for kind, path in damaged_bags(tmp_path).items():
        assert (
            stock(tmp_path, "info", path.name)[0] == ours(tmp_path, "info", path.name)[0]
            or "spoilt" in kind
            or (
                "without index" in kind  # stock reads none of it then
            )
        ), kind
        shutil.copy(path, tmp_path / "mine.bag")
        shutil.copy(path, tmp_path / "theirs.bag")
        assert ours(tmp_path, "reindex", "-q", "-f", "mine.bag")[0] == 0, kind
        saved = dump(tmp_path, "mine.bag")
        assert saved, kind
        if kind not in UNREADABLE:
            assert stock(tmp_path, "reindex", "-q", "-f", "theirs.bag")[0] == 0, kind
            assert set(saved) >= set(dump(tmp_path, "theirs.bag")), kind


def test_reindexed_ones_of_1_2_are_bags_to_stock(tmp_path: Path) -> None:
    for kind, path in whole_bags(tmp_path).items():
        if kind.startswith("1.2"):
            assert ours(tmp_path, "reindex", "-q", path.name)[0] == 0, kind
            assert ours(tmp_path, "info", path.name) == stock(tmp_path, "info", path.name), kind
            assert len(dump(tmp_path, path.name)) == (4 if "latched" in kind else 12), kind


@pytest.mark.parametrize("kind", INDEXED_12)
def test_stocks_player_plays_those_of_1_2_with_an_index(launcher: Master, tmp_path: Path, kind: str) -> None:
    ear = launcher.ready_peer("rospy", "ear_of_kinds")
    ear.subscribe("/b", "std_msgs/String", 100)
    path = whole_bags(tmp_path)[kind]
    process = launcher.run(["/usr/lib/rosbag/play", "-d", "4", "-r", "4", str(path)], label="player")
    with BagReader(path) as bag:
        assert [ear.received("/b") for _ in range(4)] == [
            found.data.hex() for found in bag.messages(bag.connection_ids(["/b"]))
        ][:4]
    assert process.wait() == 0, process.transcript()
