from __future__ import annotations

import random
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.rosserial_python.frames import Frame, FrameReader, encode_frame

from .conftest import frame

_frames = st.tuples(st.integers(0, 65535), st.binary(max_size=80))


def feed(data: bytes, *sizes: int) -> tuple[list[Frame], FrameReader]:
    """Feed bytes in pieces of these sizes, in turn."""
    reader, found, start, turn = FrameReader(), [], 0, 0
    while start < len(data):
        size = sizes[turn % len(sizes)] if sizes else len(data)
        found += reader.feed(data[start : start + size])
        start, turn = start + size, turn + 1
    return found, reader


def test_the_frames_of_the_protocols_page() -> None:
    assert encode_frame(0, b"") == b"\xff\xfe\x00\x00\xff\x00\x00\xff"
    assert encode_frame(11, b"") == b"\xff\xfe\x00\x00\xff\x0b\x00\xf4"
    assert feed(b"\xff\xfe\x08\x00\xf7\x0a\x00" + bytes(8) + b"\xf5")[0] == [Frame(10, bytes(8))]


@given(_frames)
def test_frames_are_made_as_an_independent_program_makes_them(found: tuple[int, bytes]) -> None:
    assert encode_frame(*found) == frame(*found)


@given(st.lists(_frames, max_size=6), st.lists(st.integers(1, 30), min_size=1, max_size=5))
def test_frames_arrive_in_pieces_of_any_size(sent: list[tuple[int, bytes]], sizes: list[int]) -> None:
    found, reader = feed(b"".join(frame(*one) for one in sent), *sizes)
    assert found == sent and reader.skipped == 0 and not reader.has_partial_frame


@given(st.binary(max_size=60).filter(lambda data: 0xFF not in data), _frames)
def test_garbage_before_a_frame_is_skipped_and_counted(garbage: bytes, sent: tuple[int, bytes]) -> None:
    found, reader = feed(garbage + frame(*sent), 7)
    assert found == [sent] and reader.skipped == len(garbage)


def test_a_frame_that_was_cut_off_hides_no_others() -> None:
    sent = [(125, b"some text %d" % number) for number in range(4)]
    stream = frame(125, bytes(40))[:12] + b"".join(frame(*one) for one in sent)
    assert feed(stream, 3)[0] == sent


def test_a_wrong_length_delays_frames_until_the_rest_is_given_up() -> None:
    stream = b"\xff\xfe\xff\x7f\x81" + frame(125, b"first") + frame(125, b"second")
    found, reader = feed(stream)
    assert found == [] and reader.has_partial_frame
    assert reader.give_up() == [(125, b"first"), (125, b"second")]
    assert reader.skipped == 5 and not reader.has_partial_frame


@pytest.mark.parametrize("seed", range(30))
def test_one_wrong_byte_costs_one_frame_at_most(seed: int) -> None:
    """Each frame is found, or was hit. A changed length needs more data, which follows here."""
    chance = random.Random(seed)
    sent = [(100 + number, chance.randbytes(chance.randrange(20))) for number in range(10)]
    parts = [frame(*one) for one in sent]
    hit = chance.randrange(10)
    wrong = bytearray(parts[hit])
    wrong[chance.randrange(len(wrong))] ^= 1 << chance.randrange(8)
    found, reader = feed(b"".join([*parts[:hit], bytes(wrong), *parts[hit + 1 :]]) + bytes(70000))
    while reader.has_partial_frame:
        found += reader.give_up()
    assert [one for one in found if one in sent] == sent[:hit] + sent[hit + 1 :]


@pytest.mark.slow
@given(st.binary(max_size=300), st.integers(1, 50))
def test_random_bytes_are_no_frames_and_are_not_kept(data: bytes, size: int) -> None:
    found, reader = feed(data + bytes(66000), size, 66000)
    while reader.has_partial_frame:
        found += reader.give_up()
    used = sum(len(one.data) + 8 for one in found)
    assert reader.skipped + used == len(data) + 66000


def test_a_new_connection_starts_with_a_new_frame() -> None:
    reader = FrameReader()
    reader.feed(frame(125, b"text")[:9])
    reader.clear()
    assert reader.feed(frame(125, b"text")) == [(125, b"text")] and reader.skipped == 0


def test_frames_that_seem_to_begin_in_each_other_take_little_time() -> None:
    longest = b"\xff\xfe\xff\xff\x01\x00"  # the head of a frame with 65535 bytes, whose checksum is wrong
    reader = FrameReader()
    start = time.process_time()
    assert reader.feed(longest * 50_000) == [] and reader.skipped > 200_000
    assert time.process_time() - start < 5.0  # it would take about 20 s to add them up anew


@given(st.binary(max_size=20), st.lists(st.sampled_from([b"\xff", b"\xff\xfe", b"\x00", b"\x01", b"\x02", b"\xfd"])))
def test_any_bytes_are_frames_or_skipped(before: bytes, parts: list[bytes]) -> None:
    """As a slow search for frames, one place after the other, finds them."""
    stream = before + b"".join(parts) + frame(125, b"end") + b"".join(reversed(parts))
    expected, place = [], 0
    while place < len(stream):
        end = place + 8 + int.from_bytes(stream[place + 2 : place + 4], "little")
        whole = stream[place:end]
        if len(whole) >= 8 and frame(int.from_bytes(whole[5:7], "little"), whole[7:-1]) == whole:
            expected.append((int.from_bytes(whole[5:7], "little"), whole[7:-1]))
            place = end
        else:
            place += 1
    found, reader = feed(stream, 3)
    while reader.has_partial_frame:
        found += reader.give_up()
    assert found == expected
