"""fairness: publishers that never pause keep nobody waiting, whatever the kind of queue.

Feature: publishers that never pause do not starve others -- all kinds of queues
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.msgs.std_msgs.msg import Float64
from pyros1.net.loop import Loop

from ...bodies import encode_frame

PATIENCE = 20.0
KINDS = [(callbacks, size) for callbacks in ("inline", "spin") for size in (None, 1, 10)]


class Counts:
    """A slow callback that counts the messages by what is in them: the number of their publisher."""

    def __init__(self) -> None:
        self.counts: dict[float, int] = {}
        self._changed = threading.Condition()
        self._never = threading.Event()

    def __call__(self, message: Any) -> None:
        self._never.wait(20e-6)  # the work that a callback does
        with self._changed:
            self.counts[message.data] = self.counts.get(message.data, 0) + 1
            self._changed.notify_all()

    def wait(self, *numbers: float, more: int = 1) -> None:
        """Wait for some messages of each of these publishers."""
        with self._changed:
            self._wait({number: self.counts.get(number, 0) + more for number in numbers})

    def wait_for_first(self, number: float) -> None:
        """Wait for the first message of a publisher, which may have come already."""
        with self._changed:
            self._wait({number: 1})

    def _wait(self, goal: dict[float, int]) -> None:
        came = self._changed.wait_for(
            lambda: all(self.counts.get(number, 0) >= count for number, count in goal.items()), PATIENCE
        )
        assert came, f"{goal} of {self.counts}"


@pytest.fixture
def flood(fake_node: Any) -> Iterator[Callable[[float], None]]:
    """Return a function that starts a publisher of /t which keeps its socket full of messages with a number in them."""
    ended = threading.Event()
    threads: list[threading.Thread] = []

    def start(number: float) -> None:
        fake = fake_node(f"/flood{number:g}")
        fake.publish("/t")
        sock = fake.accept_subscriber()
        sock.settimeout(0.1)
        frames = encode_frame(Float64(number)) * 1000

        def send() -> None:
            rest = frames
            with contextlib.suppress(ConnectionError):
                while not ended.is_set():
                    with contextlib.suppress(TimeoutError):
                        rest = rest[sock.send(rest) :] or frames

        threads.append(threading.Thread(target=send))
        threads[-1].start()

    yield start
    ended.set()
    for thread in threads:
        thread.join()


@pytest.fixture(autouse=True)
def short_queues(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let few messages wait where nobody has set a bound: they only delay those behind them."""
    for module in ("delivery_loop", "dispatcher"):
        monkeypatch.setattr(f"pyros1.node.subscribing.{module}.UNBOUNDED_LIMIT", 50)


@pytest.fixture
def spinning(in_thread: Any) -> Iterator[Any]:
    """Return a function that lets a node spin in a thread."""
    nodes: list[Any] = []

    def spin(node: Any) -> None:
        nodes.append(node)
        in_thread(node.spin)

    yield spin
    for node in nodes:
        node.shutdown()


@pytest.mark.slow
@pytest.mark.parametrize(("callbacks", "queue_size"), KINDS)
def test_floods_starve_nobody(
    make_node: Any,
    fake_node: Any,
    flood: Any,
    spinning: Any,
    callbacks: str,
    queue_size: int | None,
) -> None:
    listener, got = make_node("listener", callbacks=callbacks), Counts()
    listener.subscribe("/t", Float64, got, queue_size=queue_size)
    spinning(listener)
    flood(1)
    flood(2)
    got.wait(1, 2, more=3)
    late = fake_node("/late")  # a new link
    late.publish("/t")
    late.accept_subscriber().sendall(encode_frame(Float64(3)))
    got.wait_for_first(3)
    inside = make_node("inside").advertise("/t", Float64)  # within the process
    assert inside.wait_for_subscribers(timeout=PATIENCE)
    inside.publish(4)
    got.wait_for_first(4)
    second = Counts()  # another subscriber of the same links
    listener.subscribe("/t", Float64, second, queue_size=queue_size)
    second.wait(1, 2)
    got.wait(1, 2, more=3)  # and the floods themselves


@pytest.mark.slow
@pytest.mark.parametrize(("callbacks", "queue_size"), KINDS)
@pytest.mark.parametrize("limit", [None, 10])
def test_floods_within_the_process_starve_nobody(
    make_node: Any,
    fake_node: Any,
    in_thread: Any,
    spinning: Any,
    callbacks: str,
    queue_size: int | None,
    limit: int | None,
) -> None:
    listener, got, ended = make_node("listener", callbacks=callbacks), Counts(), threading.Event()
    listener.subscribe("/t", Float64, got, queue_size=queue_size)
    spinning(listener)

    def publish(number: float) -> None:
        publisher = make_node(f"flood{number:g}").advertise("/t", Float64, queue_size=limit)
        assert publisher.wait_for_subscribers(timeout=PATIENCE)
        while not ended.is_set():
            publisher.publish(number)

    threads = [in_thread(publish, number) for number in (1, 2)]
    try:
        got.wait(1, 2, more=3)
        late = fake_node("/late")
        late.publish("/t")
        late.accept_subscriber().sendall(encode_frame(Float64(3)))
        got.wait_for_first(3)
        inside = make_node("inside").advertise("/t", Float64)
        assert inside.wait_for_subscribers(timeout=PATIENCE)
        inside.publish(4)
        got.wait_for_first(4)
    finally:
        ended.set()
        for thread in threads:
            thread.join()


@pytest.mark.parametrize(("callbacks", "queue_size"), KINDS)
def test_a_flood_of_datagrams_starves_nobody(
    make_node: Any, flood: Any, in_thread: Any, spinning: Any, callbacks: str, queue_size: int | None
) -> None:
    listener, got, ended = make_node("listener", callbacks=callbacks), Counts(), threading.Event()
    listener.subscribe("/t", Float64, got, queue_size=queue_size, transports=["udp", "tcp"])
    spinning(listener)
    publisher = make_node("datagrams").advertise("/t", Float64)

    def publish() -> None:
        while not ended.wait(20e-6):
            publisher.publish(1)

    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    thread = in_thread(publish)
    try:
        got.wait(1, more=3)
        flood(2)
        got.wait(2, more=3)
        got.wait(1, more=3)
    finally:
        ended.set()
        thread.join()


# The loop -------------------------------------------------------------------------------------------------------------


def test_calls_and_timers_that_queue_themselves_starve_no_socket() -> None:
    loop, served = Loop("test"), threading.Event()
    loop.start()

    def call() -> None:
        if not served.is_set():
            loop.call_soon(call)

    def timer() -> None:
        if not served.is_set():
            loop.call_later(0.0, timer)

    import socket

    near, far = socket.socketpair()
    try:
        loop.call_soon(call)
        loop.call_soon(timer)
        loop.run(loop.register, near, 1, lambda mask: served.set())
        far.send(b"x")
        assert served.wait(PATIENCE)
        loop.run(loop.unregister, near)
    finally:
        served.set()
        loop.stop()
        near.close()
        far.close()
