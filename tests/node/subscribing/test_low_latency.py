"""Subscribers that look for the next message before they sleep: all messages come, and nobody else waits for them.

Feature: messages delivered without the delay of waking a thread -- `subscribe(..., low_latency=True)`
"""

from __future__ import annotations

import os
import threading
import time
from typing import Any

import pytest

from pyros1.msgs.std_msgs.msg import Float64
from pyros1.net import spin_wait
from pyros1.node.subscribing import tcp_source

pytestmark = pytest.mark.parametrize("transport", ["tcp", "local"], indirect=True)
PATIENCE = 20.0


@pytest.fixture(autouse=True)
def no_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let links poll at once, however busy the machine is."""
    monkeypatch.setattr(spin_wait, "CHECKED_PAUSE", 0.0)
    monkeypatch.setattr(spin_wait, "could_poll", lambda before, now: True)
    monkeypatch.setattr(spin_wait, "PREEMPTION_GAP", float("inf"))


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The threads that have looked in vain, once each time."""
    found: list[int] = []

    def give_way() -> None:
        found.append(threading.get_ident())
        os.sched_yield()

    monkeypatch.setattr(tcp_source, "yield_processor", give_way)
    return found


def test_all_messages_come(make_node: Any, collect: Any, transport: str, looks: list[int]) -> None:
    got = collect()
    publisher = make_node("talker").advertise("/t", Float64, queue_size=0)
    make_node("listener").subscribe("/t", Float64, got, low_latency=True)
    assert publisher.wait_for_subscribers(1, PATIENCE)
    for number in range(500):
        publisher.publish(float(number))
        if number % 100 == 0:
            got.wait(number + 1)
    assert [message.data for message in got.wait(500)] == [float(number) for number in range(500)]
    end, count = time.monotonic() + PATIENCE, 500
    while not looks:  # each message may have come before the thread was back from the one before
        assert time.monotonic() < end
        publisher.publish(0.0)
        count += 1
        got.wait(count)


def test_round_trips_by_callbacks(make_node: Any, transport: str, looks: list[int]) -> None:
    here, there, done = make_node("here"), make_node("there"), threading.Event()
    back = there.advertise("/back", Float64, queue_size=10)
    there.subscribe("/out", Float64, back.publish, low_latency=True)
    out = here.advertise("/out", Float64, queue_size=10)

    def again(message: Any) -> None:
        if message.data < 1000:
            out.publish(message.data + 1)
        else:
            done.set()

    here.subscribe("/back", Float64, again, low_latency=True)
    assert out.wait_for_subscribers(1, PATIENCE) and back.wait_for_subscribers(1, PATIENCE)
    out.publish(0.0)
    assert done.wait(PATIENCE)


def test_other_topics_go_on(make_node: Any, collect: Any, transport: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A thread that looks, here for long, holds up no other topic, no new subscriber and not the node's end."""
    monkeypatch.setattr(tcp_source, "BUSY_POLL_TIME", 0.3)
    talker, listener = make_node("talker"), make_node("listener")
    spins, other, late = collect(), collect(), collect()
    first, second = (talker.advertise(name, Float64, queue_size=10) for name in ("/eager", "/other"))
    listener.subscribe("/eager", Float64, spins, low_latency=True)
    listener.subscribe("/other", Float64, other)
    assert first.wait_for_subscribers(1, PATIENCE) and second.wait_for_subscribers(1, PATIENCE)
    for number in range(3):
        first.publish(float(number))
        spins.wait(number + 1)
    for number in range(50):
        second.publish(float(number))
    other.wait(50)
    first.publish(3.0)
    spins.wait(4)
    listener.subscribe("/eager", Float64, late)
    first.publish(4.0)
    spins.wait(5)
    assert late.wait(1)[0].data == 4.0
