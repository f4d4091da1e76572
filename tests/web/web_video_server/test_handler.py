"""Videos, and clients that send or read slowly."""

from __future__ import annotations

import http.client
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from io import BytesIO
from time import monotonic, sleep
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.node import Node
from pyros1.web.web_video_server import handler as handler_module
from pyros1.web.web_video_server import server as server_module
from pyros1.web.web_video_server.node import start
from pyros1.web.web_video_server.server import VideoServer
from pyros1.web.web_video_server.videos import Video

PATIENCE = 20.0


def image(shade: int, width: int = 32, height: int = 24) -> Any:
    return Image(None, height, width, "mono8", 0, width, bytes([shade]) * (width * height))


@pytest.fixture
def serve(make_node: Callable[..., Node]) -> Callable[..., VideoServer]:
    """Return a function that serves images."""
    return lambda *params: start(make_node("server", argv=["_port:=0", "_address:=127.0.0.1", *params]))


@pytest.fixture
def connect() -> Iterator[Callable[[VideoServer, bytes], socket.socket]]:
    """Return a function that sends bytes to a server on a new connection."""
    with ExitStack() as opened:

        def open_and_send(server: VideoServer, data: bytes) -> socket.socket:
            client = socket.create_connection(("127.0.0.1", server.port), PATIENCE)
            opened.callback(client.close)
            client.sendall(data)
            return client

        yield open_and_send


def get(client: socket.socket) -> http.client.HTTPResponse:
    response = http.client.HTTPResponse(client)
    response.begin()
    return response


def until(condition: Callable[[], object]) -> None:
    deadline = monotonic() + PATIENCE
    while not condition():
        assert monotonic() < deadline
        sleep(0.005)


@pytest.mark.parametrize(
    ("stream_type", "content_type", "codec"), [("h264", "video/mp4", "h264"), ("vp8", "video/webm", "vp8")]
)
def test_a_video(
    serve: Any, connect: Any, make_node: Callable[..., Node], stream_type: str, content_type: str, codec: str
) -> None:
    """Feature: web_video_server: streams as H.264, VP8 and VP9 -- needs `pip install 'pyros1[video]'`"""
    av: Any = pytest.importorskip("av", reason="the extra `video` brings it")
    server = serve()
    publisher = make_node("camera").advertise("/image", Image, latch=True)
    publisher.publish(image(20, 33, 25))
    client = connect(server, f"GET /stream?topic=/image&type={stream_type}&invert HTTP/1.0\r\n\r\n".encode())
    response = get(client)
    assert (response.status, response.getheader("Content-type")) == (200, content_type)
    body = b""

    def shades() -> list[int]:
        """Return the grey values of the frames that have arrived."""
        nonlocal body
        body += response.read1(100_000)
        with suppress(av.error.FFmpegError), av.open(BytesIO(body)) as container:
            assert container.streams.video[0].codec_context.name == codec
            found = []
            for frame in container.decode(video=0):
                assert (frame.width, frame.height) == (34, 26)
                found.append(round(float(np.mean(frame.to_ndarray(format="gray")))))
            return found
        return []

    until(lambda: any(abs(shade - 20) < 12 for shade in shades()))  # also of a topic with a single image
    publisher.publish(image(200, 50, 60))
    until(lambda: any(abs(shade - 200) < 12 for shade in shades()))
    response.close()
    client.close()
    until(lambda: publisher.publish(image(0)) or not publisher.num_connections)
    for _ in range(server_module.MAX_VIDEOS):  # the encoder has been closed
        assert server.video_slots.acquire(timeout=PATIENCE)


