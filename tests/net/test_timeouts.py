"""timeouts: receives and sends that end in time, and how long data may take."""

from __future__ import annotations

import socket

import pytest

from pyros1.net import timeouts
from pyros1.net.timeouts import SOCKET_TIMEOUTS, TransferDeadline, limit_unsent, set_socket_timeouts


def test_a_receive_ends_and_goes_on_later() -> None:
    near, far = socket.socketpair()
    with near, far:
        set_socket_timeouts(near, 0.01)
        with pytest.raises(SOCKET_TIMEOUTS):
            near.recv(10)
        far.send(b"x")
        assert near.recv(10) == b"x"


def test_a_send_ends() -> None:
    near, far = socket.socketpair()
    with near, far:
        set_socket_timeouts(near, 0.01)
        with pytest.raises(SOCKET_TIMEOUTS):
            while True:
                near.send(bytes(100_000))


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [100.0]
    monkeypatch.setattr(timeouts, "monotonic", lambda: now[0])
    return now


def test_data_that_move_may_take_long(clock: list[float]) -> None:
    patience = TransferDeadline(10.0)
    for _ in range(100):  # 10 kB/s
        clock[0] += 5.0
        patience.add_bytes(50_000)
    assert patience.remaining() == 10.0


def test_data_that_stop_are_given_up(clock: list[float]) -> None:
    patience = TransferDeadline(10.0)
    assert patience.remaining() == 10.0
    patience.add_bytes(1_000_000)
    clock[0] += 9.0
    assert patience.remaining() == 1.0
    clock[0] += 1.0
    assert patience.remaining() <= 0


def test_data_that_trickle_are_given_up(clock: list[float]) -> None:
    patience = TransferDeadline(10.0)
    while patience.remaining() > 0:
        clock[0] += 0.1
        patience.add_bytes(10)
        assert clock[0] < 112.0
    assert clock[0] > 110.0


def test_a_sender_sees_how_its_data_go() -> None:
    """The system takes a little more than what the other side reads, not all that its buffers could hold."""
    with (
        socket.create_server(("127.0.0.1", 0)) as listener,
        socket.create_connection(listener.getsockname()) as near,
        listener.accept()[0] as far,
    ):
        far.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        limit_unsent(near)
        near.setblocking(False)
        sent = 0
        with pytest.raises(BlockingIOError):
            while sent < 100_000_000:
                sent += near.send(bytes(10_000))
        assert sent < 1_000_000
