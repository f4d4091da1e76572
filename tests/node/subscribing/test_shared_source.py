"""SharedSource: what publishers send about shared memory is checked before it is used."""

from __future__ import annotations

import contextlib
import fcntl
import os
import socket
import struct
from collections.abc import Iterator
from typing import Any

import pytest

from pyros1.ground.errors import ProtocolError
from pyros1.node.same_host import host_key

if not host_key():
    pytest.skip("no shared memory on this system", allow_module_level=True)

from pyros1.node.subscribing import shared_source
from pyros1.node.subscribing.shared_source import SharedSource
from pyros1.wire.local import Reference, encode_block, encode_reference

TOKEN = bytes(range(16))
SIZE = 8192
ALL_SEALS = 0x2 | 0x4


class Publisher:
    """The publisher's ends of a link's two sockets."""

    def __init__(self, token: str | None = TOKEN.hex()) -> None:
        self.sock, sock = socket.socketpair()
        self.control, self.far_control = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        header = {"callerid": "/talker"} | ({} if token is None else {"token": token})
        try:
            self.source = SharedSource(sock, "http://talker", header, b"", self.far_control)
        except BaseException:
            for end in (self.sock, sock, self.control, self.far_control):
                end.close()
            raise

    def share(self, block: int = 1, size: int = SIZE, said: int = SIZE, seals: int = ALL_SEALS) -> None:
        """Send a block of memory, and how large it is said to be."""
        memory = os.memfd_create("test", os.MFD_ALLOW_SEALING)
        try:
            os.write(memory, bytes(i % 251 for i in range(size)))
            fcntl.fcntl(memory, fcntl.F_ADD_SEALS, seals)
            socket.send_fds(self.control, [encode_block(block, said)], [memory])
        finally:
            os.close(memory)

    def refer(self, block: int = 1, offset: int = 0, size: int = 100, array: tuple[int, int] = (0, 0)) -> Any:
        """Send a reference to a message; return the messages that the subscriber has then received.

        Args:
            array: where its array begins, and how many bytes it has.
        """
        self.sock.sendall(encode_reference(TOKEN, Reference(5, block, offset, size, *array)))
        batch = self.source.receive()
        return [] if batch is None else batch.newest(len(batch))

    def close(self) -> None:
        self.source.close()
        self.sock.close()
        self.control.close()


@pytest.fixture
def publisher() -> Iterator[Publisher]:
    publisher = Publisher()
    yield publisher
    publisher.close()


@pytest.mark.parametrize("token", [None, "no hexadecimal digits", "00ff"])
def test_a_header_without_a_token_is_refused(token: str | None) -> None:
    with pytest.raises(ProtocolError, match="publisher http://talker: no token in its connection header"):
        Publisher(token)


def test_a_message_in_shared_memory(publisher: Publisher) -> None:
    publisher.share()
    assert publisher.refer(offset=251, size=100) == [bytes(range(100))]
    assert publisher.control.recv(100) == struct.pack("<Q", 5), "it is given back"
    assert publisher.source.bytes_received == 4 + 100, "as if it had been sent"


def test_an_array_that_is_not_where_it_is_said_to_be(publisher: Publisher) -> None:
    publisher.share()
    assert publisher.refer(offset=251, size=100, array=(8, 50)) == [bytes(range(100))]


@pytest.mark.parametrize("offset", [SIZE - 99, SIZE, (1 << 32) - 1])
def test_a_message_outside_of_its_block(publisher: Publisher, offset: int) -> None:
    publisher.share()
    with pytest.raises(ProtocolError, match="a message in shared memory is not inside its block"):
        publisher.refer(offset=offset)


def test_memory_that_could_shrink_while_it_is_read(publisher: Publisher) -> None:
    publisher.share(seals=0x4)
    with pytest.raises(ProtocolError, match="a block of shared memory is not sealed against resizing"):
        publisher.refer()


def test_memory_that_is_smaller_than_it_is_said_to_be(publisher: Publisher) -> None:
    publisher.share(said=SIZE + 1)
    with pytest.raises(ProtocolError, match="a block of shared memory is smaller than announced"):
        publisher.refer()


def test_what_is_no_memory(publisher: Publisher) -> None:
    socket.send_fds(publisher.control, [encode_block(1, SIZE)], [publisher.sock.fileno()])
    with pytest.raises(ProtocolError, match="a block of shared memory cannot be read: "):
        publisher.refer()


def test_a_block_without_its_descriptor(publisher: Publisher) -> None:
    publisher.control.send(encode_block(1, SIZE))
    with pytest.raises(ProtocolError, match="came without its descriptor"):
        publisher.refer()


def test_there_is_an_end_to_blocks(publisher: Publisher, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shared_source, "MAX_BLOCKS", 2)
    for block in (1, 2):
        publisher.share(block)
        assert publisher.refer(block)
    publisher.control.send(encode_block(1, 0))  # is not used any more, and makes room
    publisher.share(3)
    assert publisher.refer(3)
    publisher.share(4)
    with pytest.raises(ProtocolError, match="more than 2 blocks of shared memory"):
        publisher.refer(4)


def test_a_block_that_was_never_sent(publisher: Publisher) -> None:
    with pytest.raises(ProtocolError, match="a block of shared memory was not received: "):
        publisher.refer()


@pytest.mark.parametrize("unread", [True, False])
def test_what_a_publisher_sent_before_its_end_is_received(publisher: Publisher, unread: bool) -> None:
    """Its system reports first that it did not read all."""
    publisher.share()
    if unread:
        with contextlib.suppress(BlockingIOError):
            publisher.far_control.send(bytes(8))
    publisher.control.close()
    assert publisher.refer(offset=251, size=100) == [bytes(range(100))]
