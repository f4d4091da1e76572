"""dial: connections that are made, or given up, in a bounded time."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Iterator

import pytest

from pyros1.ground.errors import UnknownHostError
from pyros1.net.blocking_connect import blocking_connect
from pyros1.net.loop import Loop


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as made:
        yield made


@contextlib.contextmanager
def deaf() -> Iterator[int]:
    """The port of a listener whose queue is full: the system answers no more attempts to connect."""
    with socket.socket() as made, contextlib.ExitStack() as stack:
        made.bind(("127.0.0.1", 0))
        made.listen(0)
        for _ in range(4):
            waiting = stack.enter_context(socket.socket())
            waiting.setblocking(False)
            waiting.connect_ex(made.getsockname())
        yield made.getsockname()[1]


def nothing() -> None:
    pass


def test_a_connection(listener: socket.socket) -> None:
    port = listener.getsockname()[1]
    with blocking_connect("127.0.0.1", port, 10, nothing) as sock, listener.accept()[0] as other:
        sock.setblocking(True)
        sock.sendall(b"x")
        assert other.recv(1) == b"x"


def test_refused(listener: socket.socket) -> None:
    port = listener.getsockname()[1]
    listener.close()
    with pytest.raises(ConnectionRefusedError):
        blocking_connect("127.0.0.1", port, 10, nothing)


def test_no_answer() -> None:
    with deaf() as port, pytest.raises(TimeoutError, match=r"no answer within 0.05 s"):
        blocking_connect("127.0.0.1", port, 0.05, nothing)


def test_the_check_ends_it() -> None:
    def stop() -> None:
        raise KeyError("stop")

    with deaf() as port, pytest.raises(KeyError):
        blocking_connect("127.0.0.1", port, 10, stop)


def test_a_timeout_of_the_check_is_not_taken_for_another(monkeypatch: pytest.MonkeyPatch) -> None:
    answer = threading.Event()
    monkeypatch.setattr("pyros1.net.resolve.resolve_host", lambda host: ["127.0.0.1"] * answer.wait(10))
    calls = iter(range(2))

    def stop() -> None:
        if next(calls):
            raise TimeoutError("mine")

    with pytest.raises(TimeoutError, match="mine"):
        blocking_connect("slow", 1, 10, stop)
    answer.set()


def test_a_silent_name_server(monkeypatch: pytest.MonkeyPatch) -> None:
    answer = threading.Event()
    monkeypatch.setattr("pyros1.net.resolve.resolve_host", lambda host: ["127.0.0.1"] * answer.wait(10))
    for seconds in (0.5, 0.0):
        with pytest.raises(UnknownHostError, match="'slow' cannot be resolved here: no answer from the name server"):
            blocking_connect("slow", 1, seconds, nothing)
    with pytest.raises(TimeoutError, match="no answer within 0 s"):
        blocking_connect("127.0.0.1", 1, 0.0, nothing)
    answer.set()


def test_an_unknown_name(monkeypatch: pytest.MonkeyPatch) -> None:
    def resolve_host(host: str) -> list[str]:
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr("pyros1.net.resolve.resolve_host", resolve_host)
    with pytest.raises(UnknownHostError, match="Name or service not known"):
        blocking_connect("nowhere", 1, 10, nothing)


def test_an_address_that_does_not_answer_leaves_time_for_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.net.resolve.resolve_host", lambda host: ["127.0.0.1", "127.0.0.2"])
    with (
        deaf() as port,
        socket.create_server(("127.0.0.2", port)) as listener,
        blocking_connect("two", port, 0.4, nothing) as sock,
        listener.accept()[0],
    ):
        assert sock.getpeername() == ("127.0.0.2", port)


def test_a_loop_leaves_time_for_the_next_address(monkeypatch: pytest.MonkeyPatch) -> None:
    from pyros1.net.connect import connect

    monkeypatch.setattr("pyros1.net.resolve.resolve_host", lambda host: ["127.0.0.1", "127.0.0.2"])
    loop, done, got = Loop("test"), threading.Event(), []
    loop.start()
    try:
        with deaf() as port, socket.create_server(("127.0.0.2", port)):
            connect(loop, "two", port, 0.4, lambda sock, error: (got.append((sock, error)), done.set()))
            assert done.wait(10)
            sock, error = got[0]
            assert sock is not None, error
            assert sock.getpeername() == ("127.0.0.2", port)
            sock.close()
    finally:
        loop.stop()


def test_that_one_address_refuses_says_more_than_that_the_next_has_no_way(
    listener: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    port = listener.getsockname()[1]
    listener.close()
    monkeypatch.setattr("pyros1.net.resolve.resolve_host", lambda _: ["127.0.0.1", "255.255.255.255"])
    with pytest.raises(ConnectionRefusedError):
        blocking_connect("both.example", port, 10, nothing)
