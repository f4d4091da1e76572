"""A process can open no more files: it says so once, stays quiet, and takes whoever waits when it can again.

Feature: system faults: no file descriptors left, a full disk, a clock that jumps, hundreds of nodes at once --
    reported once; everything recovers afterwards
"""

from __future__ import annotations

import resource
import signal
import socket
import sys
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from harness import Master, Process, until
from vitals import busy, limited, vitals

from pyros1.bag.format.reader import BagReader
from pyros1.msgs.std_msgs.msg import String
from pyros1.net.hosts import parse_uri
from pyros1.node import Node

MASTERS = ("ours",)
TEXT, FLIP = "std_msgs/String", "std_srvs/SetBool"
CALM = 0.5
"""The share of a processor that a process without free descriptors may use; one that tries again and again uses 1."""


@contextmanager
def crowd(process: Process, port: int, spare: int = 2) -> Iterator[None]:
    """Let a process run out of descriptors: connections to a port of it that say nothing have them all."""
    with ExitStack() as stack:
        stack.enter_context(limited(process.pid, resource.RLIMIT_NOFILE, vitals(process.pid).files + spare))
        for _ in range(spare + 20):
            stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=10))
        yield


def test_a_node(launcher: Master, topic: str) -> None:
    node, waiting = launcher.ready_peer("pyros1", "crowded"), launcher.ready_peer("roscpp", "waiting")
    friend = launcher.ready_peer("roscpp", "friend")
    node.advertise(topic, TEXT)
    friend.subscribe(topic, TEXT)
    node.linked(topic)
    friend.linked(topic)
    node.serve(f"{topic}/flip", FLIP)
    with crowd(node, parse_uri(launcher.call("lookupService", f"{topic}/flip")[2], "rosrpc")[1]):
        node.wait_line("ERROR.*cannot accept a connection: Too many open files. The limit of open files is", 30)
        waiting.subscribe(topic, TEXT)
        assert busy(node.pid, 2.0) < CALM
        for seed in range(3):
            assert node.publish(topic, seed) == friend.received(topic), "old links go on"
        assert not node.unread("cannot accept")
    node.linked(topic, 2)
    assert node.publish(topic, 9) == waiting.received(topic, 30)
    waiting.available(f"{topic}/flip")
    waiting.call(f"{topic}/flip", FLIP)


def test_a_subscriber_that_cannot_connect(launcher: Master, topic: str) -> None:
    node, source = launcher.ready_peer("pyros1", "crowded"), launcher.ready_peer("roscpp", "source")
    node.serve(f"{topic}/flip", FLIP)
    node.subscribe(f"{topic}/other", TEXT)  # the type is read from a file
    source.advertise(topic, TEXT)
    with crowd(node, parse_uri(launcher.call("lookupService", f"{topic}/flip")[2], "rosrpc")[1]):
        node.tell("sub", topic, TEXT, 10)
        node.wait_line(f"no messages of {topic} from ", 30)
    node.event("subscribed", topic, timeout=60)
    source.linked(topic)
    assert source.publish(topic) == node.received(topic, 30)


def test_the_master(own_master: Callable[[str], Master]) -> None:
    """It makes room for new callers by ending old connections, which callers open again without notice."""
    master = own_master("ours")
    master.start()
    core = master.core[0]
    with crowd(core, master.port, spare=1):
        core.wait_line("the master cannot accept a connection: Too many open files", 30)
        sink, source = master.ready_peer("pyros1", "sink"), master.ready_peer("roscpp", "source")
        sink.subscribe("/t", TEXT)
        source.advertise("/t", TEXT)
        source.linked("/t")
        assert source.publish("/t") == sink.received("/t")
        assert "/source" in master.tool("rosnode", "list")
        assert busy(core.pid, 2.0) < CALM
        assert not core.unread("the master cannot accept")
    assert "/t" in master.tool("rostopic", "list")


