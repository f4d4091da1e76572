"""web_video_server and its clients."""

from __future__ import annotations

import http.client
import os
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from io import BytesIO
from time import monotonic, sleep
from typing import Any

import pytest
from PIL import Image as PillowImage

from pyros1.ground.timing import Time
from pyros1.msgs.sensor_msgs.msg import CameraInfo, CompressedImage, Image
from pyros1.node import Node
from pyros1.topic_tools.image_encoding import compress
from pyros1.web.web_video_server import handler as handler_module
from pyros1.web.web_video_server import server as server_module
from pyros1.web.web_video_server.node import ListenError, main, start
from pyros1.web.web_video_server.requests import parse_request
from pyros1.web.web_video_server.server import VideoServer

PATIENCE = 20.0


def image(value: int, stamp: float = 1.5) -> Any:
    message = Image(None, 2, 3, "mono8", 0, 3, bytes([value] * 6))
    message.header.stamp = Time.from_sec(stamp)
    return message


@pytest.fixture
def serve(make_node: Callable[..., Node]) -> Callable[..., VideoServer]:
    """Return a function that serves images, with parameters such as ``_publish_rate:=5``."""

    def begin(*params: str) -> VideoServer:
        return start(make_node("web_video_server", argv=["_port:=0", "_address:=127.0.0.1", *params]))

    return begin


@pytest.fixture
def get() -> Iterator[Callable[..., http.client.HTTPResponse]]:
    """Return a function that requests a path of a server."""
    opened: list[Any] = []

    def request(server: VideoServer, path: str) -> http.client.HTTPResponse:
        connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
        opened.append(connection)
        connection.request("GET", path)
        response = connection.getresponse()
        opened.append(response)
        return response

    yield request
    for each in opened:
        each.close()


def read_part(response: http.client.HTTPResponse) -> tuple[dict[str, str], bytes]:
    """Return the headers and data of the next image of a stream."""
    assert response.readline() == b"--boundarydonotcross\r\n"
    headers: dict[str, str] = {}
    while (line := response.readline().strip()) != b"":
        name, _, value = line.decode().partition(": ")
        headers[name.lower()] = value
    data = response.read(int(headers["content-length"]))
    assert response.readline() == b"\r\n"
    return headers, data


def shade(data: bytes) -> int:
    with PillowImage.open(BytesIO(data)) as picture:
        value = picture.getpixel((0, 0))
    assert isinstance(value, int)
    return value


def until(condition: Callable[[], object]) -> None:
    deadline = monotonic() + PATIENCE
    while not condition():
        assert monotonic() < deadline
        sleep(0.005)


def test_a_stream(serve: Any, get: Any, make_node: Callable[..., Node]) -> None:
    """Feature: web_video_server: streams (MJPEG, PNG), snapshots and pages of image topics"""
    server = serve()
    publisher = make_node("camera").advertise("/image", Image, queue_size=1)
    response = get(server, "/stream?topic=/image")
    assert response.getheader("Content-type") == "multipart/x-mixed-replace;boundary=boundarydonotcross"
    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    for value in (10, 200):
        publisher.publish(image(value))
        headers, data = read_part(response)
        assert (headers["content-type"], headers["x-timestamp"]) == ("image/jpeg", "1.500000")
        assert shade(data) == value
    other = get(server, "/stream?topic=image&type=png&invert&width=9")
    headers, data = read_part(other)  # the newest image, at once
    assert headers["content-type"] == "image/png" and shade(data) == 200
    assert publisher.num_connections == 1  # both streams share a subscription
    response.close()
    other.close()
    until(lambda: publisher.publish(image(0)) or not publisher.num_connections)


def test_a_snapshot(serve: Any, get: Any, make_node: Callable[..., Node]) -> None:
    make_node("camera").advertise("/image", Image, latch=True).publish(image(77, 2.25))
    response = get(serve(), "/snapshot?topic=/image")
    assert (response.status, response.getheader("Content-type")) == (200, "image/jpeg")
    assert response.getheader("X-Timestamp") == "2.250000"
    assert response.getheader("Access-Control-Allow-Origin") == "*"
    assert shade(response.read()) == 77


