"""deadline: word of messages that do not come.

Feature: notification when messages stop coming -- `subscribe(..., deadline=0.5, on_missed=...)`, in the node's time
"""

from __future__ import annotations

import threading
from typing import Any

import pytest

from pyros1.ground.timing import Time
from pyros1.msgs.rosgraph_msgs.msg import Clock
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node.subscribing.deadline import Missed

from ...parts import on_loop, subscription_of

SHORT = 0.05


def test_once_for_each_gap(make_node: Any, transport: str, collect: Any) -> None:
    got, missed = collect(), collect()
    talker, node = make_node("talker"), make_node("node")
    publisher = talker.advertise("t", Float64)
    node.subscribe("t", Float64, got, deadline=SHORT, on_missed=missed)
    for gap in range(1, 3):
        (*_, last) = missed.wait(gap)
        assert (last.topic, last.publishers) == ("/t", ("/talker",)) and last.silent >= SHORT
        missed.until(lambda items, gap=gap: len(items) > gap, timeout=4 * SHORT)
        assert len(missed.items) == gap
        publisher.publish(gap)
        got.wait(gap)
    missed.wait(3)
    assert str(Missed("/t", 0.5, ("/a", "/b"))) == "no message on /t for 0.5 s, from /a, /b"
    assert str(Missed("/t", 0.5, ())) == "no message on /t for 0.5 s, no publisher"
    talker.shutdown()
    assert not missed.until(lambda items: len(items) > 3, timeout=4 * SHORT), "still the same gap"


def test_nothing_is_missed_before_a_publisher_is_there(make_node: Any, collect: Any) -> None:
    missed = collect()
    node = make_node("node")
    node.subscribe("t", Float64, lambda _: None, deadline=SHORT, on_missed=missed)
    assert not missed.until(bool, timeout=4 * SHORT)
    make_node("talker").advertise("t", Float64)
    (first,) = missed.wait()
    assert first.publishers == ("/talker",)


def test_a_publisher_that_is_there_already(make_node: Any, collect: Any) -> None:
    first, second, missed = collect(), collect(), collect()
    node = make_node("node")
    make_node("talker").advertise("t", Float64, latch=True).publish(1)
    node.subscribe("t", Float64, first)
    first.wait()
    node.subscribe("t", Float64, second, deadline=SHORT, on_missed=missed)
    assert second.wait() and missed.wait()


def test_a_publisher_that_ended(make_node: Any, collect: Any) -> None:
    got, missed = collect(), collect()
    talker = make_node("talker")
    publisher = talker.advertise("t", Float64)
    make_node("node").subscribe("t", Float64, got, deadline=0.3, on_missed=missed)
    assert publisher.wait_for_subscribers(timeout=10)
    publisher.publish(1)
    got.wait()
    talker.shutdown()
    # On a busy machine the first message may have been late, too.
    assert missed.until(lambda items: items and items[-1].publishers == ())


def test_with_unregister_all_ends(make_node: Any, collect: Any) -> None:
    node = make_node("node")
    make_node("talker").advertise("t", Float64)
    node.subscribe("t", Float64, lambda _: None)
    for deadline in (0.2, 1.0, 5.0):  # on a busy machine the first ones may pass before the end
        missed = collect()
        subscriber = node.subscribe("t", Float64, lambda _: None, deadline=deadline, on_missed=missed)
        assert subscriber.wait_for_publishers(timeout=10)
        subscriber.unregister()
        on_loop(node)
        if not missed.items:
            break
    assert len(subscription_of(node).change_listeners) == 0
    assert not missed.until(bool, timeout=deadline + 0.1)


def test_in_the_thread_that_spins_and_not_while_messages_wait_for_it(make_node: Any, until: Any) -> None:
    node = make_node("node", callbacks="spin")
    make_node("talker").advertise("t", Float64, latch=True).publish(1)
    told: list[Any] = []
    node.subscribe("t", Float64, told.append, queue_size=10, deadline=0.1, on_missed=told.append)
    until(lambda: subscription_of(node).delivery.waiting)
    threading.Event().wait(0.3)  # the program computes, and its deadline passes
    node.spin_once()
    assert [message.data for message in told] == [1]
    while len(told) < 2:
        node.spin_once(5.0)
    assert isinstance(told[1], Missed) and told[1].silent >= 0.1


def test_simulated_time_that_stands_still_misses_nothing(make_node: Any, master: Any, collect: Any) -> None:
    simulator = make_node("simulator")
    simulator.params["/use_sim_time"] = True
    ticks = simulator.advertise("/clock", Clock)
    got, missed = collect(), collect()
    node = make_node("node")
    publisher = simulator.advertise("t", Float64)
    node.subscribe("t", Float64, got, deadline=1.0, on_missed=missed)
    assert ticks.wait_for_subscribers(timeout=10) and publisher.wait_for_subscribers(timeout=10)
    on_loop(node)

    def tick(seconds: float) -> None:
        ticks.publish(Clock(Time.from_sec(seconds)))
        while node.now() != Time.from_sec(seconds):
            node.sleep(0)

    tick(1000.0)  # time begins
    publisher.publish(1)
    got.wait()
    for seconds in (1000.5, 1000.99, 500.0, 500.9):
        tick(seconds)
    assert not missed.until(bool, timeout=0.1)
    tick(501.0)
    assert missed.wait()[0].silent == pytest.approx(1.0)
    tick(600.0)
    assert len(missed.wait()) == 1


def test_callbacks_that_raise_are_named_and_hear_more(make_node: Any, watch_log: Any, collect: Any) -> None:
    node = make_node("node")
    log, missed = watch_log(node), collect()

    def broken_callback(message: Any) -> None:
        raise ZeroDivisionError

    def broken_missed(word: Missed) -> None:
        missed(word)
        raise ZeroDivisionError

    publisher = make_node("talker").advertise("t", Float64)
    node.subscribe("t", Float64, broken_callback, deadline=SHORT, on_missed=broken_missed)
    log.saw("bad function for deadline of /t", "ZeroDivisionError")
    publisher.publish(1)
    log.saw("bad callback", "broken_callback")
    missed.wait(2)


def test_a_callback_may_end_the_subscription_or_the_node(make_node: Any, collect: Any) -> None:
    node, done = make_node("node"), collect()
    make_node("talker").advertise("t", Float64)
    subscriber: Any = None

    def end(word: Missed) -> None:
        subscriber.unregister()
        node.shutdown()
        done(node.ok())

    subscriber = node.subscribe("t", Float64, lambda _: None, deadline=SHORT, on_missed=end)
    assert done.wait() == [False]


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"deadline": 0.5}, "deadline and on_missed belong together"),
        ({"on_missed": print}, "deadline and on_missed belong together"),
        ({"deadline": 0, "on_missed": print}, "subscribe: deadline must be above 0"),
        ({"deadline": "1", "on_missed": print}, "subscribe: deadline must be a number of s"),
        ({"deadline": 0.5, "on_missed": 5}, "subscribe: on_missed must be a function"),
    ],
)
def test_wrong_arguments(make_node: Any, options: Any, error: str) -> None:
    node = make_node("node")
    with pytest.raises((TypeError, ValueError), match=error):
        node.subscribe("t", Float64, lambda _: None, **options)
