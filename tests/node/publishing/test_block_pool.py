"""pool: blocks of shared memory for large messages."""

from __future__ import annotations

import errno
import mmap
import os
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.node.same_host import host_key

if not host_key():
    pytest.skip("no shared memory on this system", allow_module_level=True)

from pyros1.node.publishing import block_pool as module
from pyros1.node.publishing.block_pool import MAX_BLOCKS, MAX_FREE_BLOCKS, Block, BlockPool, Placement


def frame(body: bytes) -> bytes:
    return len(body).to_bytes(4, "little") + body


def content(place: Placement) -> bytes:
    return place.block.memory[place.offset : place.offset + place.size]


@pytest.fixture
def pool() -> Any:
    made = BlockPool()
    yield made
    made.close()


def test_a_message_is_written_and_its_array_told(pool: BlockPool) -> None:
    array = bytes(range(256)) * 400
    head = b"head" + len(array).to_bytes(4, "little")
    parts: list[Any] = [(len(head) + len(array) + 2).to_bytes(4, "little") + head, array, b"tl"]
    place = pool.place(parts, set())
    assert place is not None and content(place) == head + array + b"tl"
    assert (place.array_begin, place.array_size) == (len(head), len(array))
    assert (place.offset + place.array_begin) % 64 == 0  # for those who calculate with it
    whole = pool.place(frame(array), set())
    assert whole is not None and content(whole) == array and (whole.array_begin, whole.array_size) == (0, 0)


def test_memory_that_its_owner_may_change_is_copied(pool: BlockPool) -> None:
    array = bytearray(b"a" * 100_000)
    place = pool.place([b"\0" * 8, memoryview(array).cast("H")], set())
    array[:] = b"b" * 100_000
    assert place is not None and content(place)[4:] == b"a" * 100_000


@pytest.mark.slow
@given(st.lists(st.tuples(st.integers(1, 1 << 20), st.sets(st.integers(1, 40), max_size=4)), max_size=60))
def test_blocks_that_are_in_use_are_not_written(steps: list[tuple[int, set[int]]]) -> None:
    pool = BlockPool()
    seen: dict[int, bytes] = {}
    for number, (size, wanted) in enumerate(steps):
        in_use = wanted & pool.blocks.keys()
        body = number.to_bytes(4, "little") * (size // 4 + 1)
        place = pool.place(frame(body), in_use)
        assert len(pool.blocks) <= MAX_BLOCKS
        if place is not None:
            assert place.block.number not in in_use and content(place) == body
            assert len(pool.blocks.keys() - in_use) <= MAX_FREE_BLOCKS + 1
            seen[place.block.number] = body
        for block in pool.blocks.values():
            if block.number in in_use:
                assert block.memory[: len(seen[block.number])] == seen[block.number]
    pool.close()


def test_there_is_an_end_to_it(pool: BlockPool, monkeypatch: pytest.MonkeyPatch) -> None:
    in_use: set[int] = set()
    while place := pool.place(frame(b"x" * 100_000), in_use):
        in_use.add(place.block.number)
    assert len(in_use) == MAX_BLOCKS
    pool.retire({1})
    assert pool.place(frame(b"x" * 100_000), in_use) is not None
    monkeypatch.setattr(module, "MAX_BYTES", 10 << 20)
    pool.close()
    assert pool.place(frame(bytes(11 << 20)), set()) is None


def test_messages_that_grow_leave_no_small_blocks_behind(pool: BlockPool) -> None:
    for size in range(100_000, 10_000_000, 300_000):
        assert pool.place(frame(bytes(size)), set()) is not None
    assert len(pool.blocks) <= MAX_FREE_BLOCKS + 1


def test_as_many_free_blocks_as_allowed_are_kept(pool: BlockPool) -> None:
    in_use: set[int] = set()
    for _ in range(MAX_FREE_BLOCKS):
        place = pool.place(frame(bytes(100_000)), in_use)
        assert place is not None
        in_use.add(place.block.number)
    assert pool.place(frame(bytes(100_000)), set()) is not None
    assert pool.blocks.keys() == in_use


def test_no_descriptors(pool: BlockPool, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any) -> int:
        raise OSError(errno.EMFILE, "Too many open files")

    with monkeypatch.context() as patch:
        patch.setattr(os, "memfd_create", fail)
        assert pool.place(frame(bytes(100_000)), set()) is None
    assert pool.place(frame(bytes(100_000)), set()) is not None


def test_a_block_that_cannot_be_opened_again_leaves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[Any] = []
    descriptors: list[int] = []
    create, mapped = os.memfd_create, mmap.mmap

    def memfd_create(*arguments: Any) -> int:
        descriptors.append(create(*arguments))
        return descriptors[-1]

    def fail(*_: Any) -> int:
        raise OSError(errno.EMFILE, "Too many open files")

    with monkeypatch.context() as patch:
        patch.setattr(os, "memfd_create", memfd_create)
        patch.setattr(mmap, "mmap", lambda *arguments: opened.append(mapped(*arguments)) or opened[-1])
        patch.setattr(os, "open", fail)
        with pytest.raises(OSError, match="Too many open files"):
            Block(1, 1 << 16)
    assert [memory.closed for memory in opened] == [True]
    with pytest.raises(OSError):
        os.fstat(descriptors[0])


def test_a_subscriber_cannot_write() -> None:
    block = Block(1, 1 << 16)
    with pytest.raises(PermissionError):
        mmap.mmap(block.fd, 1 << 16)
    with pytest.raises(OSError):
        os.ftruncate(block.fd, 1)
    with pytest.raises(OSError):
        os.write(block.fd, b"x")
    block.close()
    block.close()


def test_nothing_is_left_open(pool: BlockPool) -> None:
    before = os.listdir("/proc/self/fd")
    for _ in range(3):
        other = BlockPool()
        other.place(frame(bytes(100_000)), set())
        other.close()
    assert os.listdir("/proc/self/fd") == before
