"""Calls whose data take long, or whose host's name does: XmlRpcClient, RpcCaller and XmlRpcServer."""

from __future__ import annotations

import queue
import select
import socket
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.ground.errors import DeadlineError, Error, UnknownHostError, UnreachableError
from pyros1.net import timeouts, xmlrpc_server
from pyros1.net.connect import connect
from pyros1.net.loop import Loop
from pyros1.net.rpc_caller import RpcCaller
from pyros1.net.xmlrpc_client import XmlRpcClient
from pyros1.net.xmlrpc_server import ServerLimits, XmlRpcServer
from pyros1.wire.http import build_request, build_response
from pyros1.wire.xmlrpc import dumps_call, dumps_response

ANSWER = build_response(200, dumps_response("x" * 100_000))


class Clock:
    """A clock that only the test moves."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr(timeouts, "monotonic", made)
    monkeypatch.setattr(xmlrpc_server, "monotonic", made)
    return made


@pytest.fixture
def loop() -> Iterator[Loop]:
    loop = Loop("test")
    loop.start()
    yield loop
    loop.stop()


@pytest.fixture
def serve() -> Iterator[Callable[[Callable[[socket.socket], None]], str]]:
    """Return a function that serves one connection with another function, and returns the URI."""
    listener = socket.create_server(("127.0.0.1", 0))
    threads: list[threading.Thread] = []

    def start(behave: Callable[[socket.socket], None]) -> str:
        def run() -> None:
            with listener.accept()[0] as sock:
                sock.settimeout(10)
                data = b""
                while not data.endswith(b"</methodCall>"):
                    data += sock.recv(65536)
                behave(sock)

        threads.append(threading.Thread(target=run))
        threads[-1].start()
        return f"http://127.0.0.1:{listener.getsockname()[1]}/"

    yield start
    for thread in threads:
        thread.join(10)
    listener.close()


@pytest.fixture
def add_bytes(monkeypatch: pytest.MonkeyPatch) -> threading.Semaphore:
    """Released whenever somebody takes note of bytes that came or went."""
    count, take_note = threading.Semaphore(0), timeouts.TransferDeadline.add_bytes

    def watched(patience: timeouts.TransferDeadline, size: int) -> None:
        take_note(patience, size)
        count.release()

    monkeypatch.setattr(timeouts.TransferDeadline, "add_bytes", watched)
    return count


def test_a_large_answer_over_a_slow_link(serve: Any, clock: Clock, add_bytes: threading.Semaphore) -> None:
    def behave(sock: socket.socket) -> None:
        assert add_bytes.acquire(timeout=10)  # the request
        for start in range(0, len(ANSWER), 10_000):
            clock.now += 1.0
            sock.sendall(ANSWER[start : start + 10_000])
            assert add_bytes.acquire(timeout=10)

    client = XmlRpcClient(serve(behave), timeout=5)
    assert client.call("m") == "x" * 100_000
    assert clock.now > 110
    client.close()


def test_an_answer_that_stops(serve: Any) -> None:
    def behave(sock: socket.socket) -> None:
        sock.sendall(ANSWER[:50_000])
        while sock.recv(1):
            pass

    client = XmlRpcClient(serve(behave), timeout=0.1)
    with pytest.raises(DeadlineError):
        client.call("m")
    client.close()


def test_an_answer_that_trickles(serve: Any, clock: Clock, add_bytes: threading.Semaphore) -> None:
    """Byte after byte, it ends when the time is over."""

    def behave(sock: socket.socket) -> None:
        assert add_bytes.acquire(timeout=10)  # the request
        for start in range(200):
            clock.now += 0.1
            try:
                sock.sendall(ANSWER[start : start + 1])
                while not add_bytes.acquire(timeout=0.05):
                    if select.select([sock], [], [], 0)[0] and not sock.recv(65536):
                        return
            except OSError:
                return  # the client has gone

    client = XmlRpcClient(serve(behave), timeout=5)
    with pytest.raises(DeadlineError):
        client.call("m")
    assert clock.now < 106
    client.close()


def test_the_caller_waits_while_an_answer_comes(serve: Any, clock: Clock, loop: Loop) -> None:
    began, late = threading.Event(), threading.Event()

    def behave(sock: socket.socket) -> None:
        sock.sendall(ANSWER[:50_000])
        began.set()
        late.wait(10)
        sock.sendall(ANSWER[50_000:])

    caller = RpcCaller(loop)
    got: list[tuple[Any, Error | None]] = []
    done = threading.Event()
    caller.call(serve(behave), "m", [], lambda value, error: (got.append((value, error)), done.set()), timeout=0.05)
    began.wait(10)
    loop.call_later(0.15, late.set)  # after the time of the call, measured by the loop's clock
    assert done.wait(10)
    assert got == [("x" * 100_000, None)]
    caller.close()


def test_a_large_request_over_a_slow_link(loop: Loop, clock: Clock) -> None:
    """The server waits for a request that comes in, however long that takes."""
    limits = ServerLimits(request_timeout_s=0.2)
    server = XmlRpcServer(
        loop,
        lambda method, params: len(params[0]),
        bind_host="127.0.0.1",
        advertised_host="localhost",
        limits=limits,
    )
    arrived = threading.Semaphore(0)
    record_buffered = server.record_buffered

    def watched(connection: Any, buffered: int) -> bool:
        arrived.release()
        return record_buffered(connection, buffered)

    server.record_buffered = watched  # type: ignore[method-assign]
    request = build_request("localhost", "/", dumps_call("m", ["x" * 50_000]))
    with socket.create_connection(("127.0.0.1", server.port), timeout=10) as sock:
        for start in range(0, len(request), 10_000):
            clock.now += 0.15
            sock.sendall(request[start : start + 10_000])
            assert arrived.acquire(timeout=10)
            swept = threading.Event()
            loop.call_later(0.06, swept.set)  # the server looks more often
            assert swept.wait(10)
        assert b"<int>50000</int>" in sock.recv(65536)
    server.close()


@pytest.fixture
def silent_name(monkeypatch: pytest.MonkeyPatch) -> Iterator[threading.Event]:
    """Let look-ups wait until the test ends; the event says that one has begun."""
    begun, end = threading.Event(), threading.Event()

    def look_up(host: str) -> list[str]:
        begun.set()
        end.wait(10)
        raise OSError("too late")

    monkeypatch.setattr("pyros1.net.resolve.resolve_host", look_up)
    yield begun
    end.set()


def test_a_deadline_that_passes_before_the_wait_for_a_name_server(silent_name: threading.Event) -> None:
    client = XmlRpcClient("http://slow:1/", timeout=0.0)
    with pytest.raises(UnknownHostError, match="'slow' cannot be resolved here: no answer from the name server"):
        client.call("m")
    client.close()


def test_a_silent_name_server(silent_name: threading.Event) -> None:
    client = XmlRpcClient("http://slow:1/", timeout=0.05)
    before = threading.active_count()
    for _ in range(3):
        with pytest.raises(UnknownHostError, match="'slow' cannot be resolved here: no answer from the name server"):
            client.call("m")
    assert threading.active_count() == before + 1, "all calls wait for the same look-up"
    client.close()


def test_close_interrupts_a_look_up(silent_name: threading.Event) -> None:
    client = XmlRpcClient("http://slow:1/", timeout=10)
    closer = threading.Thread(target=lambda: silent_name.wait(10) and client.close())
    closer.start()
    with pytest.raises(UnreachableError, match="closed"):
        client.call("m")
    closer.join()


def test_many_calls_that_fail_at_once_are_all_answered(loop: Loop, monkeypatch: pytest.MonkeyPatch) -> None:
    """As when a name cannot be looked up: each failure begins the next call, and they must not be nested."""
    monkeypatch.setattr(loop.resolver, "resolve", lambda _, done: done([], socket.gaierror(-2, "unknown")))
    caller = RpcCaller(loop)
    errors: list[Error | None] = []
    all_came = threading.Event()

    def take(_: Any, error: Error | None) -> None:
        errors.append(error)
        if len(errors) == 500:
            all_came.set()

    def ask() -> None:
        for number in range(500):
            caller.call("http://nowhere:1/", "getPid", [f"/{number}"], take)

    loop.call_soon(ask)
    assert all_came.wait(20), len(errors)
    assert {type(error) for error in errors} == {UnknownHostError}
    loop.run(caller.close)


def test_that_one_address_refuses_says_more_than_that_the_next_has_no_way(
    loop: Loop, monkeypatch: pytest.MonkeyPatch, free_port: int
) -> None:
    monkeypatch.setattr(loop.resolver, "resolve", lambda _, done: done(["127.0.0.1", "255.255.255.255"], None))
    came: queue.SimpleQueue[Any] = queue.SimpleQueue()
    connect(loop, "both", free_port, 10.0, lambda sock, error: came.put(error))
    error = came.get(timeout=20)
    assert isinstance(error, UnreachableError) and isinstance(error.__cause__, ConnectionRefusedError)
