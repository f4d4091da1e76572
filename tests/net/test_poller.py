"""poller: waiting for many sockets, with epoll and with the portable fallback."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from pyros1.net.poller import Poller


@pytest.fixture(params=["epoll", "selectors"])
def poller(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[Poller]:
    if request.param == "selectors":
        monkeypatch.delattr("select.epoll", raising=False)
        # selectors.DefaultSelector may be the one that has just lost its foundation
        import selectors

        monkeypatch.setattr("selectors.DefaultSelector", getattr(selectors, "PollSelector", selectors.SelectSelector))
    poller = Poller()
    yield poller
    poller.close()


@pytest.fixture
def pair() -> Iterator[tuple[socket.socket, socket.socket]]:
    near, far = socket.socketpair()
    yield near, far
    near.close()
    far.close()


def test_readable_sockets_are_returned(poller: Poller, pair: Any) -> None:
    near, far = pair
    poller.register(near.fileno())
    far.send(b"x")
    for _ in range(2):  # as long as there is something to read
        assert [fd for fd, _ in poller.wait()] == [near.fileno()]
    assert near.recv(10) == b"x"


def test_the_end_of_a_peer_is_readable(poller: Poller, pair: Any) -> None:
    near, far = pair
    poller.register(near.fileno())
    far.close()
    assert [fd for fd, _ in poller.wait()] == [near.fileno()]


def test_wake_before_and_during_a_wait(poller: Poller) -> None:
    poller.wake()
    assert poller.wait() == []
    results: list[Any] = []
    thread = threading.Thread(target=lambda: results.append(poller.wait()))
    thread.start()
    poller.wake()
    thread.join(5)
    assert results == [[]]


def test_wakes_are_gathered_and_never_block(poller: Poller, pair: Any) -> None:
    for _ in range(20_000):  # far more than the pipe holds
        poller.wake()
    near, far = pair
    poller.register(near.fileno())
    far.send(b"x")
    seen: list[int] = []
    while near.fileno() not in seen:
        seen += [fd for fd, _ in poller.wait()]


def test_a_wake_does_not_hide_a_socket(poller: Poller, pair: Any) -> None:
    near, far = pair
    poller.register(near.fileno())
    far.send(b"x")
    poller.wake()
    seen = {fd for fd, _ in poller.wait()}
    assert seen <= {near.fileno()}
    assert {fd for fd, _ in poller.wait()} == {near.fileno()}


def test_unregistered_sockets_are_not_returned(poller: Poller, pair: Any) -> None:
    near, far = pair
    poller.register(near.fileno())
    poller.unregister(near.fileno())
    far.send(b"x")
    poller.wake()
    assert poller.wait() == []


def test_wake_after_close_is_harmless() -> None:
    poller = Poller()
    poller.close()
    poller.wake()
