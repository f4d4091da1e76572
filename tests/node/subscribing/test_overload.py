"""What happens to a subscription whose callbacks are slow, wrong, or many at once."""

from __future__ import annotations

import sys
import threading
from typing import Any

import pytest

from pyros1.msgs import load_message

from ...parts import subscription_of

Float64: Any = load_message("std_msgs/Float64")
Image: Any = load_message("sensor_msgs/Image")


@pytest.mark.parametrize("change", [None, b"", bytes(5 << 20)])
def test_a_callback_may_change_a_large_message(make_node: Any, transport: str, collect: Any, change: Any) -> None:
    talker, listener, got = make_node("talker"), make_node("listener"), collect()

    def heard(message: Any) -> None:
        message.data = change
        got(message)

    listener.subscribe("t", Image, heard)
    publisher = talker.advertise("t", Image, queue_size=10)
    assert publisher.wait_for_subscribers(timeout=20)
    for number in range(5):
        publisher.publish(Image(width=number, data=bytes(1 << 20)))
        got.wait(number + 1)
    assert [message.width for message in got.items] == list(range(5))


@pytest.mark.parametrize("transport", ["tcp"], indirect=True)  # within a process what waits is one queue
def test_an_overloaded_subscription_serves_every_publisher_and_new_subscribers(
    make_node: Any, transport: str, collect: Any, in_thread: Any
) -> None:
    fast, rare, listener = make_node("fast"), make_node("rare"), make_node("listener")
    entered, go_on, ended, slow = threading.Event(), threading.Event(), threading.Event(), collect()

    def heard(message: Any) -> None:
        slow(message)
        entered.set()
        go_on.wait(0.003)  # longer than messages take to come, all through the test

    listener.subscribe("t", Float64, heard, queue_size=3)
    flood = fast.advertise("t", Float64, queue_size=10)
    assert flood.wait_for_subscribers(timeout=20)

    def publish() -> None:
        while not ended.wait(0.0005):
            flood.publish(1)

    in_thread(publish)
    assert entered.wait(5)
    late = collect()
    listener.subscribe("t", Float64, late, queue_size=3)
    late.wait(1)
    publisher = rare.advertise("t", Float64, queue_size=1)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(-1)
    try:
        assert slow.until(lambda items: any(message.data == -1 for message in items))
    finally:
        ended.set()
        go_on.set()


@pytest.mark.slow
def test_a_thousand_subscriptions_are_woken_at_once(make_node: Any, collect: Any) -> None:
    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    count = 500
    publishers = [talker.advertise(f"t{i}", Float64, queue_size=1) for i in range(count)]
    for i in range(count):
        listener.subscribe(f"t{i}", Float64, got, queue_size=1)
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=10)
    for number, publisher in enumerate(publishers):
        publisher.publish(number)
    assert sorted(got.wait(count), key=lambda message: message.data)[-1].data == count - 1


def test_sys_exit_in_a_callback_is_told_and_costs_no_message(
    make_node: Any, transport: str, collect: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    talker, listener, got = make_node("talker"), make_node("listener"), collect()

    def heard(message: Any) -> None:
        got(message)
        sys.exit(1)

    listener.subscribe("t", Float64, heard)
    publisher = talker.advertise("t", Float64, queue_size=10)
    assert publisher.wait_for_subscribers(timeout=20)
    for number in range(3):
        publisher.publish(number)
    assert got.wait(3) and got.data == [0, 1, 2]
    assert "call node.shutdown()" in capsys.readouterr().err


def test_a_publisher_that_went_leaves_no_latched_message(make_node: Any, transport: str, collect: Any) -> None:
    listener, got, late = make_node("listener"), collect(), collect()
    listener.subscribe("t", Float64, got)
    subscription, changed = subscription_of(listener), threading.Event()
    subscription.change_listeners.append(changed.set)
    for number in range(3):
        talker = make_node(f"talker{number}")
        talker.advertise("t", Float64, latch=True).publish(number)
        got.wait(number + 1)
        talker.shutdown()
    while subscription.links:
        assert changed.wait(20)
        changed.clear()
    done = threading.Event()
    listener.subscribe("t", Float64, late)
    subscription.delivery.submit(done.set)
    assert done.wait(20) and late.items == []


def test_a_node_with_callbacks_that_do_not_return_ends_in_time(
    make_node: Any, transport: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.topics.MAX_CALLBACK_WAIT", 0.2)
    talker, listener = make_node("talker"), make_node("listener")
    entered, go_on = threading.Barrier(6, timeout=10), threading.Event()

    def heard(_: Any) -> None:
        entered.wait()
        go_on.wait()

    publishers = [talker.advertise(f"t{i}", Float64, queue_size=1) for i in range(5)]
    for i, publisher in enumerate(publishers):
        listener.subscribe(f"t{i}", Float64, heard)
        assert publisher.wait_for_subscribers(timeout=20)
        publisher.publish(1)
    entered.wait()
    listener.shutdown()  # returns although no callback has
    assert not listener.ok() and not go_on.is_set()
    go_on.set()
