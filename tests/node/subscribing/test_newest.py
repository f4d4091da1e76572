"""Many messages in one receive, and callbacks that are slow: the newest come, the others are counted."""

from __future__ import annotations

import struct
import threading
from typing import Any

import pytest

from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node.subscribing.delivery_loop import MAX_CALLBACK_TIME
from pyros1.node.subscribing.queues import Items
from pyros1.node.subscribing.tcp_source import TcpSource

MANY = 100


def frames(*numbers: int) -> bytes:
    return b"".join(struct.pack("<Id", 8, number) for number in numbers)


def fall_behind(got: Any) -> None:
    """Take longer with the first message than callbacks may that keep up."""
    if len(got.items) == 1:
        threading.Event().wait(2 * MAX_CALLBACK_TIME)


@pytest.fixture(params=["buffer", "items"])
def received(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Let links receive frames in a buffer, or items like links with shared memory."""
    if request.param == "items":

        def as_items(link: TcpSource, frames: list[tuple[int, int]]) -> Items:
            return Items(link, link.buffer.take_bodies(frames))

        monkeypatch.setattr(TcpSource, "batch", as_items)
    return str(request.param)


@pytest.mark.parametrize("size", [1, 3, MANY - 2, MANY - 1, MANY, 2 * MANY])
def test_of_many_frames_in_one_receive_the_newest_come(
    make_node: Any, fake_node: Any, collect: Any, received: str, size: int
) -> None:
    fake, got = fake_node("/fake"), collect()
    fake.publish("/t")

    def slow(message: Any) -> None:
        got(message)
        fall_behind(got)

    subscriber = make_node("listener").subscribe("t", Float64, slow, queue_size=size)
    sock = fake.accept_subscriber()
    sock.sendall(frames(*range(MANY)))
    assert got.until(lambda items: items and items[-1].data == MANY - 1), got.data
    expected = [0, *range(1, MANY)[-size:]]
    assert got.data == expected
    assert subscriber.dropped == MANY - len(expected)


@pytest.mark.parametrize("size", [1, 3])
def test_of_what_comes_while_a_callback_runs_the_newest_come(
    make_node: Any, fake_node: Any, collect: Any, received: str, size: int
) -> None:
    fake, got, entered, go_on = fake_node("/fake"), collect(), threading.Event(), threading.Event()
    fake.publish("/t")

    def slow(message: Any) -> None:
        got(message)
        entered.set()
        go_on.wait(10)
        fall_behind(got)

    subscriber = make_node("listener").subscribe("t", Float64, slow, queue_size=size)
    sock = fake.accept_subscriber()
    sock.sendall(frames(0))
    assert entered.wait(10)
    for first in range(1, MANY, 10):
        sock.sendall(frames(*range(first, first + 10)))
    go_on.set()
    assert got.until(lambda items: items[-1].data == MANY), got.data
    assert got.data[-size:] == list(range(MANY + 1))[-size:]
    assert got.data == sorted(got.data)
    assert subscriber.dropped == MANY + 1 - len(got.data) > MANY // 2


def test_publishers_that_send_much_at_once_take_turns(make_node: Any, fake_node: Any, collect: Any) -> None:
    """The newest of each come, however many the other sends."""
    fakes, got, entered, go_on = [fake_node("/a"), fake_node("/b")], collect(), threading.Event(), threading.Event()

    def slow(message: Any) -> None:
        got(message)
        entered.set()
        go_on.wait(10)
        fall_behind(got)

    for fake in fakes:
        fake.publish("/t")
    make_node("listener").subscribe("t", Float64, slow, queue_size=2)
    many, few = (fake.accept_subscriber() for fake in fakes)
    many.sendall(frames(0))
    assert entered.wait(10)
    many.sendall(frames(*range(1, MANY)))
    few.sendall(frames(-3, -2, -1))
    go_on.set()
    assert got.until(lambda items: {MANY - 2, MANY - 1, -2, -1} <= {item.data for item in items}), got.data


def test_a_node_that_spins_gets_the_newest_of_one_receive(
    make_node: Any, fake_node: Any, collect: Any, received: str, until: Any
) -> None:
    node, got, fake = make_node("listener", callbacks="spin"), collect(), fake_node("/fake")
    fake.publish("/t")
    subscriber = node.subscribe("t", Float64, got, queue_size=3)
    fake.accept_subscriber().sendall(frames(*range(MANY)))
    until(lambda: subscriber.dropped == MANY - 3)
    assert node.spin_once(10.0) == 3, "no more calls wait than messages"
    assert got.data == [MANY - 3, MANY - 2, MANY - 1]