def test_the_rate_of_a_video(
    serve: Any, connect: Any, make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("av", reason="the extra `video` brings it")
    encoded: list[float] = []

    encode = Video.encode

    def count(video: Video, pixels: Any, now: float) -> bytes:
        encoded.append(now)
        return encode(video, pixels, now)

    monkeypatch.setattr(Video, "encode", count)
    server = serve()
    publisher = make_node("camera").advertise("/image", Image, queue_size=1)
    connect(server, b"GET /stream?topic=/image&type=h264&framerate=20 HTTP/1.0\r\n\r\n")
    until(lambda: publisher.publish(image(0)) or len(encoded) >= 8)
    # Two may follow each other at once, so that images that come irregularly are not lost.
    assert min(last - first for first, last in zip(encoded, encoded[2:], strict=False)) > 0.049


def test_videos_are_limited(serve: Any, connect: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("av", reason="the extra `video` brings it")
    monkeypatch.setattr(server_module, "MAX_VIDEOS", 0)
    server = serve()
    response = get(connect(server, b"GET /stream?topic=/image&type=vp9 HTTP/1.0\r\n\r\n"))
    assert response.status == 503 and b"too many videos" in response.read()
    assert get(connect(server, b"GET /stream?topic=/image HTTP/1.0\r\n\r\n")).status == 200


def test_a_video_of_a_damaged_image(serve: Any, connect: Any, make_node: Callable[..., Node]) -> None:
    pytest.importorskip("av", reason="the extra `video` brings it")
    make_node("camera").advertise("/image", Image, latch=True).publish(Image(None, 9, 9, "mono8", 0, 9, b""))
    response = get(connect(serve(), b"GET /stream?topic=/image&type=h264 HTTP/1.0\r\n\r\n"))
    assert response.status == 503 and b"too few for 9x9" in response.read()


def test_videos_without_pyav(
    serve: Any, connect: Any, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    server = serve("_default_stream_type:=vp8")
    output = capfd.readouterr()
    assert "pip install 'pyros1[video]', or use type=mjpeg" in output.out + output.err
    for page in ("stream", "stream_viewer"):
        response = get(connect(server, f"GET /{page}?topic=/image&type=h264 HTTP/1.0\r\n\r\n".encode()))
        assert response.status == 501
        (line,) = response.read().decode().splitlines()
        assert "type h264 need PyAV" in line and "pip install 'pyros1[video]'" in line
    viewer = get(connect(server, b"GET /stream_viewer?topic=/image HTTP/1.0\r\n\r\n")).read()
    assert b"<img" in viewer and b"<video" not in viewer


def test_viewers_show_videos(serve: Any, connect: Any) -> None:
    pytest.importorskip("av", reason="the extra `video` brings it")
    response = get(connect(serve(), b"GET /stream_viewer?topic=/image&type=vp8 HTTP/1.0\r\n\r\n"))
    assert "media-src 'self'" in str(response.getheader("Content-Security-Policy"))
    assert b'src="/stream?topic=/image&amp;type=vp8"></video>' in response.read()


def test_requests_that_trickle_free_their_connections(
    serve: Any, connect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(handler_module, "REQUEST_TIMEOUT", 0.5)
    monkeypatch.setattr(server_module, "MAX_CONNECTIONS", 3)
    server = serve()
    slow = [connect(server, b"GET / HTTP/1.0\r\nA: ") for _ in range(3)]
    begin = monotonic()
    while slow:  # a byte each time, so that no client is silent for long
        for client in list(slow):
            try:
                client.sendall(b"x")
            except OSError:
                slow.remove(client)
        sleep(0.02)
        assert monotonic() - begin < PATIENCE
    assert get(connect(server, b"GET / HTTP/1.0\r\n\r\n")).status == 200


@pytest.mark.slow
@pytest.mark.parametrize("stream_type", ["mjpeg", "h264"])
def test_clients_that_do_not_read_are_disconnected(
    serve: Any, connect: Any, make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch, stream_type: str
) -> None:
    pytest.importorskip("av", reason="the extra `video` brings it")
    monkeypatch.setattr(handler_module, "SEND_TIMEOUT", 0.2)
    server = serve()
    publisher = make_node("camera").advertise("/image", Image, queue_size=1)
    url = f"/stream?topic=/image&type={stream_type}&qmin=1&qmax=2"
    connect(server, f"GET {url} HTTP/1.0\r\n\r\n".encode())
    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    noise = image(0, 800, 600)
    noise.data = np.random.default_rng(1).integers(0, 256, 800 * 600, np.uint8).tobytes()
    until(lambda: publisher.publish(noise) or not publisher.num_connections)
