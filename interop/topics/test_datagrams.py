"""UDPROS with roscpp's nodes, both ways (T57-T62, L108).

Stock's relay and recorder ask our publishers for datagrams, ours ask roscpp's; rospy has none, and is asked over TCP.

Feature: UDPROS: topics over UDP, with roscpp nodes and ours -- `node.subscribe(..., transports=("udp", "tcp"))`, `bag
    record --udp`, `~unreliable` of relay and throttle
"""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from harness import Master, Process, until

from pyros1.bag.format.reader import BagReader
from pyros1.msgs import load_message
from pyros1.node import Node

MASTERS = ("ours", "stock")
RELAY, RECORD = "/usr/lib/topic_tools/relay", "/usr/lib/rosbag/record"
String: Any = load_message("std_msgs/String")
TEXTS = ["", "small", "x" * 1488, "y" * 1489, "z" * 50_000]
"""Bodies of one datagram and of several: 1,492 bytes go into one, 8 of which are lengths."""


class Heard:
    """A callback that keeps texts."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self._changed = threading.Condition()

    def __call__(self, message: Any) -> None:
        with self._changed:
            self.texts.append(message.data)
            self._changed.notify_all()

    def wait(self, count: int) -> list[str]:
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.texts) >= count, 20), f"{len(self.texts)} of {count}"
        return self.texts


@pytest.fixture
def node(launcher: Master, topic: str) -> Iterator[Node]:
    """A node of ours in this process."""
    name = "datagrams_" + topic.rpartition("/")[2]
    with Node(name, environ=launcher.environ("ours"), argv=[], handle_signals=False) as node:
        yield node


def transports(node: Node, topic: str) -> list[str]:
    """How a node of ours is linked on a topic, as it tells others."""
    listed = node._context.publications.get(topic) or node._topics.subscriptions[topic]
    return [link.transport for link in listed.links]


def relay(launcher: Master, name: str, source: str, target: str) -> Process:
    """Stock's relay, which asks for datagrams."""
    launcher.call("setParam", f"/{name}/unreliable", True)
    return launcher.run([RELAY, source, target, f"__name:={name}"], label="stock's relay")


def test_t57_roscpp_hears_our_publisher(launcher: Master, node: Node, topic: str) -> None:
    process = relay(launcher, "udp_" + topic.rpartition("/")[2], topic, topic + "/out")
    heard = Heard()
    node.subscribe(topic + "/out", String, heard)
    publisher = node.advertise(topic, String, queue_size=10)
    assert publisher.wait_for_subscribers(timeout=20)
    assert transports(node, topic) == ["UDPROS"]
    # A relay advertises its output when it has the first message, which is lost then.
    until(lambda: publisher.publish("first") or launcher.publishers(topic + "/out"), "the relay advertises")
    until(lambda: publisher.publish("linked") or "linked" in heard.texts, "the relay is linked")
    publisher.publish("begin")
    until(lambda: "begin" in heard.texts, "all of those have come")
    for number, text in enumerate(TEXTS, len(heard.texts) + 1):
        publisher.publish(text)
        heard.wait(number)
    assert heard.texts[-len(TEXTS) :] == TEXTS
    bus = launcher.node("/udp_" + topic.rpartition("/")[2], "getBusInfo")[2]
    assert [[entry[3], entry[5]] for entry in bus if entry[4] == topic] == [["UDPROS", True]]
    process.signal(signal.SIGKILL)
    until(lambda: publisher.publish("to nobody") or not publisher.num_connections, "its end is noticed")


