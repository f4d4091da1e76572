from __future__ import annotations

from contextlib import suppress
from http import HTTPStatus
from urllib.parse import urlencode

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.web.web_video_server.requests import MAX_SIDE, Rendering, Request, RequestProblem, parse_request
from pyros1.web.web_video_server.video_options import VideoOptions


def test_streams_and_snapshots() -> None:
    assert parse_request("/") == parse_request("/?topic=/x") == Request("/")
    assert parse_request("/stream?topic=/image_raw") == Request("/stream", "topic=/image_raw", "/image_raw")
    query = "topic=image&type=png&quality=7&width=320&height=200&invert&default_transport=compressed"
    rendering = Rendering("png", 7, 320, 200, True)
    assert parse_request(f"/stream?{query}") == Request("/stream", query, "image", "png", "compressed", rendering)
    assert parse_request("/stream?topic=a", "ros_compressed").stream_type == "ros_compressed"
    assert parse_request("/stream?topic=a&type=png").rendering.quality == 3
    snapshot = parse_request("/snapshot?topic=a&type=png&quality=50", "png")  # a snapshot is a JPEG file always
    assert (snapshot.stream_type, snapshot.rendering) == ("mjpeg", Rendering("jpeg", 50))
    assert parse_request("/snapshot?topic=a&type=vp8&gop=3") == parse_request(
        "/snapshot?topic=a&type=vp8&gop=3", "h264"
    )
    video = parse_request("/stream?topic=a&type=vp8&bitrate=500000&quality=best&width=320")
    assert (video.stream_type, video.video) == ("vp8", VideoOptions(500_000, quality="best"))
    assert video.rendering.width == 320


@pytest.mark.parametrize(
    ("url", "status", "text"),
    [
        ("/streams", HTTPStatus.NOT_FOUND, "no such page"),
        ("/stream", HTTPStatus.BAD_REQUEST, "lacks a topic"),
        ("/snapshot?topic=", HTTPStatus.BAD_REQUEST, "lacks a topic"),
        ("/stream?topic=a&type=gif", HTTPStatus.NOT_FOUND, "one of mjpeg, png, ros_compressed, h264, vp8, vp9"),
        ("/stream?topic=a&default_transport=theora", HTTPStatus.NOT_IMPLEMENTED, "raw or compressed"),
        ("/stream?topic=a&width=0", HTTPStatus.BAD_REQUEST, "the width must be from 1"),
        ("/stream?topic=a&height=8193", HTTPStatus.BAD_REQUEST, "the height must be from 1"),
        ("/stream?" + "a=1&" * 60, HTTPStatus.BAD_REQUEST, "not a valid URL"),
        ("//[", HTTPStatus.BAD_REQUEST, "not a valid URL"),
    ],
)
def test_what_is_refused(url: str, status: HTTPStatus, text: str) -> None:
    with pytest.raises(RequestProblem, match=text) as refused:
        parse_request(url)
    assert refused.value.status == status


@given(st.text(max_size=30))
def test_any_url_is_parsed_or_refused(text: str) -> None:
    for url in (text, f"/stream?topic=a&{text}", f"/snapshot?topic={text}"):
        with suppress(RequestProblem):
            assert isinstance(parse_request(url), Request)


@given(st.text(max_size=30), st.integers() | st.text(max_size=5), st.integers() | st.text(max_size=5))
def test_any_value_is_in_its_range(topic: str, quality: object, width: object) -> None:
    query = urlencode({"topic": "/" + topic, "quality": quality, "width": width})
    try:
        request = parse_request(f"/stream?{query}")
    except RequestProblem as problem:
        assert "the width must be" in str(problem)
        return
    assert request.topic == "/" + topic
    assert 1 <= request.rendering.quality <= 100
    assert request.rendering.width is None or 1 <= request.rendering.width <= MAX_SIDE
