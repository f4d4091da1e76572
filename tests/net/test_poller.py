"""poller: threads that wait for many sockets together, with epoll and with the portable fallback."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from pyros1.net.poller import WAKE, Poller


@pytest.fixture(params=["best", "portable"])
def poller(request: pytest.FixtureRequest) -> Iterator[Poller]:
    poller = Poller(portable=request.param == "portable")
    yield poller
    poller.close()


@pytest.fixture
def pair() -> Iterator[tuple[socket.socket, socket.socket]]:
    near, far = socket.socketpair()
    yield near, far
    near.close()
    far.close()


def test_a_readable_socket_is_returned_once_until_it_is_rearmed(poller: Poller, pair: Any) -> None:
    near, far = pair
    poller.register(near.fileno())
    far.send(b"x")
    assert poller.wait() == near.fileno()
    assert poller.wait(0.01) is None
    poller.rearm(near.fileno())
    assert poller.wait() == near.fileno()


def test_the_end_of_a_peer_is_readable(poller: Poller, pair: Any) -> None:
    near, far = pair
    poller.register(near.fileno())
    far.close()
    assert poller.wait() == near.fileno()


def test_each_wake_ends_one_wait(poller: Poller) -> None:
    poller.wake()
    poller.wake()
    assert [poller.wait(), poller.wait()] == [WAKE, WAKE]
    assert poller.wait(0.01) is None


def test_wakes_never_block(poller: Poller) -> None:
    for _ in range(100_000):
        poller.wake()
    assert poller.wait() == WAKE


def test_threads_share_the_events(poller: Poller) -> None:
    pairs = [socket.socketpair() for _ in range(8)]
    got: list[int | None] = []
    threads = [threading.Thread(target=lambda: got.append(poller.wait(10))) for _ in range(9)]
    for near, _ in pairs:
        poller.register(near.fileno())
    for thread in threads:
        thread.start()
    for _, far in pairs:
        far.send(b"x")
    poller.wake()
    for thread in threads:
        thread.join(10)
    assert sorted(map(str, got)) == sorted(map(str, [WAKE, *(near.fileno() for near, _ in pairs)]))
    for near, far in pairs:
        poller.unregister(near.fileno())
        near.close()
        far.close()


def test_sockets_can_be_added_and_rearmed_while_a_thread_waits(poller: Poller, pair: Any) -> None:
    near, far = pair
    got: list[int | None] = []
    far.send(b"x")
    for change in (poller.register, poller.rearm):
        thread = threading.Thread(target=lambda: got.append(poller.wait(10)))
        thread.start()
        change(near.fileno())
        thread.join(10)
    assert got == [near.fileno(), near.fileno()]


def test_a_socket_can_be_removed_while_a_thread_waits_for_ever(poller: Poller, pair: Any) -> None:
    near, far = pair
    got: list[int | None] = []
    poller.register(near.fileno())
    thread = threading.Thread(target=lambda: got.append(poller.wait()))
    thread.start()
    remover = threading.Thread(target=poller.unregister, args=(near.fileno(),))
    remover.start()
    remover.join(5)
    removed = not remover.is_alive()
    far.send(b"x")
    poller.wake()
    thread.join(10)
    remover.join(10)
    assert removed and got == [WAKE]


def test_unregistered_sockets_are_not_returned(poller: Poller, pair: Any) -> None:
    near, far = pair
    poller.register(near.fileno())
    poller.unregister(near.fileno())
    far.send(b"x")
    assert poller.wait(0.01) is None


def test_wake_after_close() -> None:
    poller = Poller()
    poller.close()
    poller.wake()


def test_sockets_are_given_up_after_close(pair: Any) -> None:
    """By a thread that ends its work for a node that has ended."""
    for portable in (False, True):
        poller = Poller(portable=portable)
        poller.register(pair[0].fileno())
        poller.close()
        poller.unregister(pair[0].fileno())
