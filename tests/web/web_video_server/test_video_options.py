from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.web.web_video_server.video_options import VIDEO_TYPES, VideoOptions, parse_integer, parse_video_options


def test_options() -> None:
    assert parse_video_options({}, "vp8") == VideoOptions(None, 10, 42, 25, None, "ultrafast", "realtime")
    texts = {"bitrate": "500000", "qmin": "3", "qmax": "60", "gop": "50", "framerate": "15"}
    words = {"preset": "veryfast", "quality": "good"}
    assert parse_video_options(texts | words, "vp8") == VideoOptions(500_000, 3, 60, 50, 15, "veryfast", "good")
    assert parse_video_options(texts, "h264").qmax == 51
    assert parse_video_options({"preset": "x264", "quality": "80", "gop": "many"}, "h264") == VideoOptions()
    assert parse_video_options({"bitrate": "1"}, "vp8").bitrate == 1000
    assert parse_video_options({"qmin": "50", "qmax": "2"}, "vp8").qmax == 50


@pytest.mark.parametrize(
    ("text", "number"),
    [(None, 5), ("", 5), ("x", 5), ("3.5", 5), ("7", 7), ("-3", 0), ("99999999999999999999999999", 9), ("\0", 5)],
)
def test_numbers(text: str | None, number: int) -> None:
    assert parse_integer(text, 5, 0, 9) == number


@pytest.mark.slow
@given(
    st.dictionaries(
        st.sampled_from(["bitrate", "qmin", "qmax", "gop", "framerate", "preset", "quality"]),
        st.text(max_size=9) | st.integers().map(str),
    ),
    st.sampled_from(VIDEO_TYPES),
)
def test_any_text_gives_options_that_encoders_accept(texts: dict[str, str], stream_type: str) -> None:
    options = parse_video_options(texts, stream_type)
    assert options.bitrate is None or 1000 <= options.bitrate <= 100_000_000
    assert 0 <= options.qmin <= options.qmax <= (51 if stream_type == "h264" else 63)
    assert 1 <= options.gop <= 1000
    assert options.framerate is None or 1 <= options.framerate <= 120
