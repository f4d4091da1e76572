"""Blocks of shared memory into which a publisher writes large messages, once for all subscribers of its machine.

A block is a file without a name (``memfd_create``): no other user can open it, and the system frees it when the last
program that has it ends, for whatever reason. It is not written again before all subscribers have released it; a block
of a subscriber that left while using messages is never used again.
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
"""Maximum number of free blocks kept."""
_ALIGNMENT = 64  # alignment of a message's large array, for computations with it
_LENGTH = 4
_read_count = struct.Struct("<I").unpack_from


class Block:
    """One block.

    Args:
        number: of the block; none is used twice.
        size: in bytes.

    Attributes:
        fd: a descriptor through which it can only be read; -1: closed.

    Raises:
        OSError: there is no memory, or no descriptor.
    """

    __slots__ = ("fd", "memory", "number", "size")

    def __init__(self, number: int, size: int) -> None:
        import fcntl  # noqa: PLC0415 - not on all systems

        self.number = number
        self.size = size
        fd = os.memfd_create("pyros1", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.posix_fallocate(fd, 0, size)  # an error now instead of a fatal signal when it is written
            # A reader of a file that shrinks would be killed by the system.
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
        """Stop using the block. Subscribers keep their mappings of it."""
        descriptor, self.fd = self.fd, -1
        if descriptor >= 0:
            os.close(descriptor)
            self.memory.close()


class Placement(NamedTuple):
    """The place of a message; `offset`, `size`, `begin` and `array` as in `pyros1.wire.local.Reference`."""

    block: Block
    offset: int
    size: int
    begin: int
    array: int


class Pool:
    """The blocks of one topic. All methods are called in the topic's strand.

    Attributes:
        blocks: by their numbers.
    """

    def __init__(self) -> None:
        self.blocks: dict[int, Block] = {}
        self._last = 0
        self._process = os.getpid()

    @property
    def is_ours(self) -> bool:
        """Whether this is the process that created it. A forked process would use the same blocks and numbers."""
        return os.getpid() == self._process

    def place(self, frame: Frame, in_use: Set[int]) -> Placement | None:
        """Write a message into a free block.

        Args:
            frame: with its length.
            in_use: numbers of the blocks that subscribers have.

        Returns:
            Its place; None if there is no room, so that it must be sent in another way.
        """
        size = frame_size(frame) - _LENGTH
        begin = array = 0
        if not isinstance(frame, bytes) and 2 <= len(frame) <= 3:
            first, array = frame[0], memoryview(frame[1]).nbytes
            if len(first) >= 2 * _LENGTH and _read_count(first, len(first) - _LENGTH)[0] == array:
                begin = len(first) - _LENGTH  # an array of bytes, after its length
            else:
                array = 0
        offset = -begin % _ALIGNMENT
        block = self._find_free(size + offset, in_use)
        if block is None:
            return None
        _write(block.memory, offset, frame)
        return Placement(block, offset, size, begin, array)

    def retire(self, numbers: Set[int]) -> None:
        """Retire some blocks for good, since a subscriber has left while using messages in them."""
        for number in numbers:
            block = self.blocks.pop(number, None)
            if block is not None:
                block.close()

    def close(self) -> None:
        """Free all blocks."""
        self.retire(set(self.blocks))

    def _find_free(self, size: int, in_use: Set[int]) -> Block | None:
        free = [block for number, block in self.blocks.items() if number not in in_use]
        fitting = [block for block in free if block.size >= size]
        best = min(fitting, key=lambda block: block.size, default=None)
        free_blocks = len(free) - MAX_FREE_BLOCKS
        for block in free:  # blocks that are too small first: the messages have grown
            if free_blocks <= 0:
                break
            if block is not best:
                self.retire({block.number})
                free_blocks -= 1
        return best or self._allocate(size)

    def _allocate(self, size: int) -> Block | None:
        step = 1 << max(16, size.bit_length() - 3)  # so that messages of slightly different sizes fit as well
        size = -(-size // step) * step
        if len(self.blocks) >= MAX_BLOCKS or size + sum(b.size for b in self.blocks.values()) > MAX_BYTES:
            return None
        with contextlib.suppress(OSError, MemoryError, ValueError):
            self._last += 1
            block = self.blocks[self._last] = Block(self._last, size)
            return block
        return None


def _write(memory: mmap.mmap, offset: int, frame: Frame) -> None:
    skipped = _LENGTH
    for part in [frame] if isinstance(frame, bytes) else frame:
        data = memoryview(part).cast("B") if not isinstance(part, bytes) else memoryview(part)
        data = data[skipped:]
        skipped = 0
        memory[offset : offset + len(data)] = data
        offset += len(data)
