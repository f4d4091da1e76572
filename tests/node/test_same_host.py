"""same_host: Unix sockets between programs of one machine and one user."""

from __future__ import annotations

import os
import re
import socket
from collections.abc import Iterator
from typing import Any

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


@pytest.fixture
def ask_again() -> Iterator[None]:
    """The key is computed anew in this test, and after it."""
    same_host.host_key.cache_clear()
    yield
    same_host.host_key.cache_clear()


@pytest.mark.parametrize(
    ("where", "name"), [(os, "memfd_create"), (os, "geteuid"), (socket, "SO_PEERCRED"), (socket, "send_fds")]
)
def test_a_system_that_lacks_something(ask_again: None, monkeypatch: pytest.MonkeyPatch, where: Any, name: str) -> None:
    with monkeypatch.context() as patch:
        patch.delattr(where, name)
        assert same_host.host_key() == "" == same_host.local_key({})


def test_a_system_without_namespaces(ask_again: None, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(path: str) -> str:
        raise FileNotFoundError(2, "No such file or directory", path)

    with monkeypatch.context() as patch:
        patch.setattr(os, "readlink", fail)
        assert same_host.host_key() == ""


def test_a_socket_that_cannot_listen_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[socket.socket] = []

    class Refusing(socket.socket):
        def __init__(self, family: int) -> None:
            super().__init__(family)
            made.append(self)

        def listen(self, backlog: int = 0) -> None:
            raise OSError(24, "Too many open files")

    monkeypatch.setattr("pyros1.node.same_host.socket.socket", Refusing)
    with pytest.raises(OSError, match="Too many open files"):
        same_host.listen()
    assert [sock.fileno() for sock in made] == [-1]