def test_t58_we_hear_roscpps_publisher(launcher: Master, node: Node, topic: str) -> None:
    name = "udp_" + topic.rpartition("/")[2]
    process = launcher.run([RELAY, topic, topic + "/out", f"__name:={name}"], label="stock's relay")
    heard = Heard()
    subscriber = node.subscribe(topic + "/out", String, heard, transports=("udp",))
    publisher = node.advertise(topic, String, queue_size=10)
    until(lambda: publisher.publish("first") or subscriber.num_connections, "linked to the relay")
    until(lambda: publisher.publish("linked") or "linked" in heard.texts, "the relay is heard")
    publisher.publish("begin")
    until(lambda: "begin" in heard.texts, "all of those have come")
    assert transports(node, topic + "/out") == ["UDPROS"]
    for number, text in enumerate(TEXTS, len(heard.texts) + 1):
        publisher.publish(text)
        heard.wait(number)
    assert heard.texts[-len(TEXTS) :] == TEXTS
    process.signal(signal.SIGINT)
    process.wait()
    until(lambda: not subscriber.num_connections, "its end is noticed")


@pytest.mark.parametrize("whose", ["stock", "ours"])
def test_l108_record_udp(launcher: Master, node: Node, topic: str, whose: str, tmp_path: Path) -> None:
    command = [RECORD] if whose == "stock" else [sys.executable, "-m", "pyros1", "bag", "record"]
    python = "ours" if whose == "ours" else "stock"
    # The last text ends a chunk of 1 kB, so the file tells when it is written: stock loses what waits when it ends.
    words = [*command, "--udp", "--chunksize=1", "-O", str(tmp_path / "x"), topic]
    process = launcher.run(words, python=python, label=f"{whose} recorder")
    publisher = node.advertise(topic, String, latch=True)
    assert publisher.wait_for_subscribers(timeout=20)
    assert transports(node, topic) == ["UDPROS"]
    for text in TEXTS:
        publisher.publish(text)
    [recorder] = launcher.subscribers(topic)

    def received() -> bool:
        answer = launcher.node(recorder, "getBusStats")
        statistics = dict(answer[1] if whose == "stock" else answer[2][1])  # roscpp's has no code and text in front
        return bool(sum(link[2] for link in statistics[topic] if len(link) > 2) == len(TEXTS))

    until(received, "all messages have come")
    active = tmp_path / "x.bag.active"
    until(lambda: active.stat().st_size > len(TEXTS[-1]), "all messages are recorded")
    process.signal(signal.SIGINT)
    assert process.wait() == 0, process.transcript()
    with BagReader(tmp_path / "x.bag") as bag:
        for message in bag.messages():
            header = message.connection.header
            assert (header["callerid"], header["latching"]) == (node.name.encode(), b"1")
        assert [String._decode(m.data, 0, len(m.data)).data for m in bag.messages()] == TEXTS


def test_t62_rospys_publishers_are_heard_over_tcp(launcher: Master, node: Node, topic: str) -> None:
    heard = Heard()
    node.subscribe(topic, String, heard, transports=("udp", "tcp"))
    process = launcher.run(
        ["rostopic", "pub", "-r", "10", topic, "std_msgs/String", "data: by tcp"], label="rostopic pub"
    )
    assert heard.wait(2) == ["by tcp"] * len(heard.texts)
    assert transports(node, topic) == ["TCPROS"]
    process.signal(signal.SIGINT)


def test_relay_of_ours_asks_for_datagrams(launcher: Master, node: Node, topic: str) -> None:
    words = [sys.executable, "-m", "pyros1", "topic_tools", "relay", topic, topic + "/out", "_unreliable:=true"]
    launcher.run(words, python="ours", label="our relay")
    publisher = node.advertise(topic, String)
    assert publisher.wait_for_subscribers(timeout=20)
    assert transports(node, topic) == ["UDPROS"]


def test_rosnode_info_names_the_transport(launcher: Master, node: Node, topic: str) -> None:
    relay(launcher, "info_" + topic.rpartition("/")[2], topic, topic + "/out")
    publisher = node.advertise(topic, String)
    assert publisher.wait_for_subscribers(timeout=20)
    for command in (["rosnode"], [sys.executable, "-m", "pyros1", "node"]):
        environ = launcher.environ("ours" if command[0] == sys.executable else "stock")
        done = subprocess.run(
            [*command, "info", node.name], env=environ, capture_output=True, text=True, timeout=30, check=True
        )
        assert f"* topic: {topic}\n" in done.stdout and "* transport: UDPROS" in done.stdout
