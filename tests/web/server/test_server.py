"""The server's port, as pages and as attackers use it.

Feature: a slow page gets fewer, but fresh messages
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from serving import PATIENCE, Served
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from pyros1.msgs.std_msgs.msg import Float64
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.web import calls
from pyros1.web.server.pending_connections import MAX_PENDING
from pyros1.web.server.server import WebServer
from pyros1.web.server.wire import RequestError
from pyros1.web.service_calls import MAX_CONCURRENT_CALLS


def get(server: Served, path: str, host: str = "localhost", **headers: str) -> tuple[int, dict[str, str], bytes]:
    """Return status, headers and body of a plain request."""
    lines = [
        f"GET {path} HTTP/1.1",
        f"Host: {host}",
        *(f"{name.replace('_', '-')}: {value}" for name, value in headers.items()),
    ]
    return ask(server, "\r\n".join(lines).encode() + b"\r\n\r\n")


def ask(server: Served, request: bytes) -> tuple[int, dict[str, str], bytes]:
    with closing(socket.create_connection(("127.0.0.1", server.port), PATIENCE)) as sock:
        sock.sendall(request)
        answer = b""
        while part := sock.recv(65536):
            answer += part
    head, _, body = answer.partition(b"\r\n\r\n")
    first, *rest = head.decode().split("\r\n")
    return int(first.split()[1]), {k.lower(): v for k, _, v in (line.partition(": ") for line in rest)}, body


def page(server: Served, token: str, **options: Any) -> Any:
    return connect(f"ws://localhost:{server.port}/ws?token={token}", open_timeout=PATIENCE, **options)


def until(socket_: ClientConnection, fits: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """Return the first text frame that fits; each push is answered."""
    while True:
        frame = socket_.recv(timeout=PATIENCE)
        if isinstance(frame, bytes):
            frame = frame[4 : 4 + int.from_bytes(frame[:4], "little")].decode()
        message: dict[str, Any] = json.loads(frame)
        if "data" in message:
            socket_.send(json.dumps({"next": message["stream"]}))
        if fits(message):
            return message


def test_as_many_pages_as_the_server_admits(serve: Callable[..., Served]) -> None:
    server = serve(token="t", max_pages=2)
    with page(server, "t"):
        with connect(f"ws://localhost:{server.port}/?token=t", open_timeout=PATIENCE):  # a program of rosbridge
            with pytest.raises(InvalidStatus, match="503") as refusal:
                page(server, "t")
            assert b"At most 2 pages" in refusal.value.response.body
        until_gone = 0
        while True:  # the server may hear of the end a moment later
            with contextlib.suppress(InvalidStatus), page(server, "t"):
                break
            until_gone += 1
            assert until_gone < 10_000


def test_files_of_the_page(serve: Callable[..., Served]) -> None:
    server = serve(token="t")
    status, headers, body = get(server, "/")
    assert (status, headers["content-type"]) == (200, "text/html; charset=utf-8")
    assert b"main.js" in body
    assert "default-src 'self'" in headers["content-security-policy"]
    assert headers["x-content-type-options"] == "nosniff"
    status, headers, _ = get(server, "/main.js?x=1")
    assert (status, headers["content-type"]) == (200, "text/javascript; charset=utf-8")
    assert get(server, "/main.js", If_None_Match=headers["etag"])[0] == 304
    panels = json.loads(get(server, "/panels.json")[2])
    assert {"console", "plot"} <= {*panels}


def test_files_of_packages_need_the_token(serve: Callable[..., Served], tmp_path: Path, monkeypatch: Any) -> None:
    folder = tmp_path / "src" / "arm"
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>arm</name></package>")
    (folder / "a.stl").write_bytes(b"solid")
    (folder / "a.html").write_bytes(b"<script>")
    (folder / "a.png").write_bytes(b"\x89PNG")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    server = serve(token="t")

    def file(uri: str, token: str = "t") -> tuple[int, dict[str, str], bytes]:
        return get(server, f"/package_file?token={token}&uri={quote(uri, safe='')}")

    status, headers, body = file("package://arm/a.stl")
    assert (status, headers["content-type"], body) == (200, "application/octet-stream", b"solid")
    assert headers["x-content-type-options"] == "nosniff"
    assert file("package://arm/a.png")[1]["content-type"] == "image/png"
    assert file(f"file://{folder}/a.stl")[2] == b"solid"
    assert file("package://arm/a.stl", "wrong")[0] == 401
    for uri in ("package://arm/a.html", "package://arm/package.xml", "package://arm", "", "file:///etc/passwd"):
        assert file(uri)[0] == 403
    for uri in ("package://arm/none.stl", "package://arm/../../x.stl", "package://none/a.stl", "file:///etc/x.stl"):
        status, headers, body = file(uri)
        assert (status, headers["content-type"]) == (404, "text/plain; charset=utf-8")
        assert body
    assert get(server, "/package_file?token=t&uri=%ff%00.stl")[0] == 404
    assert get(server, "/package_file?" + "a&" * 50)[0] == 401


@pytest.mark.parametrize(
    "path",
    [
        "/nothing",
        "/../server.py",
        "/..%2fserver.py",
        "//etc/passwd",
        "/page/index.html",
        "/lib/../../server.py",
        "/lib",
        "/%00",
    ],
)
def test_nothing_else_is_given_out(serve: Callable[..., Served], path: str) -> None:
    assert get(serve(token="t"), path)[0] == 404


def test_a_page_of_another_name_or_site_is_refused(serve: Callable[..., Served]) -> None:
    server = serve(token="t")
    assert get(server, "/", host="evil.example")[0] == 403  # DNS rebinding
    with pytest.raises(InvalidStatus, match="403"):
        page(server, "t", additional_headers={"Origin": "http://evil.example"})
    with pytest.raises(InvalidStatus, match="401"):
        page(server, "wrong")
    with page(server, "t", additional_headers={"Origin": f"http://localhost:{server.port}"}) as socket_:
        socket_.send('{"call": "page.about", "id": 1}')
        assert until(socket_, lambda message: message.get("id") == 1)["result"]["version"]


UPGRADE = (
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: " + "A" * 22 + "=="
)


@pytest.mark.parametrize(
    "head",
    [
        f"GET /ws?token=t HTTP/1.1\r\nHost: localhost\r\nOrigin: http://[\r\n{UPGRADE}",
        f"GET /ws?token=t HTTP/1.1\r\nHost: localhost\r\nOrigin: http://localhost\r\nOrigin: http://evil\r\n{UPGRADE}",
        f"GET //[?token=t HTTP/1.1\r\nHost: localhost\r\n{UPGRADE}",
        "GET http://[ HTTP/1.1\r\nHost: localhost",
        "GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost",
    ],
)
def test_malformed_requests_are_answered(serve: Callable[..., Served], head: str) -> None:
    assert ask(serve(token="t"), f"{head}\r\n\r\n".encode())[0] == 400


@pytest.mark.parametrize(
    "request_",
    [
        b"",
        b"\r\n\r\n",
        b"GET\r\n\r\n",
        b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 999999999999\r\n\r\n",
        b"GET / HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n",
        b"GET /" + b"a" * 100_000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(range(256)),
    ],
)
def test_garbage_ends_its_connection_only(serve: Callable[..., Served], request_: bytes) -> None:
    server = serve(token="t")
    with closing(socket.create_connection(("127.0.0.1", server.port), PATIENCE)) as sock:
        sock.sendall(request_)
        sock.shutdown(socket.SHUT_WR)
        sock.settimeout(PATIENCE)
        try:
            while sock.recv(65536):
                pass
        except ConnectionResetError:
            pass
    assert get(server, "/")[0] == 200


@pytest.mark.parametrize("frame", ["", "{}", b"\x00", "[" * 1000, '{"open": 1}', "x" * 2_000_000])
def test_a_page_that_sends_nonsense_is_told_to_go(serve: Callable[..., Served], frame: str | bytes) -> None:
    server = serve(token="t")
    with page(server, "t") as socket_:
        socket_.send(frame)
        with pytest.raises(ConnectionClosed):
            socket_.recv(timeout=PATIENCE)
    assert get(server, "/")[0] == 200


def test_a_stream_of_a_topic(serve: Callable[..., Served], make_node: Callable[..., Any]) -> None:
    server = serve(token="t")
    publisher = make_node("talker").advertise("topic1", Float64, latch=True)
    publisher.publish(2.5)
    with page(server, "t") as socket_:
        socket_.send('{"open": "message", "stream": 4, "args": {"topic": "/topic1"}}')
        data = until(socket_, lambda message: "data" in message)["data"]
        assert (data["type"], data["publisher"], data["size"]) == ("std_msgs/Float64", "/talker", 8)
        assert data["value"] == {"fields": [["data", "float64", 2.5]]}
        publisher.publish(3.5)
        again = until(socket_, lambda message: "data" in message)
        assert again["data"]["value"]["fields"][0][2] == 3.5


def test_a_page_that_does_not_take_its_pushes_gets_one_and_then_the_newest(
    serve: Callable[..., Served], make_node: Callable[..., Any]
) -> None:
    server = serve(token="t")
    publisher = make_node("talker").advertise("topic1", Float64, queue_size=0)
    with page(server, "t") as socket_:
        socket_.send('{"open": "message", "stream": 4, "args": {"topic": "/topic1"}}')
        assert publisher.wait_for_subscribers(timeout=PATIENCE)
        publisher.publish(0.0)
        assert json.loads(socket_.recv(timeout=PATIENCE))["data"]["count"] == 1
        with page(server, "t") as other:  # it sees when all have come
            other.send('{"open": "message", "stream": 1, "args": {"topic": "/topic1"}}')
            count = 1
            while True:
                publisher.publish(0.5)
                count += 1
                try:
                    other.recv(timeout=0.1)
                    break
                except TimeoutError:
                    assert count < 200
            other.send('{"next": 1}')
            for number in range(1, 1001):
                publisher.publish(float(number))
            until(other, lambda message: "data" in message and message["data"]["value"]["fields"][0][2] == 1000.0)
        socket_.send('{"next": 4}')
        data = json.loads(socket_.recv(timeout=PATIENCE))["data"]
        assert (data["value"]["fields"][0][2], data["count"]) == (1000.0, count + 1000)


@pytest.mark.slow
def test_a_slow_view_does_not_hold_back_the_robot(
    make_robot: Callable[..., Any], make_node: Callable[..., Any]
) -> None:
    robot = make_robot()
    publisher = make_node("talker").advertise("topic1", Float64, queue_size=None)  # publish() waits for subscribers
    go_on = threading.Event()
    seen: list[float] = []

    def slow(arrival: Any) -> None:
        go_on.wait(PATIENCE)
        seen.append(arrival.message.data)

    end = robot.listen("/topic1", slow)
    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    published = threading.Event()

    def publish() -> None:
        for number in range(20_000):
            publisher.publish(float(number))
        published.set()

    threading.Thread(target=publish).start()
    assert published.wait(PATIENCE)
    go_on.set()
    publisher.publish(-1.0)
    end()


def test_read_only(serve: Callable[..., Served]) -> None:
    server = serve(token="t", read_only=True)
    with page(server, "t") as socket_:
        for number, (name, args) in enumerate(
            [
                ("topics.publish", {"topic": "/x", "type": "std_msgs/Float64", "value": {}}),
                ("services.call", {"service": "/x"}),
                ("params.put", {"name": "/x", "yaml": "1"}),
                ("params.delete", {"name": "/x"}),
                ("nodes.kill", {"node": "/x"}),
                ("nodes.set_level", {"node": "/x", "logger": "rosout", "level": "debug"}),
            ]
        ):
            socket_.send(json.dumps({"call": name, "id": number, "args": args}))
            answer = until(socket_, lambda message, number=number: message.get("id") == number)  # type: ignore[misc]
            assert "read-only" in answer["error"]


def test_only_some_topics(serve: Callable[..., Served], make_node: Callable[..., Any]) -> None:
    node = make_node("talker")
    for name in ("/camera/image", "/secret"):
        node.advertise(name, Float64, latch=True).publish(1.0)
    server = serve(token="t", topics=("/camera/*",))
    with page(server, "t") as socket_:
        socket_.send('{"open": "system", "stream": 1}')
        shown = until(socket_, lambda message: "/camera/image" in message.get("data", {}).get("topics", {}))
        assert [*shown["data"]["topics"]] == ["/camera/image"]
        socket_.send('{"open": "message", "stream": 2, "args": {"topic": "/secret"}}')
        assert "--topics" in until(socket_, lambda message: message.get("stream") == 2)["error"]
        socket_.send('{"open": "plot", "stream": 3, "args": {"curves": [{"id": 1, "text": "/secret/data"}]}}')
        problems = until(socket_, lambda message: message.get("stream") == 3)["data"]["problems"]
        assert "--topics" in problems["1"]
        args = {"topic": "/secret", "type": "std_msgs/Float64", "value": {}}
        socket_.send(json.dumps({"call": "topics.publish", "id": 4, "args": args}))
        assert "--topics" in until(socket_, lambda message: message.get("id") == 4)["error"]


def test_services_that_do_not_answer_starve_nobody(serve: Callable[..., Served], make_node: Callable[..., Any]) -> None:
    began, go_on = threading.Semaphore(0), threading.Event()

    def hang(request: Any) -> Any:
        began.release()
        go_on.wait(PATIENCE)
        return Empty._response_class()

    node = make_node("slow")
    node.advertise_service("hang", Empty, hang)
    server = serve(token="t")
    try:
        with page(server, "t") as one, page(server, "t") as two:
            call = {"call": "services.call", "args": {"service": "/hang", "value": {}, "timeout": 600}}
            for socket_ in (one, two):
                for number in range(MAX_CONCURRENT_CALLS):
                    socket_.send(json.dumps({**call, "id": number}))
            for _ in range(2 * MAX_CONCURRENT_CALLS):
                assert began.acquire(timeout=PATIENCE)
            one.send(json.dumps({**call, "id": 100}))
            assert "wait" in until(one, lambda message: message.get("id") == 100)["error"]
            for number, socket_ in enumerate((one, two)):
                socket_.send(json.dumps({"call": "page.about", "id": 200 + number}))
                assert "result" in until(socket_, lambda message, number=number: message.get("id") == 200 + number)  # type: ignore[misc]
        names = [thread.name for thread in threading.enumerate()]
        assert sum(name.startswith("web: services") for name in names) == 2 * MAX_CONCURRENT_CALLS
        with page(server, "t") as socket_:  # the calls of those that went have ended: their threads are free
            for number in range(MAX_CONCURRENT_CALLS):
                socket_.send(json.dumps({**call, "id": number}))
            for _ in range(MAX_CONCURRENT_CALLS):
                assert began.acquire(timeout=PATIENCE)
            go_on.set()
            for _ in range(MAX_CONCURRENT_CALLS):
                assert "result" in json.loads(socket_.recv(timeout=PATIENCE))
    finally:
        go_on.set()


def test_any_free_port_is_one_for_all_addresses_of_the_host(robot: Any) -> None:
    both = {each[4][0] for each in socket.getaddrinfo("localhost", None, type=socket.SOCK_STREAM)}

    async def ports() -> set[tuple[str, int]]:
        async with WebServer(robot, robot.access).listen("localhost", 0) as server:
            return {each.getsockname()[:2] for each in server.sockets}

    found = asyncio.run(ports())
    assert len({port for _, port in found}) == 1
    assert {address for address, _ in found} <= both and len(found) >= 1


def test_a_port_that_is_taken_is_told(robot: Any) -> None:
    async def listen(port: int) -> None:
        async with WebServer(robot, robot.access).listen("127.0.0.1", port):
            pass

    with closing(socket.create_server(("127.0.0.1", 0))) as taken, pytest.raises(OSError, match="in use"):
        asyncio.run(listen(taken.getsockname()[1]))


def test_forms_of_topics_that_pages_may_not_see(make_robot: Callable[..., Any], make_node: Callable[..., Any]) -> None:
    node = make_node("talker")
    node.advertise("/secret", Float64)
    node.advertise("/act/goal", Float64)
    robot = make_robot(topics=("/camera/*",))
    for name, args in (("topics.form", {"topic": "/secret"}), ("actions.form", {"action": "/act"})):
        with pytest.raises(RequestError, match="--topics"):
            calls.run(robot, name, args)


@pytest.mark.slow
def test_of_a_page_that_has_gone_not_all_is_done(serve: Callable[..., Served], monkeypatch: pytest.MonkeyPatch) -> None:
    server = serve(token="t")
    began, go_on = threading.Semaphore(0), threading.Event()
    done: list[str] = []

    def run(robot: Any, name: str, args: Any, service_calls: Any = None) -> None:
        began.release()
        go_on.wait(PATIENCE)
        done.append(name)

    monkeypatch.setattr(calls, "run", run)
    with page(server, "t") as socket_:
        for number in range(1000):
            socket_.send(json.dumps({"call": "page.about", "id": number}))
        assert began.acquire(timeout=PATIENCE)
    go_on.set()
    monkeypatch.undo()
    with page(server, "t") as socket_:  # the others did not delay this one
        socket_.send('{"call": "page.about", "id": 1}')
        until(socket_, lambda message: message.get("id") == 1)
    assert len(done) < 500


def test_calls_of_a_server_that_ends_are_refused(robot: Any) -> None:
    robot.close()
    with pytest.raises(RequestError, match="shutting down"):
        calls.run(robot, "page.about", {})


def test_connections_that_say_nothing_make_room(serve: Callable[..., Served]) -> None:
    server = serve(token="t")
    silent = [socket.create_connection(("127.0.0.1", server.port), PATIENCE) for _ in range(MAX_PENDING + 20)]
    try:
        silent[0].settimeout(PATIENCE)
        with contextlib.suppress(ConnectionResetError):
            assert silent[0].recv(1) == b""  # the oldest were closed
        with page(server, "t") as socket_:
            assert get(server, "/")[0] == 200
            silent += [socket.create_connection(("127.0.0.1", server.port), PATIENCE) for _ in range(MAX_PENDING + 20)]
            socket_.send('{"call": "page.about", "id": 1}')  # who has come in stays
            assert until(socket_, lambda message: message.get("id") == 1)["result"]
    finally:
        for each in silent:
            each.close()
