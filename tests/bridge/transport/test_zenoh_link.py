"""The link over eclipse-zenoh, on loopback."""

from __future__ import annotations

import os
import queue
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any

import pytest

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.key_expressions import Channel, Key, topic_key
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.zenoh_link import CLOSE_TIME, LinkError, ZenohLink

from ..conftest import PATIENCE, wait_until

pytest.importorskip("zenoh")
ODOM = SharedName("red", "/odom")


class Station:
    """A link, and what comes over it."""

    def __init__(
        self,
        name: str,
        connect: tuple[str, ...] = (),
        listen: tuple[str, ...] = (),
        settings: Mapping[str, str] = {},
    ) -> None:
        self.packets: queue.Queue[tuple[Key, bytes, bytes]] = queue.Queue()
        self.link = ZenohLink(name, lambda *packet: self.packets.put(packet), connect, listen, settings)

    def get(self, body: bytes) -> Key:
        """Wait for a packet with this body, and return its key."""
        while True:
            key, _, got = self.packets.get(timeout=PATIENCE)
            if got == body:
                return key


@pytest.fixture
def make_station() -> Iterator[Callable[..., Station]]:
    """Return a function that makes stations; those that were made last are closed first."""
    stations: list[Station] = []

    def make(*args: Any) -> Station:
        stations.append(Station(*args))
        return stations[-1]

    yield make
    for station in reversed(stations):
        station.link.close()


def hello_until_heard(sender: Station, *receivers: Station) -> None:
    """Say hello until all have heard it: the network needs a moment at first."""

    def all_hear() -> bool:
        sender.link.send(Send("hello", b"h", b"hello"))
        return all(not receiver.packets.empty() for receiver in receivers)

    wait_until(all_hear, "hello is heard")


def send_until_heard(sender: Station, red: Station, body: bytes) -> None:
    """Send a packet until it comes: on a busy machine, it may be dropped where a large one is on its way."""

    def is_heard() -> bool:
        sender.link.send(Send("to/red", b"h", body))
        return body in [packet[2] for packet in [*red.packets.queue]]

    wait_until(is_heard, f"{body!r} is heard")


def test_sites_reach_each_other_through_one_that_listens(make_station: Any, endpoint: str) -> None:
    base = make_station("base", (), (endpoint,))
    red, blue = make_station("red", (endpoint,)), make_station("blue", (endpoint,))
    hello_until_heard(red, base, blue)
    hello_until_heard(blue, base, red)
    red.link.send(Send("to/blue", b"h", b"for blue"))
    assert blue.get(b"for blue") == Key("red", Channel.TO, "blue")
    blue.link.listen("red", topic_key(ODOM), True)
    blue.link.listen("red", topic_key(ODOM), True)

    def is_heard() -> bool:
        red.link.send(Send(topic_key(ODOM), b"head", b"message", may_drop=True))
        return not blue.packets.empty()

    wait_until(is_heard, "the message")
    assert blue.packets.get() == (Key("red", Channel.TOPIC, "", ODOM), b"head", b"message")
    red.link.send(Send("hello", b"h", b"the end"))
    base.get(b"the end")
    assert all(key.channel is Channel.HELLO for key, _, _ in [*base.packets.queue])


@pytest.mark.slow
def test_a_site_that_listens_may_start_later_and_again(make_station: Any, endpoint: str) -> None:
    red = make_station("red", (endpoint,))
    red.link.listen("base", "t/base/map", True)
    wait_until(lambda: red.link.problem, "the first attempt fails")
    red.link.send(Send("hello", b"h", b"lost"))
    for _ in range(2):
        base = Station("base", (), (endpoint,))
        try:
            hello_until_heard(red, base)
            red.link.send(Send("to/base", b"h", b"x"))
            assert base.get(b"x").site == "red"

            def is_heard(base: Station = base) -> bool:
                base.link.send(Send("t/base/map", b"h", b"map"))
                return not red.packets.empty()

            wait_until(is_heard, "the map")
            assert red.get(b"map").topic == SharedName("base", "/map")
        finally:
            base.link.close()
        while not red.packets.empty():
            red.packets.get()
    assert red.link.problem == ""


def test_a_site_that_dials_several(make_station: Any, free_ports: Any) -> None:
    first, second = (f"tcp/127.0.0.1:{port}" for port in free_ports(2))
    stations = make_station("base", (), (first,)), make_station("far", (), (second,))
    red = make_station("red", (first, second))
    hello_until_heard(red, *stations)


def test_who_may_forward_large_packets_sends_only_urgent_ones_at_once(make_station: Any, endpoint: str) -> None:
    """zenoh makes small ones wait for large ones of other sites that have the same priority."""
    packets = {priority: Send("hello", b"h", b"x", priority) for priority in Priority}

    def at_once(station: Station) -> set[Priority]:
        return {priority for priority, packet in packets.items() if station.link.try_send(packet)}

    def declare(station: Station) -> None:
        for packet in packets.values():
            station.link.send(packet)

    base, red = make_station("base", (), (endpoint,)), make_station("red", (endpoint,))
    assert at_once(base) == set()
    hello_until_heard(red, base)
    declare(base)
    declare(red)
    assert at_once(base) == {Priority.URGENT, Priority.HIGH}  # it does not know of red yet
    wait_until(lambda: len(base.link.connections()) == 1, "red is seen")
    assert at_once(base) == {*Priority}
    blue = make_station("blue", (endpoint,))
    hello_until_heard(blue, base)
    wait_until(lambda: len(base.link.connections()) == 2, "blue is seen")
    assert at_once(base) == {Priority.URGENT, Priority.HIGH}
    assert len(red.link.connections()) == 1 and at_once(red) == {*Priority}
    red.link.close()
    assert at_once(red) == set()


