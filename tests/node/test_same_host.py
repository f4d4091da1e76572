"""same_host: Unix sockets between programs of one machine and one user."""

from __future__ import annotations

import os
import re
import socket

import pytest

from pyros1.node import same_host

pytestmark = pytest.mark.skipif(not same_host.host_key(), reason="no shared memory on this system")


def test_the_key_tells_nothing_of_the_machine() -> None:
    assert re.fullmatch("[0-9a-f]{32}", same_host.host_key())


def test_a_connection() -> None:
    listener, name = same_host.listen()
    with listener, same_host.connect(name) as near:
        far, _ = listener.accept()
        with far:
            assert same_host.is_same_user(near) and same_host.is_same_user(far)
            far.send(b"hello")
            assert near.recv(10) == b"hello" and not near.getblocking()


def test_a_name_that_one_wishes() -> None:
    wish = same_host.socket_name_for("rosrpc://here:1", os.urandom(8).hex())
    first, name = same_host.listen(wish)
    assert name == wish
    with first:
        for other in (wish, "pyros1-" + "x" * 200, "other-name", "pyros1-ü"):
            listener, name = same_host.listen(other)
            with listener, same_host.connect(name):
                assert name != other


@pytest.mark.parametrize("name", ["", "pyros1-nobody", "other-name", "pyros1-" + "x" * 200, "pyros1-\0", "pyros1-ü"])
def test_what_is_not_there(name: str) -> None:
    with pytest.raises(OSError):
        same_host.connect(name)


def test_another_user(monkeypatch: pytest.MonkeyPatch) -> None:
    listener, name = same_host.listen()
    user = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: user + 1)
    with listener, pytest.raises(PermissionError, match="another user"):
        same_host.connect(name)


def test_too_many_that_wait() -> None:
    listener, name = same_host.listen()
    waiting: list[socket.socket] = []
    with listener:
        with pytest.raises(BlockingIOError):
            for _ in range(1000):
                waiting.append(same_host.connect(name))
        for sock in waiting:
            sock.close()
