"""`pyros1 bag record` beside stock's recorder on the same topics, under both masters: what is in the files.

Feature: recordings of both systems -- have the same contents, and each plays the other's
"""

from __future__ import annotations

import re
import signal
import sys
from pathlib import Path
from typing import Any

import pytest
from harness import Master, Process, until

import pyros1
from pyros1.bag.format.reader import BagReader

OWN_MASTER = True
MASTERS = ("ours",)  # stock's tool and ours are compared, whatever the master

pytestmark = pytest.mark.ours_only

RECORD = "/usr/lib/rosbag/record"
TEXT, JOINTS, IMAGE = "std_msgs/String", "sensor_msgs/JointState", "sensor_msgs/Image"


def ours(launcher: Master, *words: str) -> Process:
    return launcher.run([sys.executable, "-m", "pyros1", "bag", "record", *words], python="ours", label="our recorder")


def stock(launcher: Master, *words: str) -> Process:
    return launcher.run([RECORD, *words], label="stock's recorder")


def end(process: Process) -> None:
    process.signal(signal.SIGINT)
    assert process.wait() == 0, process.transcript()


def heard_by_stock(launcher: Master, *topics: str) -> int:
    """How many messages stock's recorder has: it loses what has not come when it ends."""
    count = 0
    for topic in topics:
        for name in launcher.subscribers(topic):
            answer = launcher.node(name, "getBusStats")
            if isinstance(answer[0], list):  # roscpp's has no code and text in front
                count += sum(link[2] for link in dict(answer[1]).get(topic, []) if len(link) > 2)
    return count


def content(path: Path) -> dict[tuple[Any, ...], list[bytes]]:
    """Publisher, with every field of its connection header -> its messages, in order."""
    found: dict[tuple[Any, ...], list[bytes]] = {}
    with BagReader(path, unindexed=True) as bag:
        for message in bag.messages():
            key = (message.connection.topic, *sorted(message.connection.header.items()))
            found.setdefault(key, []).append(message.data)
    return found


@pytest.mark.parametrize("kind", ["roscpp", "rospy", "pyros1"])
def test_both_record_the_same(launcher: Master, topic: str, kind: str, tmp_path: Path) -> None:
    peer = launcher.shared("bag", kind)
    kinds = {f"{topic}/text": TEXT, f"{topic}/joints": JOINTS, f"{topic}/latched": TEXT}
    for name, type_name in kinds.items():
        peer.advertise(name, type_name, 1000, name.endswith("latched"))
    sent = [peer.publish(f"{topic}/latched", 5)]
    recorders = [
        ours(launcher, "-O", str(tmp_path / "ours"), *kinds),
        stock(launcher, "-O", str(tmp_path / "stock"), *kinds),
    ]
    for name in kinds:
        peer.linked(name, 2)
    for seed in range(50):
        sent += [peer.publish(f"{topic}/text", seed), peer.publish(f"{topic}/joints", seed)]
    active = tmp_path / "ours.bag.active"
    until(lambda: sum(map(len, content(active).values())) == len(sent), "all is on the disk")
    until(lambda: heard_by_stock(launcher, *kinds) >= len(sent), "stock's has all")
    for recorder in recorders:
        end(recorder)
    mine, theirs = content(tmp_path / "ours.bag"), content(tmp_path / "stock.bag")
    assert mine == theirs
    assert sorted(data.hex() or "-" for bodies in mine.values() for data in bodies) == sorted(sent)


@pytest.mark.parametrize("more", [[], ["-e"]], ids=["named", "regex"])
def test_both_remap_once(launcher: Master, topic: str, more: list[str], tmp_path: Path) -> None:
    """Under a:=b b:=c, both record the messages of b, under the name a (O30)."""
    peer = launcher.shared("bag", "roscpp")
    names = [f"{topic}/{letter}" for letter in "abc"]
    for name in names:
        peer.advertise(name, TEXT)
    words = [*more, names[0], f"{names[0]}:={names[1]}", f"{names[1]}:={names[2]}"]
    recorders = [
        ours(launcher, "-O", str(tmp_path / "ours"), *words),
        stock(launcher, "-O", str(tmp_path / "stock"), *words),
    ]
    peer.linked(names[1], 2)
    sent = [peer.publish(names[1], seed) for seed in range(20)]
    active = tmp_path / "ours.bag.active"
    until(lambda: sum(map(len, content(active).values())) == len(sent), "all is on the disk")
    until(lambda: heard_by_stock(launcher, names[1]) >= len(sent), "stock's has all")
    for recorder in recorders:
        end(recorder)
    mine, theirs = content(tmp_path / "ours.bag"), content(tmp_path / "stock.bag")
    assert mine == theirs
    assert {key[0] for key in mine} == {names[0]}


