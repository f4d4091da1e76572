"""TCPROS by hand: what a node says on the wire, seen without any client library."""

from __future__ import annotations

import contextlib
import socket
import struct
import threading
from collections.abc import Iterator
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
