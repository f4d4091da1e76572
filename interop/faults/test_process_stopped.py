"""Processes that stand still (SIGSTOP): others go on, in bounded memory and time, and all is well afterwards.

Feature: process faults: killed, stopped, hung, another program on their port, callbacks that raise or do not return
"""

from __future__ import annotations

import contextlib
import signal
import sys
import time
from collections.abc import Callable

import pytest
from harness import Master, Process, until
from vitals import stopped, vitals

MASTERS = ("ours",)
TEXT, IMAGE, FLIP = "std_msgs/String", "sensor_msgs/Image", "std_srvs/SetBool"
KINDS = ("roscpp", "rospy", "pyros1")
ROOM = 60 << 20
"""Bytes that a publisher of images of 1 MB may grow by, with a queue of 5."""


@pytest.mark.parametrize(("source_kind", "sink_kind"), [("pyros1", "roscpp"), ("roscpp", "pyros1")])
def test_a_subscriber(launcher: Master, topic: str, source_kind: str, sink_kind: str) -> None:
    source, sink = launcher.ready_peer(source_kind, "source"), launcher.ready_peer(sink_kind, "sleeper")
    source.advertise(topic, IMAGE, queue_size=5)
    sink.subscribe(topic, IMAGE, queue_size=5)
    source.linked(topic)
    source.publish(topic, 1_000_000)
    sink.received(topic)
    before = vitals(source.pid).memory
    with stopped(sink):
        source.ask("burst", topic, 1_000_000, 150, event=f"burst {topic}", timeout=60)
        assert vitals(source.pid).memory < before + ROOM
    sink.received(topic, 60)
    size, _ = source.publish(topic, 1_000_999).split(":")  # the rest: roscpp writes header.seq late
    until(lambda: sink.received(topic, 60).startswith(size), "the newest message", timeout=60)


@pytest.mark.parametrize("source_kind", KINDS)
def test_a_publisher(launcher: Master, topic: str, source_kind: str) -> None:
    sink, source = launcher.ready_peer("pyros1", "patient"), launcher.ready_peer(source_kind, "sleeper")
    other = launcher.ready_peer("roscpp", "other")
    sink.subscribe(topic, TEXT)
    for each in (source, other):
        each.advertise(topic, TEXT)
        each.linked(topic)
    with stopped(source):
        assert other.publish(topic) == sink.received(topic), "others are heard"
    assert source.publish(topic, 2) == sink.received(topic, 60)


@pytest.mark.parametrize("source_kind", KINDS)
def test_a_publisher_that_stood_still_before_there_was_a_link(launcher: Master, topic: str, source_kind: str) -> None:
    sink, source = launcher.ready_peer("pyros1", "patient"), launcher.ready_peer(source_kind, "sleeper")
    source.advertise(topic, TEXT)
    with stopped(source):
        sink.subscribe(topic, TEXT)
        sink.wait_line(f"no messages of {topic} from the publisher at .* yet: .* does not answer. Is it stopped", 60)
    source.linked(topic)
    assert source.publish(topic) == sink.received(topic)


@pytest.mark.parametrize("server_kind", KINDS)
def test_a_server_of_services(launcher: Master, topic: str, server_kind: str) -> None:
    client, server = launcher.ready_peer("pyros1", "customer"), launcher.ready_peer(server_kind, "shop")
    server.serve(topic, FLIP)
    client.available(topic)
    client.advertise(f"{topic}/alive", TEXT)
    listener = launcher.ready_peer("roscpp", "listener")
    listener.subscribe(f"{topic}/alive", TEXT)
    with stopped(server):
        client.tell("call", topic, FLIP, 1, 0)
        client.event("called", topic)
        began = time.monotonic()
        tool = launcher.run([sys.executable, "-m", "pyros1", "service", "call", topic, "true"], python="ours")
        listener.linked(f"{topic}/alive")
        assert not client.unread(f"^(answer|failed) {topic}"), "a call waits for its answer"
    client.event("answer", topic, timeout=60)
    assert tool.wait(60) == 0, f"after {time.monotonic() - began:.1f} s\n{tool.transcript()}"


def tool(master: Master, *words: str) -> Process:
    return master.run([sys.executable, "-m", "pyros1", *words], python="ours", label=" ".join(words))


@pytest.mark.parametrize("master_kind", ["ours", "stock"])
def test_the_master(own_master: Callable[[str], Master], master_kind: str) -> None:
    master = own_master(master_kind)
    master.start()
    source, sink = master.ready_peer("roscpp", "source"), master.ready_peer("pyros1", "sink")
    back = master.ready_peer("pyros1", "back")
    source.advertise("/t", TEXT)
    sink.subscribe("/t", TEXT)
    sink.serve("/flip", FLIP)
    source.linked("/t")
    with contextlib.ExitStack() as stack:
        for process in master.core[:1]:
            stack.enter_context(stopped(process))
        assert source.publish("/t") == sink.received("/t"), "nodes go on"
        tools = [
            tool(master, *words.split())
            for words in (
                "topic list",
                "node info /sink",
                "topic echo /t",
            )
        ]
        late = master.peer("pyros1", "late")
        back.tell("pub", "/late", TEXT, 10, 0)
        late.wait_line(r"it accepts connections, but did not answer within 3 s \(was it stopped\?\)", 60)
        for each in tools[:2]:
            assert each.wait(60) in (1, 2)
            text = "\n".join(each.lines)
            assert "no answer from the master" in text and "stopped" in text and "Traceback" not in text
        assert source.publish("/t", 2) == sink.received("/t")
        for each in tools[2:]:
            until(lambda each=each: each.lines or each.child.poll() is not None, each.label, 60)  # type: ignore[misc]
            assert "Traceback" not in "\n".join(each.lines), each.transcript()
    assert late.event("ready", timeout=60) == "/late"
    back.event("advertised", "/late", timeout=60)
    late.subscribe("/late", TEXT)
    back.linked("/late")
    late.available("/flip")
    late.call("/flip", FLIP)
    for each in tools[2:]:
        each.signal(signal.SIGINT)
