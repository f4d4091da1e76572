"""What all tests share: a master of their own, nodes that are shut down, and that nothing may be left behind."""

from __future__ import annotations

import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import pytest
from _pytest.capture import FDCapture
from hypothesis import settings

from pyros1.master.server import Master
from pyros1.node import Node
from pyros1.node.same_host import host_key

from .free_ports import free_port as free_port_here

settings.register_profile("quick", max_examples=20, deadline=None)
settings.register_profile("thorough", max_examples=100, deadline=None)
settings.load_profile("thorough" if os.environ.get("CI") else "quick")


@pytest.fixture(autouse=True)
def no_thread_survives() -> Iterator[None]:
    """Fail a test that leaves threads running."""
    before = set(threading.enumerate())
    yield
    until = time.monotonic() + 5.0
    left = [thread for thread in threading.enumerate() if thread not in before]
    for thread in left:
        thread.join(max(0.0, until - time.monotonic()))
    alive = [thread.name for thread in left if thread.is_alive()]
    assert not alive, f"threads left running: {alive}"


@pytest.fixture(autouse=True, scope="session")
def no_output_is_lost() -> Iterator[None]:
    """Let ``capfd.readouterr()`` read what is new. By itself, it empties the file that it has read, and what other
    threads write meanwhile, such as a node's log, with it.
    """
    positions: WeakKeyDictionary[FDCapture, int] = WeakKeyDictionary()

    def read_new(self: FDCapture) -> str:
        file = self.tmpfile.fileno()
        begin = positions.get(self, 0)
        data = os.pread(file, os.fstat(file).st_size - begin, begin)
        positions[self] = begin + len(data)
        return data.decode(errors="replace")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FDCapture, "snap", read_new)
        yield


@pytest.fixture(autouse=True)
def signal_handlers_are_put_back() -> Iterator[None]:
    """Those of a node that a signal has ended stay, on purpose; later tests must not see them."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture(autouse=True)
def coverage_does_not_count(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Programs whose memory or start is measured must not record coverage, as others do under ``coverage run``."""
    if request.path.stem in ("test_memory", "test_limits", "test_start"):
        monkeypatch.delenv("COVERAGE_PROCESS_CONFIG", raising=False)


@pytest.fixture
def master() -> Iterator[Master]:
    """A master of pyros1 on a free port."""
    server = Master(port=0, bind_host="127.0.0.1")
    server.start()
    yield server
    server.stop()


@pytest.fixture
def environ(master: Master, tmp_path: Path) -> dict[str, str]:
    """Environment variables for nodes of a test. Connections are those that stock's nodes have, too."""
    home = str(tmp_path / "ros")
    return {"ROS_MASTER_URI": master.uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": home, "PYROS1_TRANSPORTS": "tcp"}


@pytest.fixture
def make_node(environ: dict[str, str]) -> Iterator[Callable[..., Node]]:
    """Return a function that makes nodes as ``Node`` does; they are shut down after the test."""
    nodes: list[Node] = []

    def make(name: str, **options: Any) -> Node:
        options.setdefault("argv", [])
        options.setdefault("environ", environ)
        options.setdefault("handle_signals", False)
        node = Node(name, **options)
        nodes.append(node)
        return node

    yield make
    for node in reversed(nodes):
        node.shutdown()


@pytest.fixture(
    params=[
        "inside",
        "tcp",
        pytest.param("local", marks=pytest.mark.skipif(not host_key(), reason="no shared memory on this system")),
    ]
)
def transport(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Run a test with links within the process, and with the connections that nodes of other processes have."""
    if request.param != "inside":
        monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)
        monkeypatch.setattr("pyros1.node.same_host.is_local_enabled", lambda setting: request.param == "local")
    return str(request.param)


@pytest.fixture
def free_ports() -> Callable[[int], list[int]]:
    """Return a function that returns so many ports that nobody listens on, each another one."""

    def find(count: int) -> list[int]:
        return [free_port_here() for _ in range(count)]

    return find


@pytest.fixture
def free_port(free_ports: Callable[[int], list[int]]) -> int:
    """A port that nobody listens on."""
    return free_ports(1)[0]


@pytest.fixture
def closed_port() -> Iterator[int]:
    """A port that refuses connections: bound, so that no other program can listen on it."""
    with socket.socket() as sock:
        sock.bind(("127.0.0.1", 0))
        yield sock.getsockname()[1]


@pytest.fixture
def call_main(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Return a function that calls ``main([word, ...])`` as a program and returns exit code, stdout and stderr."""

    def call(main: Callable[[list[str]], int], *words: object) -> tuple[int, str, str]:
        try:
            code = main([str(word) for word in words])
        except SystemExit as end:
            code = int(end.code or 0)
        return (code, *capsys.readouterr())

    return call