def test_many_packets_in_order(make_station: Any, endpoint: str) -> None:
    base = make_station("base", (), (endpoint,))
    red = make_station("red", (endpoint,))
    hello_until_heard(red, base)
    for number in range(2000):
        red.link.send(Send("to/base", b"h", b"%d" % number))
    red.link.send(Send("to/base", b"h", bytes(8 << 20)))
    got = [base.get(b"%d" % number) for number in range(2000)]
    assert len(got) == 2000 and base.get(bytes(8 << 20))


class HungConnection:
    """Passes a connection on to an endpoint, until it is hung: then it takes nothing any more, as a site that hangs."""

    def __init__(self, target: str) -> None:
        self._target = target
        self._is_hung = threading.Event()
        self._server = socket.create_server(("127.0.0.1", 0))
        self.endpoint = f"tcp/127.0.0.1:{self._server.getsockname()[1]}"
        self._sockets = [self._server]
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        near, _ = self._server.accept()
        host, port = self._target.partition("/")[2].split(":")
        far = socket.create_connection((host, int(port)))
        self._sockets += near, far
        for source, target in ((near, far), (far, near)):
            threading.Thread(target=self._copy, args=(source, target), daemon=True).start()

    def _copy(self, source: socket.socket, target: socket.socket) -> None:
        with suppress(OSError):
            while not self._is_hung.is_set() and (data := source.recv(1 << 16)):
                target.sendall(data)

    def hang(self) -> None:
        """Take nothing any more."""
        self._is_hung.set()

    def close(self) -> None:
        """Close the connection."""
        for each in self._sockets:
            each.close()


@pytest.mark.slow
@pytest.mark.parametrize("priority", Priority)
@pytest.mark.parametrize("is_router", [True, False])
def test_a_site_that_hangs_holds_up_no_others(
    make_station: Any, endpoint: str, is_router: bool, priority: Priority
) -> None:
    """Neither at the site that sends, nor at a router on the way.

    Feature: a site that hangs delays nothing that goes to other sites
    """
    patient = {"transport/link/tx/lease": "100000"}  # else zenoh closes the connection after 10 s
    base = make_station("base", (), (endpoint,), patient)
    sender = base if is_router else make_station("blue", (endpoint,), (), patient)
    connection = HungConnection(endpoint)
    try:
        red = make_station("red", (endpoint,), (), patient)
        hung = make_station("hung", (connection.endpoint,), (), patient)
        hello_until_heard(sender, red, hung)
        connection.hang()
        for number in range(20):
            sender.link.send(Send("to/hung", b"h", bytes(2 << 20), priority))
            send_until_heard(sender, red, b"%d" % number)
    finally:
        connection.close()


def test_foreign_packets_are_ignored(make_station: Any, endpoint: str) -> None:
    import zenoh

    base = make_station("base", (), (endpoint,))
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", f'["{endpoint}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as stranger:
        for key, attachment in (
            ("to/base/x", b"h"),
            ("to/base", None),
            ("to/base", bytes(500)),
            ("again/base/x", b"h"),
        ):
            stranger.put(f"pyros1/1/red/{key}", b"bad", attachment=attachment)

        def is_heard() -> bool:
            stranger.put("pyros1/1/red/to/base", b"good", attachment=b"h")
            return not base.packets.empty()

        wait_until(is_heard, "a good packet")
    assert {body for _, _, body in [*base.packets.queue]} == {b"good"}


def test_what_cannot_start(free_port: int) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", free_port))
        other.listen()
        with pytest.raises(LinkError, match=r"cannot start the bridge's network: .*in use"):
            Station("base", (), (f"tcp/127.0.0.1:{free_port}",))


def test_without_zenoh_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.transport.zenoh_link.find_spec", lambda name: None)
    with pytest.raises(LinkError, match=r"pip install 'pyros1\[bridge\]'"):
        Station("base")


PROGRAM = """
import sys
from pyros1.bridge.transport.zenoh_link import ZenohLink
link = ZenohLink(sys.argv[1], lambda *_: None, (), (sys.argv[2],))
print("ready", flush=True)
sys.stdin.read()
link.close()
"""


@pytest.mark.slow
@pytest.mark.parametrize("kill", [True, False])
def test_a_router_in_another_process_ends(make_station: Any, endpoint: str, kill: bool) -> None:
    """It ends in time although clients are connected; and they survive its being killed."""
    for _ in range(2):
        program = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, "base", endpoint], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert program.stdin and program.stdout
        try:
            assert program.stdout.readline() == "ready\n"
            red, blue = make_station("red", (endpoint,)), make_station("blue", (endpoint,))
            hello_until_heard(red, blue)
            if kill:
                os.kill(program.pid, signal.SIGKILL)
            else:
                program.stdin.close()
            assert program.wait(PATIENCE) == (-signal.SIGKILL if kill else 0)
            for station in (red, blue):
                station.link.send(Send("to/base", b"h", b"nobody is there"))
        finally:
            program.kill()
            program.wait()
            program.stdout.close()
            program.stdin.close()


def test_a_connection_that_is_made_after_the_end_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    """An attempt to connect cannot be interrupted, and may take long, but the end does not wait for it."""
    import zenoh

    may_go_on, was_closed = threading.Event(), threading.Event()

    class Session:
        def close(self) -> None:
            was_closed.set()

    def open_late(_: object) -> Session:
        assert may_go_on.wait(PATIENCE)
        return Session()

    monkeypatch.setattr(zenoh, "open", open_late)
    link = ZenohLink("red", lambda *_: None, ("tcp/127.0.0.1:1",))
    start = time.monotonic()
    link.close()
    assert time.monotonic() - start < CLOSE_TIME / 2
    assert not was_closed.is_set()
    may_go_on.set()
    assert was_closed.wait(PATIENCE)
