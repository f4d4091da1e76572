"""What several threads do with one connection."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.robot_nodes.rosserial_python.board import Board
from pyros1.robot_nodes.rosserial_python.ports import PortError, TcpPort
from pyros1.robot_nodes.rosserial_python.servers import Servers


@pytest.fixture
def pair() -> Any:
    with socket.create_server(("127.0.0.1", 0)) as listener, socket.create_connection(listener.getsockname()) as far:
        near, _ = listener.accept()
        with near:
            yield near, far


def test_a_board_that_takes_nothing_is_disconnected_by_its_reader(pair: Any) -> None:
    near, _ = pair
    port = TcpPort(near, "the board")
    with pytest.raises(PortError, match="takes no data"):
        port.write(bytes(1 << 24))
    # If the writer closed the socket, the thread that reads could read from another one that got its number.
    assert near.fileno() >= 0
    with pytest.raises(PortError, match="the board took no data"):
        port.read()
    port.close()
    assert near.fileno() < 0


class SlowPort:
    """A port on which a frame takes until the next one is to be sent, or half a second."""

    def __init__(self) -> None:
        self.has_written = threading.Event()
        self.overlaps = self._num_writers = 0
        self._lock = threading.Lock()
        self._other_came = threading.Event()

    def read(self) -> bytes:
        return b""

    def write(self, data: bytes) -> None:
        with self._lock:
            self._num_writers += 1
            if self._num_writers > 1:
                self.overlaps += 1
                self._other_came.set()
        if len(data) > 8:
            self.has_written.set()
            self._other_came.wait(0.5)
        with self._lock:
            self._num_writers -= 1

    def close(self) -> None:
        pass


@pytest.mark.slow
def test_frames_of_several_threads_are_never_mixed(make_node: Callable[..., Any]) -> None:
    node, port = make_node("serial_node"), SlowPort()
    board = Board(node, "a board", "", lambda: None, Servers())
    reader = threading.Thread(target=board.run, args=(port,))
    reader.start()
    while not board.send(125, b"hello"):
        pass
    sender = threading.Thread(target=board.send, args=(125, b"hello"))
    port.has_written.clear()
    sender.start()
    assert port.has_written.wait(20)
    node.shutdown()
    for thread in (reader, sender):
        thread.join(20)
    board.close()
    assert port.overlaps == 0
