"""What the tests of nodes share: callbacks that can be waited for, raw peers, nodes that are not quite nodes."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.master.server import Master
from pyros1.net.hosts import parse_uri
from pyros1.net.loop import Loop
from pyros1.net.master_client import MasterClient
from pyros1.net.xmlrpc_client import XmlRpcClient
from pyros1.net.xmlrpc_server import XmlRpcServer
from pyros1.node.log.sink import LogSink, Record
from pyros1.wire.header import HeaderReader, encode_header

from ..parts import tcpros_port

PATIENCE = 20.0
FLOAT64_MD5 = "fdb28210bfa9d7c91146260178d9a584"


class Collector:
    """A callback that keeps what it gets, in ``items``."""

    def __init__(self) -> None:
        self.items: list[Any] = []
        self._changed = threading.Condition()

    def __call__(self, item: Any) -> None:
        with self._changed:
            self.items.append(item)
            self._changed.notify_all()

    def until(self, condition: Callable[[list[Any]], Any], timeout: float = PATIENCE) -> bool:
        """Wait until ``condition(items)`` is true; tell whether it is."""
        with self._changed:
            return bool(self._changed.wait_for(lambda: condition(self.items), timeout))

    def wait(self, count: int = 1, timeout: float = PATIENCE) -> list[Any]:
        """Wait for that many items, and return them."""
        assert self.until(lambda items: len(items) >= count, timeout), f"{len(self.items)} of {count} items came"
        return self.items

    @property
    def data(self) -> list[Any]:
        """The field ``data`` of all items."""
        return [item.data for item in self.items]


class LogWatch(Collector):
    """The log records of a node."""

    @property
    def texts(self) -> list[str]:
        return [record.text for record in self.items]

    def saw(self, *parts: str, timeout: float = PATIENCE) -> str:
        """Wait for a line that contains all of ``parts``, and return it."""

        def found(items: list[Any]) -> list[str]:
            return [record.text for record in items if all(part in record.text for part in parts)]

        assert self.until(found, timeout), f"no line with {parts} in {self.texts}"
        return found(self.items)[0]


class RawPeer:
    """A plain socket that speaks as much TCPROS as the test tells it to."""

    def __init__(self, port: int, *, receive_buffer: int | None = None) -> None:
        self.sock = socket.socket()
        if receive_buffer is not None:
            self.sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.sock.settimeout(PATIENCE)
        self._rest = b""
        try:
            self.sock.connect(("127.0.0.1", port))
        except OSError:
            self.sock.close()
            raise

    def greet(self, **fields: str) -> RawPeer:
        """Send a connection header."""
        self.sock.sendall(encode_header(fields))
        return self

    def answer(self) -> dict[str, str]:
        """Receive a connection header."""
        reader = HeaderReader()
        while True:
            data = self.sock.recv(65536)
            if not data:
                raise ConnectionError("closed before a header came")
            header = reader.feed(data)
            if header is not None:
                self._rest = reader.bytes_after_header
                return header

    def take(self, count: int) -> bytes:
        """Receive exactly that many bytes."""
        while len(self._rest) < count:
            data = self.sock.recv(65536)
            if not data:
                raise ConnectionError(f"closed after {len(self._rest)} of {count} bytes")
            self._rest += data
        taken, self._rest = self._rest[:count], self._rest[count:]
        return taken

    def frame(self) -> bytes:
        """Receive one frame's body."""
        return self.take(int.from_bytes(self.take(4), "little"))

    def closed(self) -> bool:
        """Wait for the other side to close; True if it did so without a word."""
        try:
            return self.sock.recv(65536) == b""
        except ConnectionError:
            return True

    def close(self) -> None:
        self.sock.close()


