"""`pyros1 bag play` beside stock's player, with the same bags and listeners; and each plays what the other recorded."""

from __future__ import annotations

import itertools
import os
import re
import signal
import sys
from pathlib import Path
from typing import Any

import pytest
from harness import SOURCE, STOCK_PYTHON, Master, Peer, Process, until

import pyros1
from pyros1.bag import BagWriter
from pyros1.bag.format.reader import BagReader
from pyros1.msgs import load_message

OWN_MASTER = True
MASTERS = ("ours",)  # stock's tool and ours are compared, whatever the master

pytestmark = pytest.mark.ours_only

RECORD, PLAY = "/usr/lib/rosbag/record", "/usr/lib/rosbag/play"
TEXT, STATIC = "std_msgs/String", "tf2_msgs/TFMessage"
SCRIPTS = SOURCE / "pyros1" / "packages" / "minimal_nodes" / "scripts"
BEGIN = 1_700_000_000 * 10**9
MS = 10**6
PLAYERS = ["ours", "stock"]


def player(launcher: Master, who: str, *words: str) -> Process:
    command = [PLAY] if who == "stock" else [sys.executable, "-m", "pyros1", "bag", "play"]
    return launcher.run([*command, *words], python=who, label=f"{who} player")


def make_bag(path: Path, topic: str, latched: str) -> Path:
    """A text every 10 ms for a second, latched ones from two publishers at the beginning."""
    cls: Any = load_message(TEXT)
    header = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text}
    with BagWriter(path, chunk_threshold=2000) as bag:

        def connect(name: str, **more: str) -> int:
            return bag.add_connection(name, {key: text.encode() for key, text in {**header, **more}.items()})

        conns = [connect(latched, callerid=name, latching="1") for name in ("/one", "/two")]
        plain = connect(topic, callerid="/talker", latching="0")
        for time, conn, text in [(0, 0, "old"), (1, 0, "new"), (2, 1, "other")]:
            bag.write(conns[conn], BEGIN + time * MS, cls._encode(cls(text)))
        for number in range(100):
            bag.write(plain, BEGIN + (3 + number * 10) * MS, cls._encode(cls(f"number {number}")))
    return path


def text(body: str) -> str:
    return bytes.fromhex(body)[4:].decode()


@pytest.mark.parametrize("who", PLAYERS)
@pytest.mark.parametrize("kind", ["roscpp", "rospy"])
def test_listeners_get_the_same(launcher: Master, topic: str, kind: str, who: str, tmp_path: Path) -> None:
    path = make_bag(tmp_path / "x.bag", topic, topic + "/latched")
    peer = launcher.ready_peer(kind, f"ear_{who}_{kind}")
    peer.subscribe(topic, TEXT, 1000)
    peer.subscribe(topic + "/latched", TEXT, 1000)
    process = player(launcher, who, "--wait-for-subscribers", "-r", "4", str(path))
    assert [text(peer.received(topic)) for _ in range(100)] == [f"number {number}" for number in range(100)]
    assert [text(peer.received(topic + "/latched")) for _ in range(3)] == ["old", "new", "other"]
    assert peer.header(topic + "/latched")["latching"] == "1"
    assert process.wait() == 0, process.transcript()


@pytest.mark.parametrize("who", PLAYERS)
def test_start_and_duration(launcher: Master, topic: str, who: str, tmp_path: Path) -> None:
    """B32: the part from -s on, after what was latched before."""
    path = make_bag(tmp_path / "x.bag", topic, topic + "/latched")
    peer = launcher.ready_peer("roscpp", f"ear_{who}")
    peer.subscribe(topic, TEXT, 1000)
    peer.subscribe(topic + "/latched", TEXT, 1000)
    process = player(launcher, who, "--wait-for-subscribers", "-d", "1", "-s", "0.5", "-u", "0.2", str(path))
    assert process.wait() == 0, process.transcript()
    assert [text(peer.received(topic)) for _ in range(20)] == [f"number {number}" for number in range(50, 70)]
    assert [text(peer.received(topic + "/latched")) for _ in range(2)] == ["new", "other"]
    assert not peer.unread(r"^got ")


