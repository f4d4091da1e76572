"""A simulated board, on a pseudo terminal or a socket."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.msgs import load_message

from ...bodies import encode

PATIENCE = 20.0


def frame(topic_id: int, data: bytes) -> bytes:
    """Return a frame, made as the protocol's page says, without the code under test."""
    length = len(data)
    low, high = length & 255, length >> 8
    body = [topic_id & 255, topic_id >> 8, *data]
    return bytes([0xFF, 0xFE, low, high, 255 - (low + high) % 256, *body, 255 - sum(body) % 256])


def topic_info(kind: int, topic_id: int, name: str, type_name: str, md5sum: str, size: int = 512) -> bytes:
    """Return the frame by which a board announces an endpoint."""
    info = load_message("rosserial_msgs/TopicInfo")(
        topic_id=topic_id, topic_name=name, message_type=type_name, md5sum=md5sum, buffer_size=size
    )
    return frame(kind, encode(info))


class Board:
    """A board that answers the request for its topics, and keeps what else it gets."""

    def __init__(self, read: Callable[[], bytes], write: Callable[[bytes], object], topics: list[bytes]) -> None:
        self.topics = topics
        self.write = write
        self.requests = 0
        self.frames: list[tuple[int, bytes]] = []
        self._read = read
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="board", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        pending = b""
        while True:
            try:
                data = self._read()
            except OSError:
                return
            if not data:
                return
            pending += data
            while len(pending) >= 8 and len(pending) >= 8 + pending[2] + 256 * pending[3]:
                size = 8 + pending[2] + 256 * pending[3]
                found, pending = pending[:size], pending[size:]
                self._take(found[5] + 256 * found[6], found[7:-1], found)

    def _take(self, topic_id: int, data: bytes, whole: bytes) -> None:
        with self._changed:
            if frame(topic_id, data) != whole:
                self.frames.append((-1, whole))
            elif topic_id == 0 and not data:
                self.requests += 1
                self.write(b"".join(self.topics))
            else:
                self.frames.append((topic_id, data))
            self._changed.notify_all()

    def send(self, topic_id: int, message: Any) -> None:
        self.write(frame(topic_id, encode(message)))

    def until(self, condition: Callable[[Board], Any]) -> None:
        with self._changed:
            assert self._changed.wait_for(lambda: condition(self), PATIENCE), (self.requests, self.frames)

    def wait(self, topic_id: int, count: int = 1) -> list[bytes]:
        """Wait for messages with a topic id, and return their data."""
        self.until(lambda board: sum(found == topic_id for found, _ in board.frames) >= count)
        return [data for found, data in self.frames if found == topic_id]

    def join(self) -> None:
        self._thread.join(PATIENCE)


class Socket:
    """A link under the name of a device, to which boards can be plugged."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._fds: list[int] = []
        self._board: Board | None = None
        self._unplugged = threading.Event()

    def plug(self, topics: list[bytes]) -> Board:
        master, slave = os.openpty()
        self._fds = [master, slave]
        self.path.symlink_to(os.ttyname(slave))
        self._unplugged.clear()

        def read() -> bytes:
            while not select.select([master], [], [], 0.02)[0]:
                if self._unplugged.is_set():
                    return b""
            return os.read(master, 4096)

        self._board = Board(read, lambda data: os.write(master, data), topics)
        return self._board

    def unplug(self) -> None:
        self.path.unlink(missing_ok=True)
        self._unplugged.set()
        if self._board is not None:
            self._board.join()
        for fd in self._fds:
            os.close(fd)
        self._fds = []


@pytest.fixture
def device(tmp_path: Path) -> Iterator[Socket]:
    found = Socket(tmp_path / "ttyACM0")
    yield found
    found.unplug()


@pytest.fixture
def tcp_board() -> Iterator[Callable[..., Board]]:
    """Return a function that connects a board to a port."""
    made: list[tuple[socket.socket, Board]] = []

    def make(port: int, topics: list[bytes]) -> Board:
        sock = socket.create_connection(("127.0.0.1", port), PATIENCE)
        sock.settimeout(None)
        board = Board(lambda: sock.recv(4096), sock.sendall, topics)
        board.hang_up = lambda: sock.shutdown(socket.SHUT_RDWR)  # type: ignore[attr-defined]
        made.append((sock, board))
        return board

    yield make
    for sock, board in made:
        with contextlib.suppress(OSError):
            sock.shutdown(socket.SHUT_RDWR)
        board.join()
        sock.close()
