"""Another program takes the port of a killed node: whoever still knows that port says so, and finds the node again."""

from __future__ import annotations

import contextlib
import http.server
import signal
import socketserver
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from harness import Master, Peer, until

from pyros1.net.hosts import parse_uri
from pyros1.node import Node
from pyros1.wire.xmlrpc import dumps_response

MASTERS = ("ours",)
TEXT, FLIP = "std_msgs/String", "std_srvs/SetBool"


class Echo(socketserver.BaseRequestHandler):
    def handle(self) -> None:
        with contextlib.suppress(OSError):
            while data := self.request.recv(4096):
                self.request.sendall(data)


class Web(http.server.BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        self.send_error(404)

    def log_message(self, *_: Any) -> None:
        pass


class OtherNode(Web):
    """One that has other topics."""

    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["Content-Length"]))
        body = dumps_response([-1, "Not a publisher of that", []])
        self.send_response(200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)


@contextlib.contextmanager
def takes(port: int, handler: type) -> Iterator[None]:
    """Let another program answer on a port."""

    class Server(socketserver.ThreadingTCPServer):
        allow_reuse_address = True
        daemon_threads = True

    with Server(("127.0.0.1", port), handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.05,))
        thread.start()
        try:
            yield
        finally:
            server.shutdown()
            thread.join()


def kill(peer: Peer) -> None:
    peer.signal(signal.SIGKILL)
    peer.wait()


@pytest.mark.parametrize(
    ("taker", "words"),
    [(Web, "HTTP status 501.*another program"), (Echo, "another program"), (OtherNode, "it answers: Not a publisher")],
)
def test_the_port_of_a_publishers_api(launcher: Master, topic: str, taker: type, words: str) -> None:
    sink = launcher.ready_peer("pyros1", "mourner")
    sink.subscribe(topic, TEXT)
    source = launcher.ready_peer("roscpp", "mortal")
    source.advertise(topic, TEXT)
    source.linked(topic)
    place = launcher.call("lookupNode", "/mortal")[2]
    kill(source)
    with takes(parse_uri(place)[1], taker):
        line = sink.wait_line(f"no messages of {topic} from the publisher at {place}.*{words}", 20)
        assert "Traceback" not in line.string
        source = launcher.ready_peer("roscpp", "mortal")
        source.advertise(topic, TEXT)
        source.linked(topic)
        assert source.publish(topic) == sink.received(topic)


@pytest.mark.parametrize(
    ("taker", "words"),
    [(Echo, "only sends back what it receives: another program is using its port")],
)
def test_the_port_of_a_service(launcher: Master, topic: str, taker: type, words: str) -> None:
    client = launcher.ready_peer("pyros1", "customer")
    server = launcher.ready_peer("pyros1", "shop")
    server.serve(topic, FLIP)
    place = launcher.call("lookupService", topic)[2]
    client.call(topic, FLIP)
    kill(server)
    with takes(parse_uri(place, "rosrpc")[1], taker):
        assert words in client.call_failing(topic, FLIP)
        server = launcher.ready_peer("pyros1", "shop")
        server.serve(topic, FLIP)
        client.available(topic)
        client.call(topic, FLIP)


def test_the_port_of_a_service_at_a_server_that_waits(launcher: Master, topic: str) -> None:
    client, server = launcher.ready_peer("pyros1", "customer"), launcher.ready_peer("pyros1", "shop")
    server.serve(topic, FLIP)
    port = parse_uri(launcher.call("lookupService", topic)[2], "rosrpc")[1]
    kill(server)
    with takes(port, Web):
        client.tell("call", topic, FLIP, 1, 0)
        client.wait_line("which does not answer. Is its node stopped, or is another program using its port", 30)


def test_the_port_of_a_service_at_a_node_with_other_services(launcher: Master, topic: str) -> None:
    client = launcher.ready_peer("pyros1", "customer")
    server = launcher.ready_peer("pyros1", "shop")
    server.serve(topic, FLIP)
    port = parse_uri(launcher.call("lookupService", topic)[2], "rosrpc")[1]
    kill(server)
    with guest_at(launcher, (0, port)):
        assert f"is not a provider of [{topic}]" in client.call_failing(topic, FLIP)


@contextlib.contextmanager
def guest_at(launcher: Master, ports: tuple[int, int]) -> Iterator[Node]:
    with Node("guest", argv=[], environ=launcher.environ(), ports=ports, handle_signals=False) as node:
        yield node


def test_whoever_has_a_dead_nodes_port_is_not_ended(own_master: Callable[[str], Master], topic: str) -> None:
    """Stock's master tells the old node of a name to end when there is a new one: at the port where the old one was."""
    launcher = own_master("stock")
    launcher.start()
    mortal = launcher.ready_peer("roscpp", "mortal")
    mortal.advertise(topic, TEXT)
    port = parse_uri(launcher.call("lookupNode", "/mortal")[2])[1]
    kill(mortal)
    ended = threading.Event()
    with guest_at(launcher, (port, 0)) as guest:
        guest.on_shutdown(ended.set)
        guest.advertise(f"{topic}/guest", TEXT)
        again = launcher.ready_peer("roscpp", "mortal")
        again.advertise(topic, TEXT)
        until(lambda: launcher.publishers(topic) == ["/mortal"], "the new node")
        calls = launcher.ready_peer("roscpp", "late")  # the master serves in order: what it told the port is told
        calls.subscribe(f"{topic}/guest", TEXT)
        calls.linked(f"{topic}/guest")
        assert not ended.is_set()
        assert launcher.publishers(f"{topic}/guest") == ["/guest"]
