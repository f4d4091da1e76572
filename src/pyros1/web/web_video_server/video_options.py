"""Parses the video options in the URLs of web_video_server (no I/O)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

VIDEO_TYPES = ("h264", "vp8", "vp9")
"""The stream types that are videos rather than sequences of image files."""
_PRESETS = ("ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow", "slower", "veryslow", "placebo")
_QUALITIES = ("realtime", "good", "best")
_MIN_BITRATE, _MAX_BITRATE = 1000, 100_000_000
_MAX_FRAME_RATE = 120


@dataclass(frozen=True)
class VideoOptions:
    """The options for encoding a video. The defaults are those of the original.

    Attributes:
        bitrate: bits per second; None if the URL has none: then 100000 for VP8 and VP9, and a constant quality for
            H.264.
        qmin, qmax: the best and the worst quantization: 0 to 51 with H.264, 0 to 63 with VP8 and VP9.
        gop: the maximum number of images from one key frame to the next.
        framerate: the maximum number of images per second; None for all.
        preset: the preset of H.264, from "ultrafast" to "placebo", the slowest with the best compression.
        quality: the deadline of VP8: "realtime", "good" or "best".
    """

    bitrate: int | None = None
    qmin: int = 10
    qmax: int = 42
    gop: int = 25
    framerate: int | None = None
    preset: str = "ultrafast"
    quality: str = "realtime"


def parse_video_options(texts: Mapping[str, str], stream_type: str) -> VideoOptions:
    """Return the options in a URL's query. As in the original, malformed values mean the default.

    Args:
        texts: the fields of the query.
        stream_type: one of `VIDEO_TYPES`.
    """
    default = VideoOptions()
    largest = 51 if stream_type == "h264" else 63
    bitrate = parse_integer(texts.get("bitrate"), 0, 0, _MAX_BITRATE)
    qmin = parse_integer(texts.get("qmin"), default.qmin, 0, largest)
    preset, quality = texts.get("preset", ""), texts.get("quality", "")
    return VideoOptions(
        max(bitrate, _MIN_BITRATE) if bitrate else None,
        qmin,
        max(parse_integer(texts.get("qmax"), default.qmax, 0, largest), qmin),
        parse_integer(texts.get("gop"), default.gop, 1, 1000),
        parse_integer(texts.get("framerate"), 0, 0, _MAX_FRAME_RATE) or None,
        preset if preset in _PRESETS else default.preset,
        quality if quality in _QUALITIES else default.quality,
    )


def parse_integer(text: str | None, default: int, minimum: int, maximum: int) -> int:
    """Return a number, limited to a range; the default if the text is not a number."""
    try:
        number = int(text[:20]) if text else default
    except ValueError:
        number = default
    return min(max(number, minimum), maximum)
