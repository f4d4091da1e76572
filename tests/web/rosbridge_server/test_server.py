"""The node rosbridge_websocket, and clients on its port."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from queue import Queue
from time import monotonic, sleep
from typing import Any

import pytest
from serving import PATIENCE
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect

from pyros1.msgs.std_msgs.msg import Int32
from pyros1.msgs.std_srvs.srv import SetBool
from pyros1.node import Node
from pyros1.web.rosbridge_server.node import main, unsupported
from pyros1.web.rosbridge_server.server import BridgeServer, TlsError
from pyros1.web.rosbridge_server.settings import Settings


class Served:
    """A server in a thread."""

    def __init__(self, node: Node, **settings: Any) -> None:
        self.node = node
        self._server = BridgeServer(node, Settings(**{"port": 0, "address": "127.0.0.1", **settings}))
        self.thread = threading.Thread(target=self._server.run)
        self.thread.start()

    def port(self) -> int:
        deadline = monotonic() + PATIENCE
        while not (port := self.node.params.get("~actual_port", 0)) and monotonic() < deadline:
            sleep(0.01)
        return int(port)

    def connect(self, **options: Any) -> ClientConnection:
        return connect(f"ws://127.0.0.1:{self.port()}/any/path", open_timeout=PATIENCE, **options)


@pytest.fixture
def serve(make_node: Callable[..., Node]) -> Iterator[Callable[..., Served]]:
    """Return a function that serves clients with the arguments of `Settings`."""
    servers: list[Served] = []

    def start(**settings: Any) -> Served:
        servers.append(Served(make_node("rosbridge_websocket"), **settings))
        return servers[-1]

    yield start
    for server in servers:
        server.node.shutdown()
        server.thread.join(PATIENCE)


def ask(client: ClientConnection, op: str, **fields: Any) -> Any:
    client.send(json.dumps({"op": op, **fields}))
    return json.loads(client.recv(timeout=PATIENCE))


def test_clients_are_served_and_counted(serve: Callable[..., Served], make_node: Callable[..., Node]) -> None:
    """Feature: rosbridge_websocket of rosbridge_server, with its parameters and launch file"""
    counts: Queue[Any] = Queue()
    make_node("listener").subscribe("client_count", Int32, counts.put)
    server = serve()
    assert counts.get(timeout=PATIENCE).data == 0
    with server.connect() as client:
        assert counts.get(timeout=PATIENCE).data == 1
        answer = ask(client, "subscribe", topic="/connected_clients")
        assert answer["msg"]["clients"][0]["ip_address"] == "127.0.0.1"
        assert "/listener" in ask(client, "call_service", service="/rosapi/nodes")["values"]["nodes"]
    assert counts.get(timeout=PATIENCE).data == 0


def test_patterns_for_services_and_topics_differ(serve: Callable[..., Served], make_node: Callable[..., Node]) -> None:
    make_node("arm").advertise_service("/arm/enable", SetBool, lambda request: (True, ""))
    server = serve(topics=("/arm/*",), services=("/base/*",), parameters=("/rate",))
    server.node.params["/rate"] = 5
    server.node.params["/arm/secret"] = 1
    with server.connect() as client:
        answer = ask(client, "call_service", service="/arm/enable", args={"data": True})
        assert answer["result"] is False and "does not show /arm/enable" in answer["values"]
        assert ask(client, "call_service", service="/rosapi/services")["values"] == {"services": []}
        assert ask(client, "call_service", service="/rosapi/get_param_names")["values"] == {"names": ["/rate"]}
        assert "does not show /client_count" in ask(client, "subscribe", topic="/client_count")["msg"]


def test_what_clients_do_wrong_is_logged(serve: Callable[..., Served], capfd: pytest.CaptureFixture[str]) -> None:
    with serve().connect() as client:
        assert ask(client, "publish", topic="/unknown", msg={})["level"] == "error"
    text, deadline = "", monotonic() + PATIENCE
    while "a client's request failed: " not in text and monotonic() < deadline:
        text += capfd.readouterr().err
    assert "a client's request failed: the type of /unknown is unknown" in text


def test_pages_without_an_origin(serve: Callable[..., Served]) -> None:
    with serve().connect(origin="null") as client:
        assert ask(client, "call_service", service="/rosapi/get_time")["result"] is True


def test_pages_without_an_origin_are_refused(serve: Callable[..., Served]) -> None:
    server = serve(allows_null_origin=False)
    with server.connect(origin="http://robot.example"):
        pass
    with pytest.raises(InvalidStatus, match="403"):
        server.connect(origin="null")


def test_a_port_in_use_is_waited_for(serve: Callable[..., Served], capfd: pytest.CaptureFixture[str]) -> None:
    with closing(socket.socket()) as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        server = serve(port=port, retry_delay=0.01)
        text, deadline = "", monotonic() + PATIENCE
        while "Trying again in 0.01 s" not in text and monotonic() < deadline:
            text += capfd.readouterr().err
        assert f"cannot listen on 127.0.0.1:{port}: Address already in use" in text
    assert server.port() == port
    with server.connect():
        pass


def test_an_address_that_does_not_exist(serve: Callable[..., Served], capfd: pytest.CaptureFixture[str]) -> None:
    serve(address="no such host", retry_delay=3600.0)
    text, deadline = "", monotonic() + PATIENCE
    while "Trying again" not in text and monotonic() < deadline:
        text += capfd.readouterr().err
    assert "cannot listen on no such host:0: " in text and "Unknown error" not in text


def test_a_server_that_waits_for_its_port_can_be_ended(serve: Callable[..., Served]) -> None:
    with closing(socket.socket()) as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        server = serve(port=other.getsockname()[1], retry_delay=3600.0)
        server.node.shutdown()
        server.thread.join(PATIENCE)
        assert not server.thread.is_alive()


def test_files_for_tls_that_do_not_exist(make_node: Callable[..., Node]) -> None:
    server = BridgeServer(make_node("bridge"), Settings(0, "127.0.0.1", certificate="/none.pem", key="/none.key"))
    with pytest.raises(TlsError, match=r"cannot use /none.pem and /none.key for TLS: No such file"):
        server.run()


def test_a_parameter_that_is_not_supported_is_one_line(
    environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    assert main(["rosbridge_websocket", "_authenticate:=true"]) == 1
    lines = capfd.readouterr().err.splitlines()
    assert len(lines) == 1 and "authenticate is not supported" in lines[0]


def test_rosbridge_without_a_websocket(capfd: pytest.CaptureFixture[str]) -> None:
    assert unsupported(["/x/rosbridge_tcp.py"]) == 1
    assert "ERROR: rosbridge_tcp: only rosbridge over WebSockets" in capfd.readouterr().err


def test_an_interrupt_during_the_start_is_no_error(
    environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    advertise = Node.advertise

    def advertise_too_late(node: Node, *args: Any, **options: Any) -> Any:
        node.shutdown()
        return advertise(node, *args, **options)

    monkeypatch.setattr(Node, "advertise", advertise_too_late)
    assert main(["rosbridge_websocket", "_port:=0"]) == 0
    assert capfd.readouterr().err == ""
