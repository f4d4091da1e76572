"""H.264: what another decoder makes of the messages."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.bodies import decode, encode

from pyros1.bridge.conversions.conversion import Conversion
from pyros1.bridge.conversions.converters import Converter
from pyros1.bridge.conversions.video import KEY_FRAME_PERIOD, VIDEO, video_class
from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Header

av = pytest.importorskip("av")
RATE = 25.0


def image(number: int, height: int = 96, width: int = 128, encoding: str = "rgb8") -> Any:
    y, x = np.mgrid[0:height, 0:width]
    pixels = np.dstack([(x + 5 * number) % 256, y, np.full_like(x, 90)]).astype(np.uint8)
    if encoding == "mono16":
        data = (x * 300 + number).astype("<u2").tobytes()
    else:
        data = (pixels[:, :, 0] if encoding == "mono8" else pixels).tobytes()
    header = Header(frame_id="camera", stamp=Time(5, number))
    return Image(header, height, width, encoding, 0, len(data) // height, data)


class Viewer:
    """Decodes the pictures that come."""

    def __init__(self) -> None:
        self._context: Any = av.CodecContext.create("h264", "r")

    def see(self, body: bytes) -> Any:
        message = decode(video_class(), body)
        assert message.format == "h264" and message.frame_id == "camera" and message.timestamp.secs == 5
        (frame,) = self._context.decode(av.Packet(message.data))
        return frame


def converter() -> Converter:
    return Converter(Conversion("h264", 1e6), "sensor_msgs/Image")


def difference(frame: Any, message: Any) -> float:
    pixels = np.frombuffer(message.data, np.uint8).reshape(message.height, message.width, 3)
    return float(
        np.abs(frame.to_ndarray(format="rgb24")[: message.height, : message.width] - pixels.astype(int)).mean()
    )


def test_each_message_is_one_picture() -> None:
    video, viewer = converter(), Viewer()
    key_frames = []
    for number in range(60):
        given = image(number)
        frame = viewer.see(video.convert("/camera", encode(given), 100 + number / RATE))
        assert difference(frame, given) < 6, number
        if frame.key_frame:
            key_frames.append(number)
    assert key_frames == [0, round(KEY_FRAME_PERIOD * RATE)]


def test_who_comes_later_gets_a_key_frame() -> None:
    video = converter()
    for number in range(5):
        video.convert("/camera", encode(image(number)), number / RATE)
    video.restart()
    body = video.convert("/camera", encode(image(5)), 5 / RATE)
    assert b"\0\0\1\x65" in body, "an IDR picture, after which none refers to one before it"
    late = Viewer().see(body)
    assert late.key_frame and difference(late, image(5)) < 6
    assert not stands_alone(video.convert("/camera", encode(image(6)), 6 / RATE))


def stands_alone(body: bytes) -> bool:
    """Return whether a picture can be decoded without those before it."""
    try:
        return bool(av.CodecContext.create("h264", "r").decode(av.Packet(decode(video_class(), body).data)))
    except av.error.FFmpegError:
        return False


def test_publishers_are_videos_of_their_own() -> None:
    video, left, right = converter(), Viewer(), Viewer()
    for number in range(4):
        assert left.see(video.convert("/left", encode(image(number)), number / RATE)).width == 128
        assert right.see(video.convert("/right", encode(image(number, 64, 64)), number / RATE)).width == 64
    for number in range(6):  # more than are remembered
        video.convert(f"/other{number}", encode(image(0)), 1.0)
    assert Viewer().see(video.convert("/left", encode(image(4)), 1.0)).key_frame


def test_another_size_begins_with_a_key_frame() -> None:
    video = converter()
    video.convert("/camera", encode(image(0)), 0.0)
    frame = Viewer().see(video.convert("/camera", encode(image(1, 48, 64)), 0.1))
    assert frame.key_frame and (frame.width, frame.height) == (64, 48)


@pytest.mark.parametrize("encoding", ["mono8", "mono16"])
def test_grey_images_of_odd_size(encoding: str) -> None:
    frame = Viewer().see(converter().convert("/camera", encode(image(0, 33, 51, encoding)), 0.0))
    assert (frame.width, frame.height) == (52, 34)


def test_images_that_are_damaged() -> None:
    video = converter()
    given = image(0)
    given.data = given.data[:100]
    with pytest.raises(MessageError, match="has 100 bytes"):
        video.convert("/camera", encode(given), 0.0)
    with pytest.raises(MessageError):
        video.convert("/camera", b"nonsense", 0.0)
    assert Viewer().see(video.convert("/camera", encode(image(1)), 0.1)).key_frame


def test_the_type_is_foxgloves() -> None:
    cls = video_class()
    assert cls._type == VIDEO and cls.__slots__ == ["timestamp", "frame_id", "data", "format"]
    assert [*cls._slot_types] == ["time", "string", "uint8[]", "string"]
