from __future__ import annotations

import random
import sys
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pyros1.ground.errors import Error, MessageError
from pyros1.web.web_video_server.video_options import VIDEO_TYPES, VideoOptions, parse_video_options
from pyros1.web.web_video_server.videos import Video, import_av

av: Any = pytest.importorskip("av", reason="the extra `video` brings it")
CONTAINERS = {"h264": ("mp4", "h264"), "vp8": ("webm", "vp8"), "vp9": ("webm", "vp9")}


def colour(red: int, green: int, blue: int, width: int = 32, height: int = 24) -> NDArray[np.uint8]:
    return np.full((height, width, 3), (red, green, blue), np.uint8)


def decode(data: bytes) -> list[Any]:
    """Return the frames of a video, of which the end may be missing."""
    frames: list[Any] = []
    with av.open(BytesIO(data)) as container:
        try:
            frames.extend(container.decode(video=0))
        except av.error.FFmpegError:
            assert frames
    return frames


@pytest.mark.parametrize("stream_type", VIDEO_TYPES)
def test_colours_and_times(stream_type: str) -> None:
    shades = [colour(200, 30, 60), colour(20, 180, 90), colour(30, 40, 220)]
    video = Video(stream_type, VideoOptions(bitrate=1_000_000))
    data = b"".join(video.encode(shade, 100.0 + 0.25 * i) for i, shade in enumerate([*shades, shades[2]]))
    video.close()
    with av.open(BytesIO(data)) as container:
        stream = container.streams.video[0]
        found = container.format.name.split(","), stream.codec_context.name, stream.width, stream.height
    form, codec = CONTAINERS[stream_type]
    assert form in found[0] and found[1:] == (codec, 32, 24)
    assert video.content_type == f"video/{form}"
    frames = decode(data)
    assert len(frames) >= 3  # the last one is sent when its duration is known
    assert [round(frame.time, 2) for frame in frames[:3]] == [0.0, 0.25, 0.5]
    for frame, shade in zip(frames, shades, strict=False):
        assert np.abs(frame.to_ndarray(format="rgb24").astype(int) - shade).max() < 25


@pytest.mark.parametrize("stream_type", VIDEO_TYPES)
def test_an_image_is_sent_when_the_next_one_comes(stream_type: str) -> None:
    video = Video(stream_type, VideoOptions())
    data = b""
    for number in range(5):
        data += video.encode(colour(50 * number, 0, 0), float(number))
        if number:
            assert len(decode(data)) >= number
    video.close()


@pytest.mark.parametrize("stream_type", VIDEO_TYPES)
def test_all_sizes_and_kinds_in_one_video(stream_type: str) -> None:
    rng = np.random.default_rng(3)
    choose = random.Random(3)
    shapes = [(25, 33, 3), (1, 1, 1), (100, 3, 4), (7, 200, 3), (25, 33, 1)]
    shapes += [(choose.randint(1, 90), choose.randint(1, 90), choose.choice((1, 3, 4))) for _ in range(10)]
    video = Video(stream_type, VideoOptions(gop=3))
    data = b"".join(video.encode(rng.integers(0, 256, shape, np.uint8), i / 30) for i, shape in enumerate(shapes))
    video.close()
    frames = decode(data)
    assert len(frames) >= len(shapes) - 1
    assert {(frame.width, frame.height) for frame in frames} == {(34, 26)}  # the first one's, made even


def test_the_size_that_is_asked_for() -> None:
    video = Video("h264", VideoOptions(), 15, 40)
    data = b"".join(video.encode(colour(1, 2, 3), i / 30) for i in range(3))
    assert (decode(data)[0].width, decode(data)[0].height) == (16, 40)
    video.close()
    with pytest.raises(MessageError, match=r"the image has 5000x24 pixels.*add width="):
        Video("h264", VideoOptions(), 5000).encode(colour(1, 2, 3), 0.0)


@pytest.mark.parametrize("stream_type", VIDEO_TYPES)
def test_key_frames(stream_type: str) -> None:
    video = Video(stream_type, VideoOptions(gop=4))
    data = b"".join(video.encode(colour(50, 60, 70), i / 30) for i in range(13))
    video.close()
    assert [i for i, frame in enumerate(decode(data)) if frame.key_frame] == [0, 4, 8]


def test_times_that_do_not_advance() -> None:
    video = Video("vp8", VideoOptions())
    data = b"".join(video.encode(colour(1, 2, 3), now) for now in (5.0, 5.0, 4.0, 4.5, 6.0))
    video.close()
    times = [frame.time for frame in decode(data)]
    assert times == sorted(set(times)) and len(times) >= 4


@pytest.mark.parametrize("stream_type", VIDEO_TYPES)
def test_encoders_accept_all_options(stream_type: str) -> None:
    choose = random.Random(7)
    for _ in range(6):
        texts = {name: str(choose.randint(-5, 70)) for name in ("qmin", "qmax", "gop", "framerate")}
        texts["bitrate"] = str(choose.choice([-1, 0, 1, 10**5, 10**12]))
        texts["preset"] = choose.choice(["veryfast", "placebo", "?"])
        texts["quality"] = choose.choice(["good", "best", "?"])
        video = Video(stream_type, parse_video_options(texts, stream_type))
        data = b"".join(video.encode(colour(40 * i, 2, 3, 16, 16), i / 30) for i in range(4))
        video.close()
        assert len(decode(data)) >= 3


def test_a_bitrate_limits_h264() -> None:
    rng = np.random.default_rng(1)
    noise = [rng.integers(0, 256, (96, 128, 3), np.uint8) for _ in range(30)]

    def size(options: VideoOptions) -> int:
        video = Video("h264", options)
        total = sum(len(video.encode(image, i / 30)) for i, image in enumerate(noise))
        video.close()
        return total

    assert size(VideoOptions(bitrate=100_000, qmax=51)) < size(VideoOptions(qmax=51)) / 2


def test_closing_twice_or_before_the_first_image() -> None:
    video = Video("h264", VideoOptions())
    video.close()
    video.encode(colour(1, 2, 3), 0.0)
    video.close()
    video.close()


def test_without_pyav(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(Error, match=r"type vp8 need PyAV .*pip install 'pyros1\[video\]', or use type=mjpeg") as wrong:
        import_av("vp8")
    assert "\n" not in str(wrong.value)


def test_a_pyav_without_the_encoder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(av, "codecs_available", {"h264"})
    with pytest.raises(Error, match="with the encoder libx264"):
        Video("h264", VideoOptions())
