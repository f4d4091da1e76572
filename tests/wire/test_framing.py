"""framing: any cut of a stream gives the same frames; lengths on a lie cost nothing (T02, T03)."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import ProtocolError
from pyros1.wire.framing import FrameBuffer


def feed(buffer: FrameBuffer, data: bytes) -> list[bytes]:
    frames = []
    while data:
        view = buffer.writable()
        count = min(len(view), len(data))
        view[:count] = data[:count]
        frames += [bytes(buffer.data[a:b]) for a, b in buffer.received(count)]
        data = data[count:]
    return frames


@given(st.lists(st.binary(max_size=100), max_size=20), st.integers(1, 64), st.integers(8, 70), st.integers(0, 30))
def test_any_cut_gives_the_same_frames(bodies: list[bytes], step: int, capacity: int, first: int) -> None:
    stream = b"".join(struct.pack("<I", len(body)) + body for body in bodies)
    buffer = FrameBuffer(capacity, initial_bytes=stream[:first])
    got = [bytes(buffer.data[a:b]) for a, b in buffer.received(0)]
    for start in range(first, len(stream), step):
        got += feed(buffer, stream[start : start + step])
    assert got == bodies


@given(st.binary(max_size=200))
def test_garbage_gives_frames_or_protocol_error(data: bytes) -> None:
    buffer = FrameBuffer(16, limit=1000)
    try:
        feed(buffer, data)
    except ProtocolError as error:
        assert "exceeds the limit" in str(error)


def test_t02_frame_over_the_limit_is_refused() -> None:
    with pytest.raises(ProtocolError, match="exceeds the limit"):
        feed(FrameBuffer(), b"\xff\xff\xff\xff")


def test_a_claim_costs_no_memory_however_slowly_its_bytes_come() -> None:
    buffer = FrameBuffer()
    buffer.feed((1_000_000_000).to_bytes(4, "little"))
    buffer.received(4)
    for _ in range(20):
        buffer.feed(b"x")
        buffer.received(1)
    assert len(buffer.data) <= 1 << 20


def test_claimed_length_is_not_allocated() -> None:
    buffer = FrameBuffer()
    feed(buffer, struct.pack("<I", 900_000_000) + b"x" * 100)
    assert len(buffer.data) <= 17 << 20


def test_large_frame_arrives_whole() -> None:
    body = bytes(range(256)) * 80_000
    buffer = FrameBuffer()
    assert feed(buffer, struct.pack("<I", len(body)) + body + b"\x01\x00\x00\x00z") == [body, b"z"]


def test_bytes_that_were_received_elsewhere_are_fed() -> None:
    body = bytes(range(200)) * 10
    whole = len(body).to_bytes(4, "little") + body
    buffer = FrameBuffer(64)
    buffer.feed(whole[:50])
    assert buffer.received(50) == []
    buffer.feed(whole[50:])
    [(start, end)] = buffer.received(len(whole) - 50)
    assert buffer.data[start:end] == body


def test_memory_for_large_frames_is_given_up_when_they_stop_to_come() -> None:
    large, small = bytes(1 << 20), b"small"
    buffer = FrameBuffer()
    for _ in range(3):
        assert feed(buffer, len(large).to_bytes(4, "little") + large) == [large]
        assert feed(buffer, len(small).to_bytes(4, "little") + small) == [small]
        assert len(buffer.data) >= len(large)
    for _ in range(1000):
        assert feed(buffer, len(small).to_bytes(4, "little") + small) == [small]
    assert len(buffer.data) <= 1 << 16


def test_memory_for_a_very_large_frame_is_given_up_when_it_is_taken() -> None:
    body = bytes(range(256)) * (80 << 10)
    buffer = FrameBuffer()
    for _ in range(2):
        whole = len(body).to_bytes(4, "little") + body
        while whole:
            view = buffer.writable()
            count = min(len(view), len(whole))
            view[:count] = whole[:count]
            frames, whole = buffer.received(count), whole[count:]
        assert buffer.take_bodies(frames) == [body]
        assert len(buffer.data) <= 1 << 16
    assert feed(buffer, b"\x01\x00\x00\x00z") == [b"z"]


def test_memory_is_not_given_up_while_a_part_of_a_frame_waits_in_it() -> None:
    body = bytes(range(256)) * 800
    whole = len(body).to_bytes(4, "little") + body
    buffer = FrameBuffer(64)
    assert feed(buffer, whole[:150_000]) == []
    buffer.shrink()
    assert feed(buffer, whole[150_000:]) == [body]


def test_bodies_are_taken_each_by_itself() -> None:
    buffer = FrameBuffer(initial_bytes=b"\x01\x00\x00\x00a\x00\x00\x00\x00\x02\x00\x00\x00bc\x05")
    assert buffer.take_bodies(buffer.received(0)) == [b"a", b"", b"bc"]
    assert buffer.has_partial_frame
