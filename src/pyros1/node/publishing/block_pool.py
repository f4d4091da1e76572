"""Blocks of shared memory into which a publisher writes large messages, once for all subscribers on its machine.

A block is an anonymous file (``memfd_create``): no other user can open it, and the system frees it when the last
program that uses it exits, for whatever reason. A block is not overwritten until all subscribers have released it. If a
subscriber disconnects while it is using a message, the block is never used again.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import struct
from collections.abc import Set
from typing import NamedTuple

from pyros1.wire.outqueue import Frame, frame_size

MAX_BLOCKS = 32
MAX_BYTES = 512 << 20
"""Maximum total size of all blocks of a topic, in bytes."""
MAX_FREE_BLOCKS = 4
"""Maximum number of free blocks to keep."""
_ALIGNMENT = 64  # in bytes, of a message's large array: makes computations on it fast
_LENGTH_SIZE = 4
_unpack_u32 = struct.Struct("<I").unpack_from


class Block:
    """A block of shared memory.

    Args:
        number: the unique number of the block.
        size: size in bytes.

    Attributes:
        fd: a read-only descriptor of the block; -1 if closed.

    Raises:
        OSError: there is not enough memory, or no free descriptor.
    """

    __slots__ = ("fd", "memory", "number", "size")

    def __init__(self, number: int, size: int) -> None:
        import fcntl  # noqa: PLC0415 - not on all systems

        self.number = number
        self.size = size
        fd = os.memfd_create("pyros1", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.posix_fallocate(fd, 0, size)  # raises an error if memory is lacking, which would later be a fatal signal
            # If the file could shrink, the system could kill its readers.
            fcntl.fcntl(fd, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL)
            self.memory = mmap.mmap(fd, size)
            try:
                self.fd = os.open(f"/proc/self/fd/{fd}", os.O_RDONLY | os.O_CLOEXEC)
            except OSError:
                self.memory.close()
                raise
        finally:
            os.close(fd)

    def close(self) -> None:
        """Close the descriptor and the mapping. Subscribers keep their own mappings."""
        descriptor, self.fd = self.fd, -1
        if descriptor >= 0:
            os.close(descriptor)
            self.memory.close()


class Placement(NamedTuple):
    """The place of a message in a block; for the fields after ``block`` see `pyros1.wire.local.Reference`."""

    block: Block
    offset: int
    size: int
    array_begin: int
    array_size: int


class BlockPool:
    """The blocks of a topic. All methods are called in the topic's strand.

    Attributes:
        blocks: the blocks by number.
    """

    def __init__(self) -> None:
        self.blocks: dict[int, Block] = {}
        self._last_number = 0
        self._pid = os.getpid()

    @property
    def is_own(self) -> bool:
        """Whether this process created the pool. A forked process must not use it: both would write to its blocks."""
        return os.getpid() == self._pid

    def place(self, frame: Frame, in_use: Set[int]) -> Placement | None:
        """Write a message into a free block.

        Args:
            frame: the encoded message, including the length prefix.
            in_use: numbers of the blocks that subscribers are using.

        Returns:
            The place of the message; None if there is no room, so that the message must be sent in another way.
        """
        size = frame_size(frame) - _LENGTH_SIZE
        array_begin = array_size = 0
        if not isinstance(frame, bytes) and 2 <= len(frame) <= 3:
            first, array_size = frame[0], memoryview(frame[1]).nbytes
            if len(first) >= 2 * _LENGTH_SIZE and _unpack_u32(first, len(first) - _LENGTH_SIZE)[0] == array_size:
                array_begin = len(first) - _LENGTH_SIZE  # an array of bytes, preceded by its length
            else:
                array_size = 0
        offset = -array_begin % _ALIGNMENT
        block = self._find_or_allocate(size + offset, in_use)
        if block is None:
            return None
        _write(block.memory, offset, frame)
        return Placement(block, offset, size, array_begin, array_size)

    def retire(self, numbers: Set[int]) -> None:
        """Close blocks and never use them again: they are not needed, or a subscriber disconnected while using them."""
        for number in numbers:
            block = self.blocks.pop(number, None)
            if block is not None:
                block.close()

    def close(self) -> None:
        """Free all blocks."""
        self.retire(set(self.blocks))

    def _find_or_allocate(self, size: int, in_use: Set[int]) -> Block | None:
        free_blocks = [block for number, block in self.blocks.items() if number not in in_use]
        fitting_blocks = [block for block in free_blocks if block.size >= size]
        smallest = min(fitting_blocks, key=lambda block: block.size, default=None)
        num_surplus = len(free_blocks) - MAX_FREE_BLOCKS
        for block in free_blocks:  # oldest first: they may have become too small, if the messages have grown
            if num_surplus <= 0:
                break
            if block is not smallest:
                self.retire({block.number})
                num_surplus -= 1
        return smallest or self._allocate(size)

    def _allocate(self, size: int) -> Block | None:
        # The size is rounded up, so that messages of slightly different sizes fit into the block.
        size_step = 1 << max(16, size.bit_length() - 3)
        size = -(-size // size_step) * size_step
        if len(self.blocks) >= MAX_BLOCKS or size + sum(b.size for b in self.blocks.values()) > MAX_BYTES:
            return None
        with contextlib.suppress(OSError, MemoryError, ValueError):
            self._last_number += 1
            block = self.blocks[self._last_number] = Block(self._last_number, size)
            return block
        return None


def _write(memory: mmap.mmap, offset: int, frame: Frame) -> None:
    skipped = _LENGTH_SIZE
    for part in [frame] if isinstance(frame, bytes) else frame:
        data = memoryview(part).cast("B") if not isinstance(part, bytes) else memoryview(part)
        data = data[skipped:]
        skipped = 0
        memory[offset : offset + len(data)] = data
        offset += len(data)
