"""The receiving end of a link from a publisher that shares memory with this process; see `pyros1.wire.local`."""

from __future__ import annotations

import contextlib
import mmap
import os
import socket
import struct
from collections import deque
from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import ProtocolError
from pyros1.msgs.large_arrays import SplitBody
from pyros1.node.subscribing.queues import Batch, Items
from pyros1.node.subscribing.tcp_source import TcpSource
from pyros1.wire.framing import MAX_MESSAGE_SIZE
from pyros1.wire.local import (
    MAX_RECORD_SIZE,
    REFERENCE_SIZE,
    TOKEN_SIZE,
    Reference,
    decode_block,
    decode_reference,
    encode_release,
)

MAX_BLOCKS = 64
"""Maximum number of memory blocks that one publisher may share."""
MAX_IN_PLACE = 3
"""Maximum number of messages that a program may keep in the publisher's memory; further ones are copied."""
_unpack_u32 = struct.Struct("<I").unpack_from
MAX_UNSENT_RELEASES = 1000  # a publisher has only a few outstanding references at a time
_SEALS = 0x2 | 0x4  # F_SEAL_SHRINK and F_SEAL_GROW


class BorrowedBlock:
    """The right to read a message in the publisher's memory; it is given back when this object is destroyed.

    Args:
        number: number of the reference to the message.
        release: called with the number to give the right back.
    """

    __slots__ = ("_number", "_release")

    def __init__(self, number: int, release: Callable[[int], None]) -> None:
        self._number = number
        self._release = release

    def __del__(self) -> None:
        self._release(self._number)


class SharedBody(SplitBody):
    """An encoded message in the publisher's memory.

    Args:
        memory: the block of memory.
        reference: the position of the message and of its array in the block.
        borrowed: the right to read the message, kept as long as the memory is needed.
        in_use: reference numbers of the messages that the program reads in place.
    """

    __slots__ = ("_borrowed", "_copy", "_in_use", "_memory", "_reference")

    def __init__(self, memory: mmap.mmap, reference: Reference, borrowed: BorrowedBlock, in_use: set[int]) -> None:
        begin = reference.offset + reference.array_begin
        end = begin + reference.array_size
        super().__init__(memory[reference.offset : begin - 4], b"", memory[end : reference.offset + reference.size])
        self._memory: mmap.mmap | None = memory
        self._reference = reference
        self._borrowed: BorrowedBlock | None = borrowed
        self._in_use = in_use
        self._copy = b""

    def array(self, *, in_place: bool) -> Any:
        """Return the array: in place if requested, unless too many are kept already; otherwise a copy."""
        if self._memory is None:
            return self._copy
        begin, size = self._reference.offset + self._reference.array_begin, self._reference.array_size
        if in_place and self._borrowed is not None and len(self._in_use) < MAX_IN_PLACE:
            return _view_in_place(
                self._memory, begin, size, _InPlaceUse(self._borrowed, self._in_use, self._reference.number)
            )
        self._copy = self._memory[begin : begin + size]
        self._memory = self._borrowed = None
        return self._copy

    def join(self) -> bytes:
        """Return the whole encoded message as bytes."""
        if self._memory is not None:
            begin = self._reference.offset
            return self._memory[begin : begin + self._reference.size]
        array = self.array(in_place=False)
        return b"".join((self.head, len(array).to_bytes(4, "little"), array, self.tail))


class _InPlaceUse:
    """Keeps the memory borrowed while an array in it is read in place."""

    __slots__ = ("_borrowed", "_in_use", "_number")

    def __init__(self, borrowed: BorrowedBlock, in_use: set[int], number: int) -> None:
        self._borrowed = borrowed
        self._in_use = in_use
        self._number = number
        in_use.add(number)

    def __del__(self) -> None:
        self._in_use.discard(self._number)


def _view_in_place(memory: mmap.mmap, begin: int, size: int, owner: _InPlaceUse) -> memoryview:
    """Return a read-only view of part of the memory; the view and all objects made from it keep ``owner`` alive."""
    import ctypes  # noqa: PLC0415 - few programs read in place

    array: Any = (ctypes.c_ubyte * size).from_buffer(memory, begin)
    array.owner = owner
    return memoryview(array).cast("B").toreadonly()