def test_the_web_server(launcher: Master) -> None:
    command = [sys.executable, "-m", "pyros1", "web", "--port", "0"]
    web = launcher.run(command, python="ours", label="web")
    link = web.wait_line(r"in a browser: (http://\S+)", 30)[1]
    until(lambda: [name for name in launcher.subscribers("/rosout") if "web" in name], "its node", 30)
    port = int(link.partition("://")[2].partition("/")[0].rpartition(":")[2])
    with crowd(web, port):
        web.wait_line("pyros1 web: .*Too many open files", 30)
        assert busy(web.pid, 2.0) < CALM
        assert not web.unread("Too many open files")
    with urllib.request.urlopen(link, timeout=60) as answer:
        assert answer.status == 200


def messages(master: Master, topic: str) -> int:
    """How many messages of a topic the recorder has received."""
    statistics = dict(master.node("/recorder", "getBusStats")[2][1])
    return sum(link[2] for link in statistics[topic])


def test_a_recorder(launcher: Master, topic: str, tmp_path: Path) -> None:
    early, late = launcher.ready_peer("roscpp", "early"), launcher.ready_peer("roscpp", "late")
    early.advertise(f"{topic}/early", TEXT)
    command = [
        sys.executable,
        "-m",
        "pyros1",
        "bag",
        "record",
        "-O",
        str(tmp_path / "a"),
        f"{topic}/early",
        f"{topic}/late",
    ]
    recorder = launcher.run([*command, "__name:=recorder"], python="ours", label="recorder")
    early.linked(f"{topic}/early")
    early.publish(f"{topic}/early")
    place = launcher.call("lookupService", "/recorder/get_loggers")[2]
    with crowd(recorder, parse_uri(place, "rosrpc")[1]):
        recorder.wait_line("Too many open files", 30)
        late.advertise(f"{topic}/late", TEXT)
        early.publish(f"{topic}/early", 2)
    late.linked(f"{topic}/late")
    late.publish(f"{topic}/late")
    for name, count in ((f"{topic}/early", 2), (f"{topic}/late", 1)):
        until(lambda: messages(launcher, name) == count, f"{count} of {name} have come", 30)  # noqa: B023
    recorder.signal(signal.SIGINT)
    assert recorder.wait(60) == 0, recorder.transcript()
    with BagReader(tmp_path / "a.bag") as bag:
        topics = [message.connection.topic for message in bag.messages()]
    assert sorted(topics) == [f"{topic}/early"] * 2 + [f"{topic}/late"]
    until(lambda: not recorder.unread("Traceback"), "no traceback")


@pytest.fixture
def node(launcher: Master) -> Iterator[Node]:
    with Node("source", argv=[], environ=launcher.environ(), handle_signals=False) as node:
        yield node


def test_a_recorder_that_splits(launcher: Master, node: Node, topic: str, tmp_path: Path) -> None:
    """It goes on in the file that it has, and begins the next one when it can."""
    publisher = node.advertise(topic, String, queue_size=0)
    words = [sys.executable, "-m", "pyros1", "bag", "record", "--split", "--size=1", "-O", str(tmp_path / "a"), topic]
    recorder = launcher.run([*words, "__name:=recorder"], python="ours", label="recorder")
    assert publisher.wait_for_subscribers(timeout=60)
    sent = 0

    def publish(count: int) -> None:
        nonlocal sent
        for _ in range(count):
            publisher.publish(String(f"{sent:06d}" + "x" * 300_000))
            sent += 1

    publish(1)
    place = launcher.call("lookupService", "/recorder/get_loggers")[2]
    with crowd(recorder, parse_uri(place, "rosrpc")[1]):
        recorder.wait_line("Too many open files", 30)
        publish(8)
        recorder.wait_line("Cannot start the next file .Too many open files.; the recording continues in .*a_0.bag", 30)
        assert not (tmp_path / "a_1.bag.active").exists()

    def begins_another() -> bool:
        publish(1)
        until(lambda: messages(launcher, topic) == sent, "all have come", 30)
        return (tmp_path / "a_1.bag.active").exists()

    until(begins_another, "the next file is begun", 30)
    recorder.signal(signal.SIGINT)
    assert recorder.wait(60) == 0, recorder.transcript()
    numbers = []
    for file in sorted(tmp_path.glob("a_*.bag"), key=lambda each: each.stat().st_mtime):
        with BagReader(file) as bag:
            numbers += [int(message.data[4:10]) for message in bag.messages()]
    assert numbers == list(range(sent))
