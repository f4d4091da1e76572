"""Peers that stop in the middle: of a header, a message, a request or an answer. They hold up nobody else."""

from __future__ import annotations

import contextlib
import socket
import struct
import xmlrpc.client
from collections.abc import Iterator
from typing import Any

import raw
from harness import Master, Peer
from site_of_two import TEXT, WAIT

MASTERS = ("ours",)
OWN_MASTER = True  # its peers stay registered
MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"
BOOL = "std_srvs/SetBool"
BOOL_MD5 = "09fb03525b03e7ea1fd3992bafd87e16"


class Named:
    """The master, for a peer with a name of its own."""

    def __init__(self, master: Master, name: str) -> None:
        self._uri, self._name = master.uri, name

    def call(self, method: str, *arguments: Any) -> Any:
        with xmlrpc.client.ServerProxy(self._uri) as proxy:
            return getattr(proxy, method)(self._name, *arguments)


@contextlib.contextmanager
def silent_node(master: Master, topic: str) -> Iterator[socket.socket]:
    """A publisher that is registered, and listens."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(WAIT)
        uri = f"http://localhost:{listener.getsockname()[1]}/"
        Named(master, "/silent").call("registerPublisher", topic, TEXT, uri)
        yield listener


def half(data: bytes) -> bytes:
    return data[: len(data) // 2]


def greeting(topic: str) -> bytes:
    fields = {"callerid": "/half", "topic": topic, "md5sum": MD5, "type": TEXT, "message_definition": "string data\n"}
    return raw.encode_header(fields)


def check_all(ours: Peer, stock: Peer, topics: list[str]) -> None:
    """Whatever our node does works beside *stock*."""
    for topic in topics:
        assert stock.publish(topic) == ours.received(topic, timeout=WAIT)
    name = ours.name
    assert ours.publish(f"{name}/out") == stock.received(f"{name}/out", timeout=WAIT)
    stock.tell("call", f"{name}/service", BOOL, 1, 0)
    stock.event("answer", f"{name}/service", timeout=WAIT)
    stock.ask("setparam", f"{name}/p", "int", event=f"set {name}/p", timeout=WAIT)
    assert ours.ask("getparam", f"{name}/p", timeout=WAIT) == "42"


def test_peers_that_stop_in_the_middle(master: Master, ours_kind: str) -> None:
    """Publishers, subscribers, clients and callers of the master: all have begun something and do not go on."""
    ours, stock = master.ready_peer(ours_kind, "ours"), master.ready_peer("roscpp", "stock")
    node = ours.name
    topics = ["/mid_header", "/mid_frame", "/mid_answer"]
    with contextlib.ExitStack() as stack:
        header = stack.enter_context(raw.fake_publisher(Named(master, "/h"), "/mid_header", TEXT))  # type: ignore[arg-type]
        frame = stack.enter_context(raw.fake_publisher(Named(master, "/f"), "/mid_frame", TEXT))  # type: ignore[arg-type]
        answer = stack.enter_context(silent_node(master, "/mid_answer"))
        for topic in topics:
            ours.subscribe(topic, TEXT)
            stock.advertise(topic, TEXT)
        in_header, in_frame = (stack.enter_context(fake.accept()) for fake in (header, frame))
        in_header.sendall(half(greeting("/mid_header")))
        text = b"whole after all"
        body = struct.pack("<I", len(text)) + text
        message = struct.pack("<I", len(body)) + body
        raw.read_header(in_frame)
        in_frame.sendall(greeting("/mid_frame") + half(message))
        in_answer = stack.enter_context(answer.accept()[0])
        in_answer.recv(65536)
        in_answer.sendall(b"HTTP/1.1 200 OK\r\nContent-Type: text/xml\r\nContent-Length: 500\r\n\r\n<methodResponse>")
        ours.advertise(f"{node}/out", TEXT)
        ours.serve(f"{node}/service", BOOL)
        stock.subscribe(f"{node}/out", TEXT)
        for topic, peer in [(topic, stock) for topic in topics] + [(f"{node}/out", ours)]:
            peer.linked(topic, 1)
        call = raw.encode_header(
            {"callerid": "/c", "service": f"{node}/service", "md5sum": BOOL_MD5, "persistent": "1"}
        )
        post = b"POST / HTTP/1.1\r\nContent-Type: text/xml\r\nContent-Length: 500\r\n\r\n<methodCall><methodName>getPa"
        api = master.call("lookupNode", node)[2].removesuffix("/").rpartition(":")[2]
        for place, data in (
            (raw.publisher_address(master, node, f"{node}/out"), half(greeting(f"{node}/out"))),
            (raw.publisher_address(master, node, f"{node}/out"), greeting(f"{node}/out")),  # and never reads
            (raw.service_address(master, f"{node}/service"), call + struct.pack("<I", 1)),
            (("localhost", int(api)), post),
            (("localhost", master.port), post),
        ):
            stack.enter_context(raw.connect(*place)).sendall(data)
        check_all(ours, stock, topics)
        in_frame.sendall(message[len(half(message)) :])
        assert ours.received("/mid_frame", timeout=WAIT) == body.hex()
        # Those that have begun to greet or to answer are given up after 10 s, and asked again.
        again = [header.listener, answer]
        for listener in again:
            listener.settimeout(WAIT)
            stack.enter_context(listener.accept()[0])
        check_all(ours, stock, topics)
        in_answer.setblocking(False)
        assert in_answer.recv(1) == b"", "the old connection is closed"