class FakeNode:
    """A slave API that answers what the test says, and a TCPROS port, to play odd peers."""

    def __init__(self, name: str, master_uri: str) -> None:
        self.name = name
        self.calls = Collector()
        self.answers: dict[str, Any] = {}
        self.master = MasterClient(name, master_uri)
        self._loop = Loop(f"fake {name}")
        self._loop.start()
        self._server = XmlRpcServer(self._loop, self._dispatch, bind_host="127.0.0.1", advertised_host="localhost")
        self.uri = self._server.uri
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.listener.settimeout(PATIENCE)
        self.port = self.listener.getsockname()[1]
        self._taken: list[socket.socket] = []

    def _dispatch(self, method: str, params: Any) -> Any:
        self.calls((method, list(params)))
        answer = self.answers.get(method, [1, "", 0])
        return answer(*params) if callable(answer) else answer

    def publish(self, topic: str, type_name: str = "std_msgs/Float64") -> None:
        """Register as a publisher that sends its subscribers to our TCPROS port."""
        self.answers.setdefault("requestTopic", [1, "ready", ["TCPROS", "localhost", self.port]])
        self.master.register_publisher(topic, type_name, self.uri)

    def accept(self) -> tuple[socket.socket, dict[str, str]]:
        """Take a connection and read its header."""
        sock, _ = self.listener.accept()
        sock.settimeout(PATIENCE)
        self._taken.append(sock)
        reader = HeaderReader()
        header = None
        while header is None:
            data = sock.recv(65536)
            if not data:
                raise ConnectionError("closed before a header came")
            header = reader.feed(data)
        return sock, header

    def accept_subscriber(self, **fields: str) -> socket.socket:
        """Take a subscriber of std_msgs/Float64."""
        sock, header = self.accept()
        answer = {"callerid": self.name, "topic": header["topic"], "type": "std_msgs/Float64", "md5sum": FLOAT64_MD5}
        sock.sendall(encode_header({**answer, "message_definition": "float64 data\n", "latching": "0", **fields}))
        return sock

    def close(self) -> None:
        for sock in self._taken:
            sock.close()
        self.listener.close()
        self.master.close()
        self._server.close()
        self._loop.stop()


@pytest.fixture
def collect() -> Callable[[], Collector]:
    """Return a function that makes callbacks which keep what they get."""
    return Collector


@pytest.fixture
def watch_log(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any], LogWatch]:
    """Return a function that watches a node's log from now on."""
    watches: dict[str, LogWatch] = {}
    emit = LogSink.emit

    def emit_and_keep(sink: LogSink, record: Record, *args: Any, **options: Any) -> None:
        emit(sink, record, *args, **options)
        if sink.node_name in watches:
            watches[sink.node_name](record)

    monkeypatch.setattr(LogSink, "emit", emit_and_keep)
    return lambda node: watches.setdefault(node.name, LogWatch())


@pytest.fixture
def until() -> Callable[[Callable[[], Any]], None]:
    """Return a function that waits until a condition is true of which nobody tells."""

    def wait(condition: Callable[[], Any]) -> None:
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, "it never came true"
            time.sleep(0.001)

    return wait


@pytest.fixture
def raw_peer() -> Iterator[Callable[..., RawPeer]]:
    """Return a function that connects to a node's TCPROS port; it takes the node or the port."""
    peers: list[RawPeer] = []

    def make(node: Any, **options: Any) -> RawPeer:
        peer = RawPeer(node if isinstance(node, int) else tcpros_port(node), **options)
        peers.append(peer)
        return peer

    yield make
    for peer in peers:
        peer.close()


@pytest.fixture
def fake_node(master: Master) -> Iterator[Callable[[str], FakeNode]]:
    """Return a function that makes fake nodes."""
    fakes: list[FakeNode] = []

    def make(name: str) -> FakeNode:
        fake = FakeNode(name, master.uri)
        fakes.append(fake)
        return fake

    yield make
    for fake in fakes:
        fake.close()


@pytest.fixture
def call_node() -> Iterator[Callable[..., Any]]:
    """Return a function that calls a node's slave API: ``call_node(node, method, *args)``."""
    clients: list[XmlRpcClient] = []

    def call(node: Any, method: str, *args: Any) -> Any:
        client = XmlRpcClient(node.uri)
        clients.append(client)
        return client.call(method, *args)

    yield call
    for client in clients:
        client.close()


@pytest.fixture
def in_thread() -> Iterator[Callable[..., Any]]:
    """Return a function that runs another in a thread: the result has ``join()``, which returns or raises as it did."""
    threads: list[threading.Thread] = []

    class Running:
        def __init__(self, function: Callable[..., Any], args: tuple[Any, ...]) -> None:
            self._value: Any = None
            self._error: BaseException | None = None
            self.thread = threading.Thread(target=self._run, args=(function, args), name="test", daemon=True)
            threads.append(self.thread)
            self.thread.start()

        def _run(self, function: Callable[..., Any], args: tuple[Any, ...]) -> None:
            try:
                self._value = function(*args)
            except BaseException as error:  # noqa: BLE001 - raised again in join
                self._error = error

        def join(self, timeout: float = PATIENCE) -> Any:
            self.thread.join(timeout)
            assert not self.thread.is_alive(), "still running"
            if self._error is not None:
                raise self._error
            return self._value

    yield lambda function, *args: Running(function, args)
    for thread in threads:
        thread.join(PATIENCE)


@pytest.fixture
def service_port() -> Callable[[Any], int]:
    """Return a function that tells the port of a ``rosrpc://`` address."""
    return lambda uri: parse_uri(uri, "rosrpc")[1]
