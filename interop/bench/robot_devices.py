"""The devices of robot_works.py: a joystick on a pipe, and a board with rosserial on a socket."""

from __future__ import annotations

import io
import os
import socket
import struct
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pyros1.msgs import load_message
from pyros1.robot_nodes.rosserial_python.frames import encode_frame
from pyros1.robot_nodes.rosserial_python.session import Kind

PATIENCE = 20.0
_AXIS = 2
_TOPIC = 125


@dataclass(frozen=True)
class Stick:
    """A joystick, of which one axis moves.

    Attributes:
        path: its device, a pipe that is made; see `robot_works.Work`.
        hz: events per second.
    """

    path: str
    hz: float

    def open(self, node: Any, values: Mapping[str, str]) -> Callable[[float], object]:
        """Return a function that moves the axis, given the seconds since the first move."""
        path = self.path.format(**values)
        os.mkfifo(path)
        pipe = os.open(path, os.O_RDWR)  # a pipe can be opened for both without waiting for who reads
        return lambda seconds: os.write(
            pipe, struct.pack("<IhBB", 0, int(seconds * 10_000) % 60_000 - 30_000, _AXIS, 1)
        )


@dataclass(frozen=True)
class Board:
    """A board that publishes.

    Attributes:
        port: the TCP port at which the node waits for it.
        topic, type, hz, make: as of a `robot_works.Feed`.
    """

    port: str
    topic: str
    type: str
    hz: float
    make: Callable[[Any], Any]

    def open(self, node: Any, values: Mapping[str, str]) -> Callable[[float], object]:
        """Return a function that sends the next message."""
        cls = load_message(self.type)
        info = load_message("rosserial_msgs/TopicInfo")(_TOPIC, self.topic, self.type, cls._md5sum, 1024)
        connection = _connect(int(self.port.format(**values)))
        connection.sendall(encode_frame(Kind.PUBLISHER, _encoded(info)))
        frame = encode_frame(_TOPIC, _encoded(self.make(cls())))
        return lambda seconds: connection.sendall(frame)


def _connect(port: int) -> socket.socket:
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port))
        except ConnectionRefusedError:
            if time.monotonic() > end:
                raise
            time.sleep(0.05)


def _encoded(message: Any) -> bytes:
    stream = io.BytesIO()
    message.serialize(stream)
    return stream.getvalue()
