"""readers: few threads for many subscriptions, and none that waits for another's callback."""

from __future__ import annotations

import threading
import time
from typing import Any

import pytest

from pyros1.msgs import load_message
from pyros1.node import readers

Float64: Any = load_message("std_msgs/Float64")


def reader_threads(name: str) -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name.startswith(f"/{name}:reader")]


def test_idle_subscriptions_share_two_threads(
    make_node: Any, transport: str, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(readers, "REST", 0.01)
    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    count = 60
    publishers = [talker.advertise(f"t{i}", Float64, queue_size=1) for i in range(count)]
    for i in range(count):
        listener.subscribe(f"t{i}", Float64, got)
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=5)
    for i, publisher in enumerate(publishers):
        publisher.publish(i)
        got.wait(i + 1)
    assert got.data == list(range(count))
    for thread in reader_threads("listener")[readers.SPARE + 1 :]:  # on a busy machine one may have been started
        thread.join(10)
    assert len(reader_threads("listener")) <= readers.SPARE + 1


def test_as_many_callbacks_as_topics_run_at_once(make_node: Any, transport: str) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    count = 8
    together = threading.Barrier(count + 1, timeout=10)
    publishers = [talker.advertise(f"t{i}", Float64, queue_size=1) for i in range(count)]
    for i in range(count):
        listener.subscribe(f"t{i}", Float64, lambda _: together.wait())
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=5)
        publisher.publish(1)
    together.wait()  # breaks if one of them has to wait for another


def test_threads_that_are_not_needed_any_more_end(
    make_node: Any, transport: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(readers, "REST", 0.01)
    test_as_many_callbacks_as_topics_run_at_once(make_node, transport)
    end = time.monotonic() + 10
    while len(alive := reader_threads("listener")) > readers.SPARE + 1:
        assert time.monotonic() < end, f"{len(alive)} threads are left"
        alive[0].join(0.01)  # which of them rest is not known


def test_a_fault_does_not_end_a_thread(make_node: Any, collect: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    listener, talker, got = make_node("listener"), make_node("talker"), collect()
    subscriber = listener.subscribe("t", Float64, got)
    errors: list[Exception] = []
    noticed = threading.Event()
    monkeypatch.setattr(listener._context.readers, "_on_error", lambda error: (errors.append(error), noticed.set()))

    def fail() -> None:
        raise RuntimeError("a fault")

    subscriber._subscription.reader.submit(fail)
    assert noticed.wait(5) and str(errors[0]) == "a fault"
    publisher = talker.advertise("t", Float64, queue_size=1)
    assert publisher.wait_for_subscribers(timeout=5)
    publisher.publish(1)
    got.wait(1)
