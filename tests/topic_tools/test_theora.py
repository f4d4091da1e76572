"""theora.ogv is a moving square, encoded by libtheora: one key frame and five differences of 40 x 24 pixels."""

from __future__ import annotations

import random
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pyros1.ground.errors import Error, MessageError
from pyros1.msgs.std_msgs.msg import Header
from pyros1.topic_tools.theora import TheoraDecoder, packet_class

av: Any = pytest.importorskip("av", reason="the extra `video` brings it")
FILE = Path(__file__).with_name("theora.ogv")


def packets() -> tuple[list[Any], list[Any]]:
    """Return the video's three headers and its other packets, as theora_image_transport sends them."""
    with av.open(str(FILE)) as container:
        extra = container.streams.video[0].codec_context.extradata
        bodies = [bytes(packet) for packet in container.demux() if packet.size]
    headers = []
    while extra:
        size = int.from_bytes(extra[:2], "big")
        headers.append(extra[2 : 2 + size])
        extra = extra[2 + size :]
    make = packet_class()
    both = [
        make(Header(seq=i), data, i == 0, 0, 0, i)  # the first one begins the stream
        for i, data in enumerate([*headers, *bodies])
    ]
    return both[:3], both[3:]


def expected() -> list[NDArray[Any]]:
    """Return the frames in the colours of theora_image_transport: BT.601 with all values from 0 to 255."""
    frames = []
    with av.open(str(FILE)) as container:
        for frame in container.decode(video=0):
            planes = frame.to_ndarray(format="yuv420p").astype(float)
            y = planes[:24]
            u, v = (part.reshape(12, 20).repeat(2, 0).repeat(2, 1) - 128 for part in (planes[24:30], planes[30:]))
            frames.append(np.dstack([y + 1.772 * u, y - 0.344136 * u - 0.714136 * v, y + 1.402 * v]).clip(0, 255))
    return frames


def pixels(image: Any) -> NDArray[Any]:
    return np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)


def test_the_type() -> None:
    assert packet_class()._md5sum == "33ac4e14a7cff32e7e0d65f18bb410f3"  # stock's


def test_a_video() -> None:
    headers, frames = packets()
    decoder = TheoraDecoder()
    assert [decoder.decode(header) for header in headers] == [None] * 3
    images: list[Any] = [decoder.decode(frame) for frame in frames]
    assert [image.header.seq for image in images] == [3, 4, 5, 6, 7, 8]
    assert {(image.width, image.height, image.encoding, image.step) for image in images} == {(40, 24, "bgr8", 120)}
    for image, frame in zip(images, expected(), strict=True):
        assert np.abs(pixels(image) - frame).mean() < 3.0
    assert not np.array_equal(pixels(images[0]), pixels(images[5]))


def test_an_empty_packet_repeats_the_image() -> None:
    headers, frames = packets()
    decoder = TheoraDecoder()
    for header in headers:
        decoder.decode(header)
    first: Any = decoder.decode(frames[0])
    again: Any = decoder.decode(packet_class()(Header(seq=77), b"", 0, 0, 0, 4))
    assert again.header.seq == 77 and first.header.seq == 3 and again.data == first.data


def test_who_comes_later_waits_for_a_key_frame() -> None:
    headers, frames = packets()
    decoder = TheoraDecoder()
    assert decoder.decode(frames[0]) is None  # without headers
    for packet in [*headers, *frames[1:]]:
        assert decoder.decode(packet) is None
    assert decoder.decode(frames[0]) is not None


def test_repeated_headers_do_not_interrupt_the_video() -> None:
    headers, frames = packets()
    decoder = TheoraDecoder()
    for packet in [*headers, frames[0], *headers]:
        decoder.decode(packet)
    image = decoder.decode(frames[1])
    assert image is not None and np.abs(pixels(image) - expected()[1]).mean() < 3.0


@pytest.mark.slow
def test_damaged_packets() -> None:
    headers, frames = packets()
    choose = random.Random(5)
    for _ in range(60):
        decoder = TheoraDecoder()
        for packet in [*headers, *frames]:
            data = bytearray(packet.data)
            if choose.random() < 0.2:
                data[choose.randrange(len(data))] = choose.randrange(256)
            if choose.random() < 0.1:
                del data[choose.randrange(len(data)) :]
            with suppress(MessageError):
                decoder.decode(packet_class()(Header(), bytes(data), 0, 0, 0, 0))
    for damaged in (b"\x80", b"\x80theora", b"\x85theora", b"\x80vorbis" + bytes(40), b"\x80theora" + bytes(70000)):
        with suppress(MessageError):
            TheoraDecoder().decode(packet_class()(Header(), damaged, 1, 0, 0, 0))


def test_enormous_videos_are_refused() -> None:
    headers, _ = packets()
    decoder = TheoraDecoder()
    headers[0].data = headers[0].data[:10] + b"\xff\xff\xff\xff" + headers[0].data[14:]
    with pytest.raises(MessageError, match="1048560x1048560 pixels"):
        for header in headers:
            decoder.decode(header)


def test_without_pyav(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(Error, match=r"theora needs PyAV .*: pip install 'pyros1\[video\]'"):
        TheoraDecoder()
