"""timeouts: receives and sends that end in time."""

from __future__ import annotations

import socket

import pytest

from pyros1.net.timeouts import WaitOver, bound_waits


def test_a_receive_ends_and_goes_on_later() -> None:
    near, far = socket.socketpair()
    with near, far:
        bound_waits(near, 0.01)
        with pytest.raises(WaitOver):
            near.recv(10)
        far.send(b"x")
        assert near.recv(10) == b"x"


def test_a_send_ends() -> None:
    near, far = socket.socketpair()
    with near, far:
        bound_waits(near, 0.01)
        with pytest.raises(WaitOver):
            while True:
                near.send(bytes(100_000))
