"""The zenoh session of a bridge to ROS 2, on loopback."""

from __future__ import annotations

import queue
import socket
import time
from collections.abc import Iterator
from typing import Any
from unittest.mock import Mock

import pytest

pytest.importorskip("zenoh")

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.rules.rules import Priority
from pyros1.ros2.zenoh.attachments import decode_attachment
from pyros1.ros2.zenoh.calls import IncomingCall
from pyros1.ros2.zenoh.names import DataKey, data_key
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2.zenoh.session import Ros2Session, make_zid
from pyros1.ros2.zenoh.tokens import Kind, parse_token

PATIENCE = 30.0
KEY = DataKey(3, "/chatter", "std_msgs/msg/String", "RIHS01_x")
VOLATILE, LATCHED = Qos(), Qos(transient_local=True)


class Peer:
    """A session, and what comes to it."""

    def __init__(self, name: str, **where: Any) -> None:
        self.tokens: queue.Queue[tuple[str, bool]] = queue.Queue()
        self.messages: queue.Queue[tuple[DataKey, bytes, bytes, str]] = queue.Queue()
        self.calls: queue.Queue[IncomingCall] = queue.Queue()
        self.zid = make_zid()
        self.session = Ros2Session(
            self.zid,
            name,
            KEY.domain,
            lambda key, is_there: self.tokens.put((key, is_there)),
            lambda *message: self.messages.put(message),
            self.calls.put,
            **where,
        )

    def declare(self, publishes: Qos | None = None, subscribes: Qos | None = None) -> None:
        """Publish and subscribe to the topic, once there is a connection."""
        deadline = time.monotonic() + PATIENCE
        while self.session.session is None:
            assert time.monotonic() < deadline, self.session.problem
            time.sleep(0.01)
        self.session.declare(
            {} if publishes is None else {data_key(KEY): (KEY, publishes, Priority.NORMAL)},
            {} if subscribes is None else {KEY: subscribes},
        )

    def await_token(self, peer: Peer, kind: Kind, is_there: bool = True) -> None:
        """Wait until a token of another session has come, or gone."""
        while True:
            key, came = self.tokens.get(timeout=PATIENCE)
            entity = parse_token(key)
            assert entity is not None
            if (entity.zid, entity.kind, came) == (peer.zid, kind, is_there):
                return

    def send(self, body: bytes) -> None:
        self.session.send(Send(data_key(KEY), b"", body, Priority.NORMAL))


@pytest.fixture
def peers() -> Iterator[tuple[Peer, Peer]]:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{unused.getsockname()[1]}"
    router = Peer("router", listen=[endpoint])
    client = Peer("client", connect=[endpoint])
    yield router, client
    client.session.close()
    router.session.close()


def test_messages_with_their_attachments(peers: tuple[Peer, Peer]) -> None:
    router, client = peers
    client.declare(publishes=VOLATILE)
    router.declare(subscribes=VOLATILE)
    client.await_token(router, Kind.SUBSCRIBER)
    before = time.time_ns()
    client.send(b"one")
    client.send(b"two")
    came = [router.messages.get(timeout=PATIENCE) for _ in range(2)]
    first, second = (decode_attachment(attachment) for _, _, attachment, _ in came)
    assert [(key, body) for key, body, *_ in came] == [(KEY, b"one"), (KEY, b"two")]
    assert first is not None and second is not None and first.gid == second.gid
    assert (first.sequence_number, second.sequence_number) == (1, 2)
    assert before <= first.source_time <= second.source_time <= time.time_ns()


def test_latched_messages_come_late(peers: tuple[Peer, Peer]) -> None:
    router, client = peers
    client.declare(publishes=LATCHED)
    router.await_token(client, Kind.PUBLISHER)
    client.send(b"one")
    client.send(b"two")
    router.declare(subscribes=LATCHED)
    came = [router.messages.get(timeout=PATIENCE) for _ in range(2)]
    assert [(body, session) for _, body, _, session in came] == [(b"one", client.zid), (b"two", client.zid)]


def test_what_is_declared_no_longer_is_gone(peers: tuple[Peer, Peer]) -> None:
    router, client = peers
    client.declare(publishes=VOLATILE, subscribes=VOLATILE)
    for kind in (Kind.NODE, Kind.PUBLISHER):
        router.await_token(client, kind)
    client.declare()
    router.await_token(client, Kind.PUBLISHER, is_there=False)
    router.await_token(client, Kind.SUBSCRIBER, is_there=False)
    client.send(b"nobody publishes this")
    client.session.close()
    router.await_token(client, Kind.NODE, is_there=False)
    assert router.messages.empty()


def test_nothing_is_sent_to_oneself(peers: tuple[Peer, Peer]) -> None:
    router, client = peers
    client.declare(publishes=VOLATILE, subscribes=VOLATILE)
    router.declare(subscribes=VOLATILE)
    client.await_token(router, Kind.SUBSCRIBER)
    client.send(b"one")
    assert router.messages.get(timeout=PATIENCE)[1] == b"one" and client.messages.empty()


def test_messages_that_nobody_can_use(peers: tuple[Peer, Peer]) -> None:
    router, client = peers
    client.declare(publishes=VOLATILE)
    router.declare(subscribes=VOLATILE)
    client.await_token(router, Kind.SUBSCRIBER)
    zenoh: Any = client.session.session
    zenoh.put(data_key(KEY), b"without an attachment")
    zenoh.put(data_key(KEY), b"with a long one", attachment=bytes(2000))
    zenoh.delete(data_key(KEY))
    client.send(b"good")
    assert router.messages.get(timeout=PATIENCE)[1] == b"good"


def test_a_key_that_is_refused_stops_no_others(peers: tuple[Peer, Peer], monkeypatch: pytest.MonkeyPatch) -> None:
    router, client = peers
    client.declare(publishes=VOLATILE)
    router.await_token(client, Kind.PUBLISHER)
    names = ("/a", "/bad", "/c")
    keys = [KEY._replace(name=name) for name in names]
    refuse: Any = client.session.zenoh.ZError("no such key")

    def declare_subscriber(key: str, *args: Any, **kwargs: Any) -> Any:
        if "/bad/" in key:
            raise refuse
        return original(key, *args, **kwargs)

    original = client.session.session.declare_subscriber
    stand_in = Mock(wraps=client.session.session, declare_subscriber=declare_subscriber)
    monkeypatch.setattr(client.session, "session", stand_in)
    illegal = KEY._replace(name="/not legal")
    publishers = {data_key(key): (key, VOLATILE, Priority.NORMAL) for key in keys}
    refused = client.session.declare(
        {"x": (illegal, VOLATILE, Priority.NORMAL), **publishers}, dict.fromkeys(keys, VOLATILE), [illegal, KEY]
    )
    assert {*refused} == {"/bad", "/not legal"} and refused["/bad"] == "zenoh refuses it: no such key"
    for kind in [Kind.PUBLISHER] * 3 + [Kind.SUBSCRIBER] * 2 + [Kind.SERVICE]:
        router.await_token(client, kind)
    monkeypatch.undo()
    assert "/bad" not in client.session.declare(publishers, dict.fromkeys(keys, VOLATILE)), "it is tried again"


def test_ids_of_sessions() -> None:
    zids = {make_zid() for _ in range(100)}
    assert len(zids) == 100 and all(len(zid) == 32 and zid[0] != "0" and int(zid, 16) for zid in zids)