class SharedSource(TcpSource):
    """A link, after the handshake, from a publisher that shares memory with this process.

    Args:
        sock, uri, header, initial_bytes: as for TcpSource.
        control_socket: the socket that came with the publisher's header.

    Raises:
        ProtocolError: the publisher's header has no usable token.
    """

    transport = "LOCAL"

    def __init__(
        self, sock: socket.socket, uri: str, header: dict[str, str], initial_bytes: bytes, control_socket: socket.socket
    ) -> None:
        try:
            self._token = bytes.fromhex(header["token"])
        except (KeyError, ValueError):
            self._token = b""
        if len(self._token) != TOKEN_SIZE:
            raise ProtocolError(f"publisher {uri}: no token in its connection header")
        super().__init__(sock, uri, {key: value for key, value in header.items() if key != "token"}, initial_bytes)
        self._is_latched = header.get("latching") == "1"
        self._control_socket = control_socket
        control_socket.setblocking(False)
        self._blocks: dict[int, mmap.mmap] = {}
        self._in_use: set[int] = set()
        self._unsent_releases: deque[bytes] = deque()  # not sent yet, since the control socket was full
        self._pid = os.getpid()

    def close(self) -> None:
        """Close the link's sockets. Messages that are read in place remain valid."""
        self._control_socket.close()
        super().close()

    def batch(self, frames: list[tuple[int, int]]) -> Batch:
        """Take complete frames out of the buffer; each reference is replaced with the message that it refers to.

        Raises:
            ProtocolError: a reference is not valid.
        """
        if self.buffer.data.find(self._token, frames[0][0], frames[-1][1]) < 0:
            return super().batch(frames)
        return Items(self, map(self._resolve, self.buffer.take_bodies(frames)))

    def _resolve(self, body: bytes) -> bytes | SplitBody:
        """Return the message that a frame contains or refers to."""
        reference = decode_reference(self._token, body)
        if reference is None:
            return body
        if reference.size > MAX_MESSAGE_SIZE:
            raise ProtocolError(f"message of {reference.size} bytes exceeds the limit of {MAX_MESSAGE_SIZE} bytes")
        if len(self._unsent_releases) > MAX_UNSENT_RELEASES:
            raise ProtocolError("the publisher does not read the releases of messages in shared memory")
        borrowed = BorrowedBlock(reference.number, self._release)
        memory = self._receive_block(reference.block)
        if reference.offset + reference.size > len(memory):
            raise ProtocolError("a message in shared memory is not inside its block")
        self.bytes_received += reference.size - REFERENCE_SIZE
        array_start = reference.offset + reference.array_begin
        if reference.array_begin == 0 or _unpack_u32(memory, array_start - 4)[0] != reference.array_size:
            return memory[reference.offset : reference.offset + reference.size]
        message = SharedBody(memory, reference, borrowed, self._in_use)
        if self._is_latched:  # the message may be kept for later subscribers
            return message.join()
        return message

    def _receive_block(self, number: int) -> mmap.mmap:
        while number not in self._blocks:
            try:
                record, descriptors, _, _ = socket.recv_fds(self._control_socket, MAX_RECORD_SIZE, 4)
            except ConnectionResetError:
                continue  # the publisher has exited; what it wrote before can still be received
            except OSError as error:
                raise ProtocolError(f"a block of shared memory was not received: {error.strerror or error}") from None
            try:
                self._map_block(record, descriptors)
            finally:
                for descriptor in descriptors:
                    os.close(descriptor)
        return self._blocks[number]

    def _map_block(self, record: bytes, descriptors: list[int]) -> None:
        number, size = decode_block(record)
        if not size:
            self._blocks.pop(number, None)
            return
        if len(descriptors) != 1:
            raise ProtocolError("a block of shared memory came without its descriptor: are too many files open?")
        import fcntl  # noqa: PLC0415 - not on all systems

        if len(self._blocks) >= MAX_BLOCKS:
            raise ProtocolError(f"more than {MAX_BLOCKS} blocks of shared memory")
        try:
            if fcntl.fcntl(descriptors[0], fcntl.F_GET_SEALS) & _SEALS != _SEALS:
                raise ProtocolError("a block of shared memory is not sealed against resizing")
            if os.fstat(descriptors[0]).st_size < size:
                raise ProtocolError("a block of shared memory is smaller than announced")
            self._blocks[number] = mmap.mmap(descriptors[0], size, access=mmap.ACCESS_COPY)
        except (OSError, ValueError, OverflowError) as error:
            raise ProtocolError(f"a block of shared memory cannot be read: {error}") from None

    def _release(self, number: int) -> None:
        """Release a reference. Thread-safe and reentrant, since it may run whenever an object is destroyed."""
        if os.getpid() != self._pid:
            return  # a forked process has a copy of the message; the original process still reads it
        unsent = self._unsent_releases
        unsent.append(encode_release(number))
        with contextlib.suppress(IndexError, OSError):  # all have been sent, or the publisher is gone
            while True:
                record = unsent.popleft()  # each record goes to only one thread
                try:
                    self._control_socket.send(record)
                except BlockingIOError:
                    unsent.append(record)
                    return