@pytest.mark.parametrize("who", PLAYERS)
def test_clock(launcher: Master, topic: str, who: str, tmp_path: Path) -> None:
    """B30: it begins with the first message, never runs back, ends before the last message or with it."""
    path = make_bag(tmp_path / "x.bag", topic, topic + "/latched")
    peer = launcher.ready_peer("rospy", f"ear_{who}")
    peer.subscribe("/clock", "rosgraph_msgs/Clock", 1000)
    process = player(launcher, who, "--clock", "--hz", "100", "-d", "3", "-r", "0.25", str(path))
    assert process.wait() == 0, process.transcript()
    times = clock_times(peer)
    assert times == sorted(times) and 30 < len(times) < 430
    assert 0 <= times[0] < 200 * MS and times[-1] <= 993 * MS


@pytest.mark.parametrize("who", PLAYERS)
def test_clock_at_a_rate_in_a_part(launcher: Master, topic: str, who: str, tmp_path: Path) -> None:
    """It begins with the first message of the part; a tick adds 5 ms of the bag, or more if some were missed."""
    path = make_bag(tmp_path / "x.bag", topic, topic + "/latched")
    peer = launcher.ready_peer("rospy", f"ear_{who}")
    peer.subscribe("/clock", "rosgraph_msgs/Clock", 1000)
    words = ("--clock", "--hz", "50", "-r", "0.25", "-s", "0.2", "-u", "0.5", "-d", "3", "--topics", topic, "--bags")
    process = player(launcher, who, *words, str(path))
    assert process.wait() == 0, process.transcript()
    times = clock_times(peer)
    assert 200 * MS <= times[0] < 400 * MS and times == sorted(times) and times[-1] <= 700 * MS
    steps = sorted(after - before for before, after in itertools.pairwise(times))
    assert len(times) <= 0.5 / 0.25 * 50 + 5 and steps[len(steps) // 2] > 4 * MS


@pytest.mark.parametrize("who", PLAYERS)
def test_late_subscribers_get_the_static_transforms_of_all(
    launcher: Master, topic: str, who: str, tmp_path: Path
) -> None:
    """Stock sends the last message of each publisher, pyros1 one with all."""
    cls, stamped = load_message(STATIC), load_message("geometry_msgs/TransformStamped")
    header = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text, "latching": "1"}
    topic += "/tf_static"
    for name, callers in (("one.bag", ["/a", "/b"]), ("two.bag", ["/c"])):
        with BagWriter(tmp_path / name) as bag:
            for caller in callers:
                fields = {key: text.encode() for key, text in {**header, "callerid": caller}.items()}
                transform: Any = stamped(child_frame_id=caller[1:])
                bag.write(bag.add_connection(topic, fields), BEGIN, cls._encode(cls([transform])))
    early = launcher.ready_peer("rospy", f"early_{who}")
    early.subscribe(topic, STATIC, 100)
    bags = [str(tmp_path / name) for name in ("one.bag", "two.bag")]
    process = player(launcher, who, "--wait-for-subscribers", "-k", *bags)

    def children(body: str) -> set[str]:
        message: Any = cls._decode(bytes.fromhex(body), 0, len(body) // 2)
        return {transform.child_frame_id for transform in message.transforms}

    assert set().union(*(children(early.received(topic)) for _ in range(3))) == {"a", "b", "c"}
    late = launcher.ready_peer("roscpp", f"late_{who}")
    late.subscribe(topic, STATIC, 100)
    found = [children(late.received(topic)) for _ in range(3 if who == "stock" else 1)]
    assert sorted(sorted(one) for one in found) == ([["a"], ["b"], ["c"]] if who == "stock" else [["a", "b", "c"]])
    process.signal(signal.SIGINT)
    assert process.wait() == 0


def clock_times(peer: Peer) -> list[int]:
    """The values of /clock that a peer got, in nanoseconds since the bag's beginning."""
    bodies = [bytes.fromhex(line.split()[2]) for line in peer.unread(r"^got /clock ")]
    return [int.from_bytes(body[:4], "little") * 10**9 + int.from_bytes(body[4:], "little") - BEGIN for body in bodies]


def test_pause_service_answers_as_stock_does(launcher: Master, topic: str, tmp_path: Path) -> None:
    """B29"""
    path = make_bag(tmp_path / "x.bag", topic, topic + "/latched")
    said: dict[str, list[str]] = {}
    for who in PLAYERS:
        process = player(launcher, who, "--pause", "-r", "0.01", str(path), f"__name:=player_{who}")
        service = f"/player_{who}/pause_playback"
        until(lambda name=service: launcher.call("lookupService", name)[0] == 1, "the service")
        said[who] = [
            launcher.tool("rosservice", "call", service, value) for value in ("true", "false", "false", "true")
        ]
        process.signal(signal.SIGINT)
        process.wait()
    assert said["ours"] == said["stock"]


def node(launcher: Master, script: str, *words: str) -> Process:
    return launcher.run([sys.executable, str(SCRIPTS / script), *words], python="ours", label=script)


@pytest.mark.parametrize(("recorder", "who"), [("ours", "stock"), ("stock", "ours")])
def test_tutorial(launcher: Master, topic: str, recorder: str, who: str, tmp_path: Path) -> None:
    """The minimal nodes' topic1: what one system records, the other plays; minimal_subscriber prints the same."""
    path = tmp_path / "tutorial.bag"
    publisher = node(launcher, "minimal_publisher", "_rate:=10", f"topic1:={topic}")
    until(lambda: launcher.publishers(topic), "the publisher is there")
    command = [RECORD] if recorder == "stock" else [sys.executable, "-m", "pyros1", "bag", "record"]
    recording = launcher.run([*command, "--duration", "5", "-O", str(path), topic], python=recorder)
    assert recording.wait(30) == 0, recording.transcript()
    publisher.close()
    cls: Any = load_message("std_msgs/Float64")
    with BagReader(path) as bag:
        values = [cls._decode(message.data, 0, 8).data for message in bag.messages()]
        length = (bag.end - bag.start) / 1e9
    assert len(values) > 5
    subscriber = node(launcher, "minimal_subscriber", f"topic1:={topic}")
    process = player(launcher, who, "--wait-for-subscribers", "-d", "1", str(path))
    assert process.wait(30) == 0, process.transcript()
    expected = [f"{value:.6f}" for value in values]
    until(lambda: subscriber.unread(f"received value is: {expected[-1]}$"), "the last value")
    line = re.compile(r"\[(\d+\.\d+)\]: received value is: (\d+\.\d{6})")
    printed = [found for text in subscriber.lines if (found := line.search(text))]
    rest = iter(expected)
    assert all(found[2] in rest for found in printed), "in order; with its queue of one it misses some if it is slow"
    assert len(printed) > 5
    assert float(printed[-1][1]) - float(printed[0][1]) > length / 2, "at the pace of the recording, not at once"


def test_stock_python_reads_a_recording_of_ours(launcher: Master, topic: str, tmp_path: Path) -> None:
    """rosbag.Bag in Python decodes what our recorder wrote."""
    peer = launcher.shared("bag", "rospy")
    peer.advertise(topic, TEXT, 100, True)
    body = peer.publish(topic, 3)
    command = [sys.executable, "-m", "pyros1", "bag", "record", "-l", "1", "-O", str(tmp_path / "x"), topic]
    assert launcher.run(command, python="ours").wait(30) == 0
    program = (
        "import rosbag, sys\n"
        "for topic, message, time in rosbag.Bag(sys.argv[1]).read_messages():\n"
        "    print(topic, message.data.encode().hex())"
    )
    out = launcher.tool(STOCK_PYTHON, "-c", program, os.fspath(tmp_path / "x.bag"))
    assert out == f"{topic} {bytes.fromhex(body)[4:].hex()}\n"


@pytest.mark.parametrize("quiet", [[], ["-q"]], ids=["", "quiet"])
def test_rosout_says_which_bag_is_opened(launcher: Master, topic: str, quiet: list[str], tmp_path: Path) -> None:
    """Stock's says the same, but so early that a console gets it by chance: that it says nothing else is tested."""
    path = make_bag(tmp_path / "x.bag", topic, topic + "/latched")
    said: list[tuple[str, str]] = []
    with pyros1.Node("reader_of_rosout", master_uri=launcher.uri, argv=[], rosout=False) as node:
        node.subscribe("/rosout", "rosgraph_msgs/Log", lambda message: said.append((message.name, message.msg)))
        stocks = player(launcher, "stock", "-d", "1", *quiet, str(path), "__name:=the_player_of_stock")
        assert stocks.wait() == 0, stocks.transcript()
        player(launcher, "ours", "-d", "30", *quiet, str(path), "__name:=the_player")
        until(lambda: ("/the_player", f"Opening {path}") in said, "what the player says")
    assert {text for name, text in said if name.startswith("/the_player")} == {f"Opening {path}"}