def test_stock_reads_what_we_record(launcher: Master, topic: str, tmp_path: Path) -> None:
    peer = launcher.shared("bag", "roscpp")
    peer.advertise(topic, TEXT)
    for words in ([], ["--lz4"], ["-j"]):
        path = tmp_path / "x.bag"
        recorder = ours(launcher, "-O", str(path), "--chunksize", "1", *words, topic)
        peer.linked(topic, 1)
        for seed in range(100):
            peer.publish(topic, seed)
        until(lambda: sum(map(len, content(tmp_path / "x.bag.active").values())) == 100, "all is on the disk")
        end(recorder)
        peer.linked(topic, 0)
        info = launcher.tool("rosbag", "info", str(path))
        assert re.search(r"messages: +100\n", info) and re.search(rf"{topic} +100 msgs +: {TEXT}", info), info
        assert "not need any migrations" in launcher.tool("rosbag", "check", str(path))


def test_stock_reindexes_what_a_killed_recorder_leaves(launcher: Master, topic: str, tmp_path: Path) -> None:
    """Its own file header has to be as large as stock's: stock rewrites it in place."""
    peer = launcher.shared("bag", "roscpp")
    peer.advertise(topic, TEXT)
    recorder = ours(launcher, "-O", str(tmp_path / "x"), topic)
    peer.linked(topic, 1)
    for seed in range(100):
        peer.publish(topic, seed)
    active = tmp_path / "x.bag.active"
    until(lambda: sum(map(len, content(active).values())) == 100, "all is on the disk")
    recorder.signal(signal.SIGKILL)
    recorder.wait()
    path = active.rename(tmp_path / "x.bag")
    launcher.tool("rosbag", "reindex", "-q", str(path))
    assert re.search(r"messages: +100\n", launcher.tool("rosbag", "info", str(path)))


def test_splits_are_called_and_forgotten_as_stock_does(launcher: Master, topic: str, tmp_path: Path) -> None:
    """B17, B18: numbers, the latest ones, no trace of the others. (Where exactly a file is full differs by a chunk.)"""
    peer = launcher.shared("bag", "roscpp")
    peer.advertise(topic, IMAGE, 1000)
    folders = {tmp_path / "ours": ours, tmp_path / "stock": stock}
    for folder in folders:
        folder.mkdir()
    words = ["--split", "--size", "1", "--max-splits", "2", "-O"]
    recorders = [start(launcher, *words, str(folder / "s"), topic) for folder, start in folders.items()]
    peer.linked(topic, 2)
    for _ in range(20):
        peer.publish(topic, 600_000)
    for folder in folders:
        until(lambda folder=folder: not list(folder.glob("s_[0-2].*")), "old files are removed")
    for recorder in recorders:
        end(recorder)
    for folder in folders:
        numbers = sorted(int(re.fullmatch(r"s_(\d+)\.bag", path.name)[1]) for path in folder.iterdir())  # type: ignore[index]
        assert numbers == list(range(numbers[0], numbers[0] + 3)), folder


def test_rosout_says_what_stocks_does(launcher: Master, topic: str, tmp_path: Path) -> None:
    """Read in a console: which topic, which files, and when they are closed. (The first words may come too early.)"""
    peer = launcher.shared("bag", "roscpp")
    peer.advertise(topic, TEXT, 1000)
    said: dict[str, list[str]] = {}
    with pyros1.Node("reader_of_rosout", master_uri=launcher.uri, argv=[], rosout=False) as node:
        node.subscribe(
            "/rosout", "rosgraph_msgs/Log", lambda m: said.setdefault(m.name, []).append(f"{m.level} {m.msg}")
        )
        for name, start in (("ours", ours), ("stock", stock)):
            folder = tmp_path / name
            folder.mkdir()
            recorder = start(
                launcher, "--split", "--duration", "1", "-O", str(folder / "s"), topic, f"__name:=recorder_of_{name}"
            )
            until(lambda name=name: any("_3" in text for text in said.get(f"/recorder_of_{name}", ())), "third split")
            end(recorder)
    files = {
        name: [text.replace(str(tmp_path / name), "") for text in said[f"/recorder_of_{name}"]]
        for name in ("ours", "stock")
    }
    splits = [text for i in (1, 2) for text in (f"2 Closing '/s_{i}.bag'.", f"2 Recording to '/s_{i + 1}.bag'.")]
    for name, texts in files.items():
        assert [text for text in texts if text in splits] == splits, name
        assert {re.sub(r"_\d|'.*'", "", text) for text in texts} <= {
            f"2 Subscribing to {topic}",
            "2 Recording to .",
            "2 Closing .",
        }, name