def test_no_image_for_a_snapshot(serve: Any, get: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(handler_module, "SNAPSHOT_TIMEOUT", 0.01)
    response = get(serve(), "/snapshot?topic=/nothing")
    assert response.status == 504 and b"no image has arrived on /nothing within 0.01 s" in response.read()


def test_a_compressed_topic_that_is_missing(
    serve: Any, make_node: Callable[..., Node], capfd: pytest.CaptureFixture[str]
) -> None:
    server = serve()
    make_node("camera").advertise("/image", Image)
    for path in ("/stream?topic=/image", "/stream?topic=/none&default_transport=compressed"):
        server.select_source(parse_request(path))
    assert "/compressed" not in capfd.readouterr().err
    request = parse_request("/stream?topic=/image&default_transport=compressed")
    assert server.select_source(request) == ("/image/compressed", True, "mjpeg")
    assert "waiting for /image/compressed, which nobody publishes" in capfd.readouterr().err


def test_compressed_topics(serve: Any, get: Any, make_node: Callable[..., Node]) -> None:
    server = serve()
    message = compress(image(50), "png")
    make_node("camera").advertise("/image/compressed", CompressedImage, latch=True).publish(message)
    headers, data = read_part(get(server, "/stream?topic=/image&type=ros_compressed"))
    assert headers["content-type"] == "image/png" and data == bytes(message.data)  # as it is
    assert shade(get(server, "/snapshot?topic=/image").read()) == 50  # there are no raw images
    assert shade(get(server, "/snapshot?topic=/image&default_transport=compressed").read()) == 50
    assert shade(get(server, "/snapshot?topic=/image/compressed").read()) == 50


def test_without_compressed_images_raw_ones_are_streamed(serve: Any, get: Any, make_node: Callable[..., Node]) -> None:
    make_node("camera").advertise("/image", Image, latch=True).publish(image(60))
    headers, data = read_part(get(serve("_default_stream_type:=ros_compressed"), "/stream?topic=/image"))
    assert headers["content-type"] == "image/jpeg" and shade(data) == 60


def test_images_are_sent_again(serve: Any, get: Any, make_node: Callable[..., Node]) -> None:
    make_node("camera").advertise("/image", Image, latch=True).publish(image(60))
    response = get(serve("_publish_rate:=100"), "/stream?topic=/image")
    assert [shade(read_part(response)[1]) for _ in range(3)] == [60, 60, 60]


def test_pages(serve: Any, get: Any, make_node: Callable[..., Node]) -> None:
    server = serve()
    camera = make_node("camera")
    camera.advertise("/left/image_raw", Image)
    camera.advertise("/left/camera_info", CameraInfo)
    page = get(server, "/").read().decode()
    assert '<a href="/stream_viewer?topic=/left/image_raw">image_raw</a>' in page
    response = get(server, "/stream_viewer?topic=/left/image_raw&width=100")
    assert 'src="/stream?topic=/left/image_raw&amp;width=100"' in response.read().decode()
    assert "default-src 'none'" in response.getheader("Content-Security-Policy")


@pytest.mark.parametrize(
    ("path", "status", "text"),
    [
        ("/stream?topic=/a%20b", 400, b"/a b"),
        ("/stream?topic=/a&type=gif", 404, b"must be one of mjpeg"),
        ("/favicon.ico", 404, b"no such page"),
    ],
)
def test_what_is_refused(serve: Any, get: Any, path: str, status: int, text: bytes) -> None:
    response = get(serve(), path)
    assert response.status == status
    lines = response.read().splitlines()
    assert len(lines) == 1 and text in lines[0]


def test_a_damaged_image_ends_a_stream(serve: Any, get: Any, make_node: Callable[..., Node]) -> None:
    make_node("camera").advertise("/image", Image, latch=True).publish(Image(None, 9, 9, "mono8", 0, 9, b""))
    server = serve()
    assert get(server, "/stream?topic=/image").read() == b"--boundarydonotcross\r\n"
    assert get(server, "/snapshot?topic=/image").status == 503


def test_nonsense_is_refused(serve: Any, get: Any) -> None:
    server = serve()
    for text in (b"\0\xff\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"POST / HTTP/1.0\r\n\r\n", b""):
        with closing(socket.create_connection(("127.0.0.1", server.port), PATIENCE)) as client:
            client.sendall(text)
            client.shutdown(socket.SHUT_WR)
            while client.recv(1000):
                pass
    assert get(server, "/").status == 200


def test_connections_are_limited(serve: Any, get: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server_module, "MAX_CONNECTIONS", 1)
    server = serve()
    stream = get(server, "/stream?topic=/image")
    with pytest.raises((ConnectionError, http.client.HTTPException)):
        get(server, "/")
    stream.close()


def test_idle_connections_end_with_the_server(serve: Any, get: Any) -> None:
    server = serve()
    with closing(socket.create_connection(("127.0.0.1", server.port), PATIENCE)) as client:
        client.sendall(b"GET / HTTP/1.0\r\n")  # the rest does not come
        assert get(server, "/").status == 200  # so the other connection has been accepted as well
        client.settimeout(5.0)  # less than the server waits for it
        thread = threading.Thread(target=server.node.shutdown)
        thread.start()
        with suppress(ConnectionResetError):  # if the server has not read everything
            assert client.recv(1000) == b""
        thread.join(PATIENCE)


def test_a_port_in_use(make_node: Callable[..., Node]) -> None:
    with closing(socket.socket()) as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        node = make_node("server", argv=[f"_port:={other.getsockname()[1]}", "_address:=127.0.0.1"])
        with pytest.raises(ListenError, match="Address already in use; the parameters ~address and ~port say"):
            start(node)


def test_the_program_ends_with_its_streams(
    environ: dict[str, str], make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch, free_port: int
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    publisher = make_node("camera").advertise("/image", Image)
    received: list[bytes] = []

    def watch() -> None:
        try:
            until(lambda: can_connect(free_port))
            connection = http.client.HTTPConnection("127.0.0.1", free_port, timeout=PATIENCE)
            connection.request("GET", "/stream?topic=/image")
            response = connection.getresponse()
            publisher.wait_for_subscribers(timeout=PATIENCE)
            os.kill(os.getpid(), signal.SIGINT)
            received.append(response.read())
            connection.close()
        finally:
            if not received:
                os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=watch)
    thread.start()
    assert main(["web_video_server", f"_port:={free_port}", "_verbose:=false", "_default_stream_type:=gif"]) == 0
    thread.join(PATIENCE)
    assert received == [b"--boundarydonotcross\r\n"]


def can_connect(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), 1.0).close()
    except OSError:
        return False
    return True


@pytest.mark.slow
def test_a_client_that_sends_more_than_its_request_is_noticed_when_it_goes(
    serve: Callable[..., VideoServer], make_node: Callable[..., Node]
) -> None:
    publisher, server = make_node("camera").advertise("/image", Image), serve()
    with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as client:
        client.sendall(b"GET /stream?topic=/image HTTP/1.0\r\n\r\n")
        assert publisher.wait_for_subscribers(timeout=PATIENCE)
        client.recv(10_000)
        client.sendall(b"more")
    until(lambda: not publisher.num_connections)
