"""Frames of clients, sound and hostile: each gives an operation or an error, in bounded memory."""

from __future__ import annotations

import base64
import io
import json
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from pyros1.web.rosbridge import frames, png
from pyros1.web.rosbridge.frame_decoder import MAX_FRAME, FrameDecoder
from pyros1.web.rosbridge.operations import (
    MAX_CALL_SECONDS,
    Advertise,
    BridgeError,
    CallService,
    Publish,
    Subscribe,
    Unsubscribe,
)

PUBLISH = json.dumps({"op": "publish", "topic": "/t", "msg": {"data": "hällo" * 50}})


def decode(**frame: Any) -> Any:
    found = FrameDecoder().decode(json.dumps(frame))
    assert found is not None
    return found[1]


def test_operations() -> None:
    assert FrameDecoder().decode('{"op":"unsubscribe","topic":"/t","id":7}') == (7, Unsubscribe("/t", 7))
    assert decode(op="advertise", topic="t", type="a/B") == Advertise("t", "a/B", False, 100)
    assert decode(op="publish", topic="t", msg={"a": 1}) == Publish("t", {"a": 1})
    assert decode(op="subscribe", topic="t") == Subscribe("t", "", 0.0, 0, None, "none", None)
    assert decode(
        op="subscribe",
        id="x",
        topic="t",
        type="a/B",
        throttle_rate=50,
        queue_length=2,
        fragment_size=1,
        compression="png",
    ) == Subscribe("t", "a/B", 0.05, 2, 16, "png", "x")
    assert decode(op="call_service", service="s", args=[1]) == CallService("s", [1], MAX_CALL_SECONDS, None, "none")
    assert decode(op="call_service", service="s", timeout=1e9).timeout == MAX_CALL_SECONDS


@pytest.mark.parametrize(
    ("frame", "word"),
    [
        ("", "JSON"),
        (b"\xff", "JSON"),
        ("[]", "object"),
        ("{}", "op"),
        ('{"op":1}', "op"),
        ('{"op":"dance"}', "dance"),
        ('{"op":"publish"}', "topic"),
        ('{"op":"publish","topic":""}', "topic"),
        ('{"op":"publish","topic":"/\\ud800"}', "topic"),
        ('{"op":"advertise","topic":"/t"}', "type"),
        ('{"op":"advertise","topic":"/t","type":"a/B","latch":1}', "latch"),
        ('{"op":"subscribe","topic":"/t","throttle_rate":-1}', "throttle_rate"),
        ('{"op":"subscribe","topic":"/t","throttle_rate":NaN}', "throttle_rate"),
        ('{"op":"subscribe","topic":"/t","queue_length":true}', "queue_length"),
        ('{"op":"subscribe","topic":"/t","compression":"zip"}', "compression"),
        ('{"op":"set_level","level":"loud"}', "level"),
        ('{"op":"fragment","data":"","num":0,"total":2}', "id"),
        ('{"op":"fragment","id":"a","data":"","num":2,"total":2}', "fragment"),
        ('{"op":"fragment","id":"a","data":"","num":0,"total":1000000}', "fragments"),
        ('{"op":"png","data":"?"}', "image"),
        ("[" * 100_000, "JSON"),
        ("1" * 1000, "object"),
    ],
)
def test_what_is_no_operation(frame: str | bytes, word: str) -> None:
    with pytest.raises(BridgeError, match=word):
        FrameDecoder().decode(frame)


def test_an_error_has_the_id_of_the_operation() -> None:
    with pytest.raises(BridgeError) as caught:
        FrameDecoder().decode('{"op":"publish","id":"x"}')
    assert caught.value.id == "x"


@pytest.mark.parametrize("compression", ["none", "png"])
@pytest.mark.parametrize("size", [None, 16, 100])
def test_parts_are_put_together(compression: str, size: int | None) -> None:
    parts = [*frames.split(frames.compress(PUBLISH, compression), size, "p")]
    intake = FrameDecoder()
    for part in reversed(parts[1:]):  # in any order
        assert intake.decode(part) is None
    assert intake.decode(parts[0]) == FrameDecoder().decode(PUBLISH)


def test_a_character_that_was_cut_in_two() -> None:
    intake = FrameDecoder()
    part = {"op": "fragment", "id": 1, "total": 2}
    assert intake.decode(json.dumps({**part, "num": 0, "data": '{"op":"publish","topic":"t","msg":"\ud83d'})) is None
    found = intake.decode(json.dumps({**part, "num": 1, "data": '\ude00"}'}))
    assert found is not None
    assert found[1] == Publish("t", "\U0001f600")
    with pytest.raises(BridgeError, match="half"):
        intake.decode('{"op":"publish","topic":"t","msg":"\\ud83d"}')


