"""Clients of `pyros1 web` for `web_bridges.py`: of rosbridge, Foxglove viewers, and the server's own pages."""

from __future__ import annotations

import base64
import json
import os
import selectors
import socket
import struct
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

TIMEOUT = 20
_VIEWS = {"sensor_msgs/Image": "image"}


class Client:
    """Subscribes to a topic whose messages have the time in them.

    Args:
        url: the server's address.
        topic, type: the topic's.
        form: how messages are wanted.

    Attributes:
        for_others: arguments of `receive_only` for more clients like this one.
    """

    path = "/"
    subprotocol = ""
    acknowledgement = ""

    def __init__(self, url: str, topic: str, type: str, form: str) -> None:
        url = url.rstrip("/") + self.path
        protocols = [Subprotocol(self.subprotocol)] if self.subprotocol else None
        self._connection = connect(
            url,
            max_size=None,
            max_queue=64,
            compression=None,
            subprotocols=protocols,
            origin=Origin(f"http://{urlsplit(url).netloc}"),  # the server's own, as of its page
        )
        request = self.request(topic, type, form)
        self._connection.send(request)
        self.for_others = (url, self.subprotocol, request, self.acknowledgement)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self._connection.close()

    def receive(self) -> Any:
        """Return the next frame."""
        return self._connection.recv(timeout=TIMEOUT)

    def next_sent_at(self) -> float:
        """Wait for the next message, and return when it was sent."""
        while (sent := self.sent_at(self.receive())) is None:
            pass
        if self.acknowledgement:
            self._connection.send(self.acknowledgement)
        return sent

    def request(self, topic: str, type: str, form: str) -> str:
        """Return the frame that subscribes."""
        raise NotImplementedError

    def sent_at(self, frame: Any) -> float | None:
        """Parse a frame as a client does, and return when its message was sent; None if there is none in it."""
        raise NotImplementedError


class RosbridgeClient(Client):
    """As programs with roslibjs or roslibpy."""

    def request(self, topic: str, type: str, form: str) -> str:
        return json.dumps({"op": "subscribe", "topic": topic, "type": type, "compression": form})

    def sent_at(self, frame: Any) -> float | None:
        if isinstance(frame, str):
            value = json.loads(frame)
            if value["op"] == "png":
                from pyros1.web.rosbridge import png

                value = json.loads(png.unpack(value["data"], 1 << 26))
        else:
            import cbor2

            value = cbor2.loads(frame)
        message = value["msg"]
        if "bytes" in message:
            return _stamp(message["bytes"])
        if "header" in message:
            return float(message["header"]["stamp"]["secs"] + message["header"]["stamp"]["nsecs"] / 1e9)
        return float(message["data"])


class FoxgloveViewer(Client):
    """As the Foxglove app, or Lichtblick."""

    subprotocol = "foxglove.websocket.v1"

    def request(self, topic: str, type: str, form: str) -> str:
        self._is_number = type == "std_msgs/Float64"
        while True:
            frame = self.receive()
            for channel in json.loads(frame).get("channels", ()) if isinstance(frame, str) else ():
                if channel["topic"] == topic:
                    return json.dumps({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": channel["id"]}]})

    def sent_at(self, frame: Any) -> float | None:
        if isinstance(frame, str) or frame[0] != 1:
            return None
        return float(struct.unpack_from("<d", frame, 13)[0]) if self._is_number else _stamp(frame[13:])


class Page(Client):
    """As the server's own page with one panel; it acknowledges each frame."""

    path = "/ws"
    subprotocol = "pyros1.v1"
    acknowledgement = '{"next":1}'

    def request(self, topic: str, type: str, form: str) -> str:
        return json.dumps({"open": _VIEWS.get(type, "message"), "stream": 1, "args": {"topic": topic}})

    def sent_at(self, frame: Any) -> float | None:
        if isinstance(frame, bytes):
            frame = frame[4 : 4 + int.from_bytes(frame[:4], "little")]
        data = json.loads(frame).get("data", {})
        if "stamp" in data:
            return float(data["stamp"])
        return float(data["value"]["fields"][0][2]) if "value" in data else None


CLIENTS: dict[str, type[Client]] = {"foxglove": FoxgloveViewer, "page": Page}
"""Those that are not of rosbridge."""


def _stamp(message: bytes) -> float:
    """Return the time in the header of an encoded message."""
    return int.from_bytes(message[4:8], "little") + int.from_bytes(message[8:12], "little") / 1e9


def receive_only(url: str, subprotocol: str, request: str, acknowledgement: str, count: int) -> None:
    """Be several clients that discard what they receive, but answer pings, and acknowledge messages if a page does."""
    selector = selectors.DefaultSelector()
    protocol = f"Sec-WebSocket-Protocol: {subprotocol}\r\n" if subprotocol else ""
    for _ in range(count):
        link = socket.create_connection((urlsplit(url).hostname, urlsplit(url).port))
        key = base64.b64encode(os.urandom(16)).decode()
        link.sendall(
            f"GET {urlsplit(url).path} HTTP/1.1\r\nHost: {urlsplit(url).netloc}\r\n"
            f"Origin: http://{urlsplit(url).netloc}\r\nUpgrade: websocket\r\n{protocol}"
            f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        buffer = bytearray()
        while b"\r\n\r\n" not in buffer:
            buffer += link.recv(4096)
        del buffer[: buffer.index(b"\r\n\r\n") + 4]
        link.sendall(masked(0x81, request.encode()))
        selector.register(link, selectors.EVENT_READ, (buffer, [0]))
    while True:
        for key_and_data, _ in selector.select():
            link, (buffer, skip) = key_and_data.fileobj, key_and_data.data  # type: ignore[assignment]
            data = link.recv(1 << 20)
            if not data:
                return
            buffer += data
            for ping in frames(buffer, skip):
                if ping is not None:
                    link.sendall(masked(0x8A, ping))
                elif acknowledgement:
                    link.sendall(masked(0x81, acknowledgement.encode()))


def masked(first: int, payload: bytes) -> bytes:
    """Return a client's frame."""
    size = bytes((0x80 | len(payload),)) if len(payload) < 126 else struct.pack(">BH", 0x80 | 126, len(payload))
    return bytes((first,)) + size + bytes(4) + payload


def frames(buffer: bytearray, skip: list[int]) -> Iterator[bytes | None]:
    """Remove frames from a buffer, and yield the payloads of pings, and None for each other frame as it begins.

    ``skip``: bytes missing of the last frame.
    """
    while True:
        gone = min(skip[0], len(buffer))
        del buffer[:gone]
        skip[0] -= gone
        if skip[0] or len(buffer) < 2:
            return
        size, start = buffer[1], 2
        if size >= 126:
            start = 4 if size == 126 else 10
            if len(buffer) < start:
                return
            size = int.from_bytes(buffer[2:start], "big")
        if buffer[0] == 0x89:
            if len(buffer) < start + size:
                return
            yield bytes(buffer[start : start + size])
        else:
            yield None
        skip[0] = start + size
