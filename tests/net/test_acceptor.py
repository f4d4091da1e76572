"""acceptor: a process that can open no more files rests, says so once, and goes on when it can."""

from __future__ import annotations

import errno
import os
import socket
import sys
import threading
from collections import deque
from collections.abc import Iterator

import pytest

from pyros1.ground.errors import UnreachableError
from pyros1.net.acceptor import Acceptor, is_out_of_files
from pyros1.net.loop import Loop


class Listener(socket.socket):
    """A listening socket that fails as often as it is told to."""

    def __init__(self, errors: list[int]) -> None:
        super().__init__()
        self.bind(("127.0.0.1", 0))
        self.listen()
        self.errors = deque(errors)
        self.attempts = 0

    def accept(self) -> tuple[socket.socket, object]:
        self.attempts += 1
        if self.errors:
            number = self.errors.popleft()
            raise OSError(number, os.strerror(number))
        return super().accept()


@pytest.fixture
def loop() -> Iterator[Loop]:
    loop = Loop("test")
    loop.start()
    yield loop
    loop.stop()


@pytest.mark.parametrize("number", [errno.EMFILE, errno.ENFILE, errno.ENOBUFS])
def test_it_rests_makes_room_and_goes_on(loop: Loop, monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    monkeypatch.setattr("pyros1.net.acceptor.RETRY_DELAY", 0.01)
    listener, taken = Listener([number] * 5), threading.Semaphore(0)
    said: list[str] = []
    rooms: list[int] = []

    def on_connection(sock: socket.socket) -> None:
        assert not sock.getblocking()
        sock.close()
        taken.release()

    acceptor = Acceptor(loop, listener, on_connection, said.append, lambda: rooms.append(listener.attempts))
    for _ in range(2):
        with socket.create_connection(listener.getsockname(), timeout=20):
            assert taken.acquire(timeout=10)
    assert rooms == [1, 2, 3, 4, 5]
    assert len(said) == 1 and said[0].startswith(f"cannot accept a connection: {os.strerror(number)}")
    assert ("ulimit -n" in said[0]) == (number != errno.ENOBUFS)
    loop.run(acceptor.close)
    loop.run(acceptor.close)
    assert listener.fileno() == -1


def test_trouble_is_told_again_after_a_quiet_time(loop: Loop, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.net.acceptor.RETRY_DELAY", 0.01)
    monkeypatch.setattr("pyros1.net.acceptor.REPORT_INTERVAL", 0.0)
    listener, taken = Listener([errno.EMFILE] * 2), threading.Semaphore(0)
    said: list[str] = []
    acceptor = Acceptor(loop, listener, lambda sock: (sock.close(), taken.release()), said.append)
    with socket.create_connection(listener.getsockname(), timeout=20):
        assert taken.acquire(timeout=10)
    loop.run(acceptor.close)
    assert len(said) == 2


def test_one_that_is_closed_at_once_never_listens(loop: Loop) -> None:
    listener = Listener([])
    acceptor = loop.run(lambda: Acceptor(loop, listener, print, print))
    loop.run(acceptor.close)
    loop.run(lambda: None)
    assert listener.attempts == 0


def test_errors_that_say_that_no_file_can_be_opened() -> None:
    failure = UnreachableError("cannot connect")
    assert not is_out_of_files(failure) and not is_out_of_files(None)
    failure.__cause__ = OSError(errno.EMFILE, "Too many open files")
    assert is_out_of_files(failure)
    failure.__cause__ = OSError(errno.ECONNREFUSED, "Connection refused")
    assert not is_out_of_files(failure)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems cannot shut a port down")
def test_a_port_is_closed_though_a_forked_process_has_it(loop: Loop) -> None:
    """Else whoever connects there waits for an answer, in place of hearing that nobody listens."""
    listener = Listener([])
    with socket.socket(fileno=os.dup(listener.fileno())):
        acceptor = loop.run(lambda: Acceptor(loop, listener, print, print))
        address = listener.getsockname()
        loop.run(acceptor.close)
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(address, 5.0)