def test_pictures_in_parts() -> None:
    data = png.pack(PUBLISH)
    intake = FrameDecoder()
    half = len(data) // 2
    first = {"op": "png", "id": 1, "data": data[:half], "num": 0, "total": 2}
    assert intake.decode(json.dumps(first)) is None
    assert intake.decode(json.dumps({**first, "data": data[half:], "num": 1})) == FrameDecoder().decode(PUBLISH)


def test_boxes_in_boxes() -> None:
    frame = PUBLISH
    for _ in range(5):
        frame = json.dumps({"op": "fragment", "data": frame, "num": 0, "total": 1})
    with pytest.raises(BridgeError, match="deeply"):
        FrameDecoder().decode(frame)


@pytest.mark.slow
def test_a_picture_that_unpacks_to_much_is_refused() -> None:
    file = io.BytesIO()
    Image.new("RGB", (5_000, 5_000)).save(file, "PNG")  # 75 MB
    frame = json.dumps({"op": "png", "data": base64.b64encode(file.getvalue()).decode()})
    assert len(frame) < MAX_FRAME
    with pytest.raises(BridgeError, match="at most"):
        FrameDecoder().decode(frame)


@pytest.mark.parametrize("letter", ["x", b"x", "\u00e9", "\ud83d\ude00"], ids=["text", "bytes", "accents", "pictures"])
def test_a_frame_that_is_too_long_is_refused(letter: str | bytes) -> None:
    frame = letter * (MAX_FRAME // len(letter) + 1)
    with pytest.raises(BridgeError, match=f"at most {MAX_FRAME} bytes"):
        FrameDecoder().decode(frame)
    joined = {"op": "fragment", "id": "a", "data": "x" * (MAX_FRAME // 2), "total": 2}
    intake = FrameDecoder()
    assert intake.decode(json.dumps({**joined, "num": 0})) is None
    with pytest.raises(BridgeError, match="JSON"):  # as long as it may be
        intake.decode(json.dumps({**joined, "num": 1}))


def test_parts_that_never_end_are_given_up() -> None:
    intake = FrameDecoder()
    part = {"op": "fragment", "data": "x" * 1000, "num": 0, "total": 2}
    for number in range(100):
        assert intake.decode(json.dumps({**part, "id": number})) is None
    assert intake.decode(json.dumps({**part, "id": 1, "num": 1})) is None  # the first part is forgotten
    big = {"op": "fragment", "id": "big", "data": "x" * (MAX_FRAME // 2), "total": 4}
    with pytest.raises(BridgeError, match="bytes"):
        for number in range(4):
            intake.decode(json.dumps({**big, "num": number}))


_json = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=10,
)
_NAMES = (
    "id topic type service msg args values data num total level timeout latch queue_size queue_length throttle_rate "
    "fragment_size compression result"
)
_OPS = (
    "advertise unadvertise publish subscribe unsubscribe call_service advertise_service unadvertise_service "
    "service_response set_level fragment png"
)
_names = st.sampled_from(_NAMES.split())
_ops = st.sampled_from(_OPS.split())


@given(st.binary(max_size=200) | st.text(max_size=200))
def test_any_bytes(frame: bytes | str) -> None:
    with pytest.raises(BridgeError):
        FrameDecoder().decode(frame)


@pytest.mark.slow
@given(_ops, st.dictionaries(_names, _json))
def test_any_fields(op: str, fields: dict[str, Any]) -> None:
    try:
        FrameDecoder().decode(json.dumps({**fields, "op": op}))
    except BridgeError as error:
        assert str(error)


@pytest.mark.parametrize("size", [0, 1, 2, 3, 4, 11, 12, 13, 5_000])
def test_pictures_of_texts_of_any_length(size: int) -> None:
    text = "".join(chr(32 + number % 90) for number in range(size))
    packed = png.pack(text)
    unpacked = png.unpack(packed, 10_000)
    assert unpacked.rstrip(b"\n") == text.encode() and len(unpacked) - size <= 3 * math.isqrt(size) + 3
    with Image.open(io.BytesIO(base64.b64decode(packed))) as image:
        assert (image.format, image.mode) == ("PNG", "RGB")
        assert abs(image.width - image.height) <= 2
