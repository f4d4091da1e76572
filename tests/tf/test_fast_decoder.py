"""What a listener receives equals the messages that the usual decoder makes, for any bytes."""

from __future__ import annotations

import struct
import sys
import threading
import tracemalloc
import warnings
from random import Random
from typing import Any

import pytest

from pyros1.ground.errors import MessageError
from pyros1.msgs import load_message
from pyros1.tf import Buffer, fast_decoder
from pyros1.tf.fast_decoder import ReceivedTransforms, make_decoder
from pyros1.tf.listener import add_to_buffer

from ..bodies import decode, encode

MESSAGE: Any = load_message("tf2_msgs/TFMessage")
STAMPED: Any = load_message("geometry_msgs/TransformStamped")
USUAL = "what the usual decoder is asked for"
DECODE: Any = make_decoder(lambda buffer, start, end, exact: (USUAL, buffer, start, end))
NAMES = ["", "/", "//a", "/a", "a", "b", "wörld", "链", "map", "a" * 300]


def message(random: Random) -> Any:
    made = MESSAGE()
    for _ in range(random.choice((0, 1, 1, 2, 20))):
        one = STAMPED()
        one.header.seq = random.getrandbits(32)
        one.header.stamp.secs, one.header.stamp.nsecs = random.getrandbits(32), random.getrandbits(32)
        one.header.frame_id, one.child_frame_id = random.choices(NAMES, k=2)
        for part in (one.transform.translation, one.transform.rotation):
            for name in part.__slots__:
                setattr(part, name, random.choice((0.0, 1.0, float("inf"), random.gauss(0, 1))))
        made.transforms.append(one)
    return made


def rows(made: Any) -> list[Any]:
    return [
        (
            one.header.frame_id,
            one.child_frame_id,
            one.header.stamp.secs * 10**9 + one.header.stamp.nsecs,
            tuple(
                getattr(part, name)
                for part in (one.transform.translation, one.transform.rotation)
                for name in part.__slots__
            ),
        )
        for one in made.transforms
    ]


def whole(body: bytes, exact: bool) -> bool:
    """Whether these bytes are a message, its names texts, and nothing else if exact."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", UnicodeWarning)
        try:
            names = [(one.header.frame_id + one.child_frame_id).encode() for one in decode(MESSAGE, body).transforms]
            size = 4 + sum(len(each) + 76 for each in names)
            return size == len(body) if exact else size <= len(body)
        except (MessageError, UnicodeWarning):
            return False


def test_random_messages() -> None:
    random = Random(1)
    for _ in range(300):
        body = encode(message(random))
        before, behind = random.randbytes(random.randrange(9)), encode(message(random))
        buffer = before + body + behind
        made = DECODE(buffer, len(before), len(before) + len(body))
        assert isinstance(made, ReceivedTransforms)
        assert made.rows == rows(decode(MESSAGE, body))


@pytest.mark.slow
def test_bodies_that_are_cut_longer_or_changed() -> None:
    """They are for the usual decoder, also if what follows in the buffer could be read on as a transform; longer ones
    only if that is to raise an error."""
    random, usual = Random(2), 0
    for _ in range(60):
        body = encode(message(random))
        for _ in range(30):
            changed = bytearray(body)
            if random.random() < 0.8:
                place = random.randrange(len(changed))
                if random.random() < 0.5:
                    changed[place] = random.getrandbits(8)
                else:
                    changed[place : place + 4] = struct.pack("<I", random.choice((0, 1, 2, 3, 21, 2**31, 2**32 - 1)))
            end = len(changed) + random.choice((0, 0, -1, 1, random.randrange(-len(changed), 200)))
            buffer = bytes(changed) + encode(message(random)) + random.randbytes(300)
            exact = random.random() < 0.5
            made = DECODE(buffer, 0, end, exact)
            if isinstance(made, ReceivedTransforms):
                assert repr(made.rows) == repr(rows(decode(MESSAGE, buffer[:end])))
            else:
                assert made == (USUAL, buffer, 0, end)
                usual += 1
            assert isinstance(made, ReceivedTransforms) == whole(buffer[:end], exact)
    assert usual > 500


def test_names_that_are_no_text_are_for_the_usual_decoder() -> None:
    made = MESSAGE([STAMPED()])
    made.transforms[0].child_frame_id = "tool"
    body = encode(made).replace(b"tool", b"t\xf6ol")
    assert DECODE(body, 0, len(body))[0] == USUAL


@pytest.mark.slow
@pytest.mark.once
def test_the_memory_for_names_is_bounded() -> None:
    take = make_decoder(lambda *_: None)
    made = MESSAGE([STAMPED()])
    tracemalloc.start()
    try:
        for number in range(40_000):
            made.transforms[0].child_frame_id = name = f"{number:0200}"
            body = encode(made)
            assert take(body, 0, len(body)).rows[0][:2] == ("", name)
        assert tracemalloc.get_traced_memory()[0] < 8e6  # 10,000 names as bytes and as texts take 5 MB
    finally:
        tracemalloc.stop()


def test_two_threads_may_receive_new_names_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """/tf and /tf_static share the names; one must not look for what the other has just forgotten."""
    monkeypatch.setattr(fast_decoder, "MAX_CACHED_NAMES", 4)
    take: Any = make_decoder(lambda *_: None)
    bodies, failed, interval = [], [], sys.getswitchinterval()
    for number in range(500):
        made = MESSAGE(transforms=[STAMPED(child_frame_id=f"child{number}")])
        made.transforms[0].header.frame_id = f"parent{number}"
        bodies.append(encode(made))

    def receive() -> None:
        try:
            for body in bodies * 20:
                take(body, 0, len(body))
        except KeyError as error:
            failed.append(error)

    threads = [threading.Thread(target=receive) for _ in range(2)]
    sys.setswitchinterval(1e-6)
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(30)
    finally:
        sys.setswitchinterval(interval)
    assert failed == []


def test_a_buffer_is_filled_in_the_same_way() -> None:
    """Buffers that got messages and what is received in their place answer, and complain, in the same words."""
    random = Random(3)
    told: tuple[list[str], list[str]] = ([], [])
    buffers = [Buffer(warn=words.append) for words in told]
    for _ in range(400):
        made = message(random)
        for one in made.transforms:
            one.header.stamp.secs, one.header.stamp.nsecs = random.choice(((5, 0), (6, 0), (random.randrange(40), 7)))
            if random.random() < 0.8:
                one.transform.rotation.x = one.transform.rotation.y = one.transform.rotation.z = 0.0
                one.transform.rotation.w = 1.0
            if random.random() < 0.05:
                one.transform.translation.x = float("nan")
        body = encode(made)
        static = random.random() < 0.1
        add_to_buffer(buffers[0], made, "/sender", static=static)
        add_to_buffer(buffers[1], DECODE(body, 0, len(body)), "/sender", static=static)
    assert told[0] == told[1]
    assert len(told[0]) > 20
    assert buffers[0].states() == buffers[1].states()
    assert buffers[0].all_frames_as_yaml(7.0) == buffers[1].all_frames_as_yaml(7.0)
