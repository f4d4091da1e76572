"""TCPROS by hand: what a node says on the wire, seen without any client library."""

from __future__ import annotations

import contextlib
import socket
import struct
import threading
import xmlrpc.client
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any
from xmlrpc.server import SimpleXMLRPCServer

from harness import DEADLINE, Master


def encode_header(fields: dict[str, str]) -> bytes:
    """A connection header (T01)."""
    parts = [f"{key}={value}".encode() for key, value in fields.items()]
    body = b"".join(struct.pack("<I", len(part)) + part for part in parts)
    return struct.pack("<I", len(body)) + body


def read_exactly(connection: socket.socket, size: int) -> bytes:
    """*size* bytes; EOFError if the peer closes before."""
    data = b""
    while len(data) < size:
        piece = connection.recv(size - len(data))
        if not piece:
            raise EOFError(f"closed after {len(data)} of {size} bytes")
        data += piece
    return data


def read_frame(connection: socket.socket) -> bytes:
    """What follows a u32 length: a message, or a header's fields."""
    return read_exactly(connection, struct.unpack("<I", read_exactly(connection, 4))[0])


def read_header(connection: socket.socket) -> dict[str, str]:
    """A connection header."""
    data, offset, fields = read_frame(connection), 0, {}
    while offset < len(data):
        (size,) = struct.unpack_from("<I", data, offset)
        key, _, value = data[offset + 4 : offset + 4 + size].partition(b"=")
        fields[key.decode()] = value.decode()
        offset += 4 + size
    return fields


def connect(host: str, port: int) -> socket.socket:
    """A connection that gives up on every read after the tests' deadline."""
    return socket.create_connection((host, port), timeout=DEADLINE)


def publisher_address(master: Master, node: str, topic: str) -> tuple[str, int]:
    """Where the node serves the topic (requestTopic)."""
    code, message, parameters = master.node(node, "requestTopic", topic, [["TCPROS"]])
    assert code == 1, message
    return parameters[1], parameters[2]


def service_address(master: Master, service: str) -> tuple[str, int]:
    """Where the service is served."""
    host, port = master.call("lookupService", service)[2].removeprefix("rosrpc://").rstrip("/").split(":")
    return host, int(port)


class FakePublisher:
    """A publisher that only looks at how a subscriber introduces itself.

    Args:
        master: where it registers.
        topic: topic name.
        type_name: registered type.
    """

    def __init__(self, master: Master, topic: str, type_name: str) -> None:
        self.master, self.topic = master, topic
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.listener.settimeout(DEADLINE)
        self.server = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
        self.server.register_function(self._request_topic, "requestTopic")
        self.uri = f"http://localhost:{self.server.server_address[1]}/"
        self.thread = threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.02})
        self.thread.start()
        master.call("registerPublisher", topic, type_name, self.uri)

    def _request_topic(self, _caller: str, _topic: str, _protocols: list[Any]) -> list[Any]:
        return [1, "ready", ["TCPROS", "localhost", self.listener.getsockname()[1]]]

    def accept(self) -> socket.socket:
        """The next subscriber's connection."""
        connection, _ = self.listener.accept()
        connection.settimeout(DEADLINE)
        return connection

    def close(self) -> None:
        self.master.call("unregisterPublisher", self.topic, self.uri)
        self.server.shutdown()
        self.thread.join(DEADLINE)
        self.server.server_close()
        self.listener.close()


@contextlib.contextmanager
def fake_publisher(master: Master, topic: str, type_name: str) -> Iterator[FakePublisher]:
    """A `FakePublisher` for a with statement."""
    fake = FakePublisher(master, topic, type_name)
    try:
        yield fake
    finally:
        fake.close()


class ForeignNode:
    """A node of another client library: its publishers send any header and any bytes, and check nothing.

    Args:
        master: where it registers.
        name: its name.
    """

    def __init__(self, master: Master, name: str) -> None:
        self.master, self.name = master, name
        self._sent: dict[str, bytes] = {}
        self._types: dict[str, str] = {}
        self._ended: set[tuple[str, str]] = set()
        self._connections: list[socket.socket] = []
        self._listener = socket.create_server(("127.0.0.1", 0), backlog=200)
        self._server = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
        address = self._listener.getsockname()
        self._server.register_function(lambda *_: [1, "ready", ["TCPROS", "localhost", address[1]]], "requestTopic")
        self.uri = f"http://localhost:{self._server.server_address[1]}/"
        serve = partial(self._server.serve_forever, poll_interval=0.02)
        self._threads = [threading.Thread(target=function) for function in (serve, self._accept)]
        for thread in self._threads:
            thread.start()

    def publish(self, topic: str, type_name: str, fields: Sequence[bytes], bodies: Sequence[bytes]) -> None:
        """Publish a topic.

        Args:
            topic: its name.
            type_name: the type that the master is told.
            fields: of the connection header, as bytes of any kind.
            bodies: the messages that each subscriber gets.
        """
        header = b"".join(struct.pack("<I", len(field)) + field for field in fields)
        parts = (header, *bodies)
        self._sent[topic] = b"".join(struct.pack("<I", len(part)) + part for part in parts)
        self._types[topic] = type_name
        with xmlrpc.client.ServerProxy(self.master.uri) as proxy:
            proxy.registerPublisher(self.name, topic, type_name, self.uri)

    def has_ended(self, topic: str, subscriber: str) -> bool:
        """Whether a subscriber has closed its connection: it refuses what it was sent."""
        return (topic, subscriber) in self._ended

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            self._connections.append(connection)
            self._threads.append(threading.Thread(target=self._serve, args=(connection,)))
            self._threads[-1].start()

    def _serve(self, connection: socket.socket) -> None:
        with contextlib.suppress(OSError, EOFError):
            header = read_header(connection)
            with contextlib.suppress(OSError):
                connection.sendall(self._sent[header["topic"]])
                while connection.recv(100):
                    pass
            self._ended.add((header["topic"], header["callerid"]))

    def close(self) -> None:
        with xmlrpc.client.ServerProxy(self.master.uri) as proxy:
            for topic in self._types:
                proxy.unregisterPublisher(self.name, topic, self.uri)
        self._server.shutdown()
        self._server.server_close()
        for sock in (self._listener, *self._connections):
            with contextlib.suppress(OSError):
                sock.shutdown(socket.SHUT_RDWR)
            sock.close()
        for thread in self._threads:
            thread.join(DEADLINE)


@contextlib.contextmanager
def foreign_node(master: Master, name: str) -> Iterator[ForeignNode]:
    """A `ForeignNode` for a with statement."""
    node = ForeignNode(master, name)
    try:
        yield node
    finally:
        node.close()
