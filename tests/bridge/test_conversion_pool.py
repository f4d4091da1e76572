"""The threads that convert: only the newest of each publisher, and only what is wanted."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from tests.bodies import decode, encode

from pyros1.bridge.conversion_pool import ConversionPool, PendingMessage, Source
from pyros1.bridge.conversions.conversion import Conversion
from pyros1.bridge.exchange.outgoing import DropReason, ReceivedMessage
from pyros1.msgs.sensor_msgs.msg import LaserScan, PointCloud2

from .conftest import PATIENCE

SCAN: Source = ("/scan", Conversion("every", 2.0))
OTHER: Source = ("/other", Conversion("every", 2.0))


def pending(number: int, publisher: str = "/laser", **changes: Any) -> PendingMessage:
    scan = LaserScan(scan_time=number, ranges=(1.0, 2.0, 3.0))
    received = ReceivedMessage(publisher, LaserScan._md5sum, False, encode(scan))
    return PendingMessage(received, "sensor_msgs/LaserScan", False, float(number))._replace(**changes)


class ConversionSink:
    """Notes what comes; pool stops at `would_send` while the gate is closed."""

    def __init__(self) -> None:
        self.events: queue.Queue[tuple[Any, ...]] = queue.Queue()
        self.gate = threading.Event()
        self.gate.set()
        self.answer = True
        self.asked: queue.Queue[float] = queue.Queue()

    def would_send(self, source: Source, pending: PendingMessage) -> bool:
        self.asked.put(pending.at)
        assert self.gate.wait(PATIENCE)
        return self.answer

    def send(self, source: Source, pending: PendingMessage) -> None:
        scan = decode(LaserScan, pending.received.body)
        self.events.put(("sent", source[0], pending.received.publisher, scan.scan_time, scan.ranges, pending.at))

    def drop(self, source: Source, publisher: str, reason: str) -> None:
        self.events.put(("dropped", source[0], publisher, reason))

    def next(self) -> tuple[Any, ...]:
        return self.events.get(timeout=PATIENCE)


@pytest.fixture
def sink() -> ConversionSink:
    return ConversionSink()


@pytest.fixture
def pool(sink: ConversionSink) -> Iterator[ConversionPool]:
    mistakes: list[Exception] = []
    pool = ConversionPool(sink, mistakes.append)
    pool.start(SCAN)
    yield pool
    sink.gate.set()
    pool.close()
    assert not mistakes
    assert not [thread for thread in threading.enumerate() if thread.name == "bridge: conversions"]


def test_a_message(pool: ConversionPool, sink: ConversionSink) -> None:
    pool.put(SCAN, pending(5))
    assert sink.next() == ("sent", "/scan", "/laser", 5.0, (1.0, 3.0), 5.0)


def test_a_topic_whose_type_changes(pool: ConversionPool, sink: ConversionSink) -> None:
    cloud = ReceivedMessage("/cloud", PointCloud2._md5sum, False, encode(PointCloud2()))
    sink.gate.clear()
    sink.answer = False  # its converter is made, but nothing is sent
    pool.put(SCAN, PendingMessage(cloud, "sensor_msgs/PointCloud2", False, 1.0))
    assert sink.asked.get(timeout=PATIENCE) == 1.0
    sink.gate.set()
    pool.put(SCAN, pending(4))
    assert sink.asked.get(timeout=PATIENCE) == 4.0  # now it has dealt with the cloud
    sink.answer = True
    pool.put(SCAN, pending(5))
    while (event := sink.next()) != ("sent", "/scan", "/laser", 5.0, (1.0, 3.0), 5.0):
        assert event == ("sent", "/scan", "/laser", 4.0, (1.0, 3.0), 4.0)


def test_only_the_newest_of_each_publisher_waits(pool: ConversionPool, sink: ConversionSink) -> None:
    sink.gate.clear()
    pool.put(SCAN, pending(1))
    assert sink.asked.get(timeout=PATIENCE) == 1
    for number in (2, 3, 4):
        pool.put(SCAN, pending(number))
    pool.put(SCAN, pending(9, "/second"))
    assert [sink.next() for _ in range(2)] == [("dropped", "/scan", "/laser", DropReason.OVERTAKEN)] * 2
    assert sink.events.empty(), "one source is converted by one thread at a time"
    sink.gate.set()
    assert [sink.next()[2:4] for _ in range(3)] == [("/laser", 1.0), ("/laser", 4.0), ("/second", 9.0)]


def test_a_slow_topic_does_not_hold_up_another_one(pool: ConversionPool, sink: ConversionSink) -> None:
    pool.start(OTHER)
    sink.gate.clear()
    pool.put(SCAN, pending(1))
    pool.put(OTHER, pending(2))
    assert {sink.asked.get(timeout=PATIENCE) for _ in range(2)} == {1, 2}


def test_what_is_not_wanted_is_not_converted(pool: ConversionPool, sink: ConversionSink) -> None:
    sink.answer = False
    pool.put(SCAN, pending(1, received=ReceivedMessage("/laser", LaserScan._md5sum, False, b"nonsense")))
    assert sink.asked.get(timeout=PATIENCE) == 1
    pool.put(SCAN, pending(2))
    assert sink.asked.get(timeout=PATIENCE) == 2
    assert sink.events.empty()


def test_what_cannot_be_converted(pool: ConversionPool, sink: ConversionSink) -> None:
    pool.put(SCAN, pending(1, received=ReceivedMessage("/laser", LaserScan._md5sum, False, b"nonsense")))
    assert sink.next() == ("dropped", "/scan", "/laser", DropReason.UNCONVERTED)
    assert {*pool.problems} == {"/scan"}
    pool.put(SCAN, pending(2))
    assert sink.next()[0] == "sent"
    assert not pool.problems


def test_another_type(pool: ConversionPool, sink: ConversionSink) -> None:
    pool.put(SCAN, pending(1, type="std_msgs/String"))
    assert sink.next() == ("dropped", "/scan", "/laser", DropReason.TYPE)
    pool.put(SCAN, pending(2, received=ReceivedMessage("/laser", "0" * 32, False, b"")))
    assert sink.next() == ("dropped", "/scan", "/laser", DropReason.TYPE)


def test_too_many_publishers(pool: ConversionPool, sink: ConversionSink) -> None:
    sink.gate.clear()
    pool.put(SCAN, pending(1, "/first"))
    assert sink.asked.get(timeout=PATIENCE) == 1
    for number in range(101):
        pool.put(SCAN, pending(2, f"/laser{number}"))
    assert sink.next() == ("dropped", "/scan", "/laser100", DropReason.PUBLISHERS)
    assert sink.events.empty()


def test_a_topic_that_is_not_wanted_any_more(pool: ConversionPool, sink: ConversionSink) -> None:
    sink.gate.clear()
    pool.put(SCAN, pending(1))
    assert sink.asked.get(timeout=PATIENCE) == 1
    pool.put(SCAN, pending(2))
    pool.stop(SCAN)
    pool.put(SCAN, pending(3))
    pool.restart(SCAN)
    sink.gate.set()
    assert sink.next()[3] == 1.0
    pool.start(SCAN)
    pool.put(SCAN, pending(4))
    assert sink.next()[3] == 4.0, "what waited is forgotten"


def test_a_topic_that_is_wanted_again_before_its_turn(pool: ConversionPool, sink: ConversionSink) -> None:
    others: list[Source] = [(name, SCAN[1]) for name in ("/one", "/two")]
    sink.gate.clear()
    for source in others:
        pool.start(source)
        pool.put(source, pending(1))
        assert sink.asked.get(timeout=PATIENCE) == 1
    pool.put(SCAN, pending(2))
    pool.stop(SCAN)
    pool.start(SCAN)
    sink.gate.set()
    assert {sink.next()[1] for _ in others} == {"/one", "/two"}
    for source in (SCAN, *others):
        pool.put(source, pending(3))
    assert [sink.next()[3] for _ in range(3)] == [3.0] * 3


def test_problems_of_topics_that_are_not_wanted_any_more(pool: ConversionPool, sink: ConversionSink) -> None:
    pool.put(SCAN, pending(1, received=ReceivedMessage("/laser", LaserScan._md5sum, False, b"nonsense")))
    assert sink.next() == ("dropped", "/scan", "/laser", DropReason.UNCONVERTED)
    pool.stop(SCAN)
    assert not pool.problems


class FailingSink(ConversionSink):
    """An sink with a mistake."""

    def would_send(self, source: Source, pending: PendingMessage) -> bool:
        raise RuntimeError("a mistake")


def test_a_mistake_does_not_end_the_threads() -> None:
    mistakes: queue.Queue[Exception] = queue.Queue()
    pool = ConversionPool(FailingSink(), mistakes.put)
    pool.start(SCAN)
    for number in range(5):
        pool.put(SCAN, pending(number))
        assert isinstance(mistakes.get(timeout=PATIENCE), RuntimeError)
    pool.close()
