"""Bridges to ROS 2 that run: with a session that does what ROS 2 nodes do, and with each other.

Feature: topics of ROS 2 nodes that use rmw_zenoh -- `pyros1 bridge ros2`, without a ROS 2 installation
"""

from __future__ import annotations

import json
import queue
import socket
import struct
from collections.abc import Callable, Iterator
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

pytest.importorskip("zenoh")

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.status import status_lines
from pyros1.ground.errors import Error, NodeError
from pyros1.master.server import Master
from pyros1.node import Node
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.bridge.runner import Ros2Bridge
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2.zenoh.calls import IncomingCall
from pyros1.ros2.zenoh.graph import Ros2Graph
from pyros1.ros2.zenoh.names import DataKey, data_key
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2.zenoh.session import Ros2Session, make_zid
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.type_hash import type_hash

from ...bridge.conftest import PATIENCE, QueuedSubscriber, wait_until

VOLATILE, LATCHED = Qos(), Qos(transient_local=True)


def key(topic: str, type: str = "std_msgs/msg/String") -> DataKey:
    return DataKey(0, topic, type, type_hash(type, distribution_types()))


def string(text: str) -> bytes:
    """Return a std_msgs/msg/String as CDR."""
    data = text.encode() + b"\0"
    return b"\0\1\0\0" + struct.pack("<I", len(data)) + data


class Ros2Peer:
    """A session that publishes and subscribes as ROS 2 nodes do."""

    def __init__(self, endpoint: str) -> None:
        self.messages: queue.Queue[tuple[str, bytes]] = queue.Queue()
        self.calls: queue.Queue[IncomingCall] = queue.Queue()
        zid = make_zid()
        self.graph = Ros2Graph(0, zid)
        self.session = Ros2Session(zid, "peer", 0, self._on_token, self._on_message, self.calls.put, connect=[endpoint])
        self._publishes: dict[str, tuple[DataKey, Qos, Priority]] = {}
        self._subscribes: dict[DataKey, Qos] = {}
        self._offers: list[DataKey] = []
        self._clients: list[DataKey] = []
        wait_until(lambda: self.session.session is not None, "the peer is connected")

    def _on_token(self, token: str, is_there: bool) -> None:
        (self.graph.add if is_there else self.graph.remove)(token)

    def _on_message(self, key: DataKey, body: bytes, attachment: bytes, session: str) -> None:
        self.messages.put((key.name, body))

    def publish(self, key: DataKey, qos: Qos = VOLATILE) -> None:
        self._publishes[data_key(key)] = (key, qos, Priority.NORMAL)
        self._declare()

    def subscribe(self, key: DataKey, qos: Qos = VOLATILE) -> None:
        self._subscribes[key] = qos
        self._declare()

    def offer(self, key: DataKey) -> None:
        self._offers.append(key)
        self._declare()

    def make_client(self, key: DataKey) -> None:
        self._clients.append(key)
        self._declare()

    def _declare(self) -> None:
        self.session.declare(self._publishes, self._subscribes, self._offers, self._clients)

    def send(self, key: DataKey, body: bytes) -> None:
        self.session.send(Send(data_key(key), b"", body, Priority.NORMAL))

    def is_subscribed_by(self, name: str) -> None:
        wait_until(lambda: self.graph.topic(name).subscribers, f"somebody subscribes to {name}")

    def get(self) -> tuple[str, bytes]:
        return self.messages.get(timeout=PATIENCE)


class RunningBridge:
    """A master with a bridge to ROS 2, and a node for the test.

    Attributes:
        on_token, on_message: let something come from ROS 2.
    """

    on_token: Callable[[str, bool], object]
    on_message: Callable[..., object]

    def __init__(
        self, folder: Path, rules: Ros2Rules | None = None, name: str = "bridge", call_time: float = 20.0, **where: Any
    ) -> None:
        self.master = Master(port=0, bind_host="127.0.0.1")
        self.master.start()
        self.environ = {"ROS_MASTER_URI": self.master.uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": str(folder)}
        self._call_time = call_time
        self._nodes: list[Node] = []
        self.node = self.make_node("user")
        self.bridge = self.make_bridge("bridge_ros2", name, rules, **where)

    def make_node(self, name: str) -> Node:
        self._nodes.append(Node(name, argv=[], environ=self.environ, handle_signals=False))
        return self._nodes[-1]

    def make_bridge(
        self,
        name: str,
        ros2_name: str,
        rules: Ros2Rules | None = None,
        find_name: Callable[[], str] | None = None,
        **where: Any,
    ) -> Ros2Bridge:
        self.bridge_node = self.make_node(name)
        return Ros2Bridge(
            self.bridge_node,
            ros2_name,
            0,
            rules or Ros2Rules(),
            TypePairs(),
            partial(self._make_session, ros2_name, where),
            self._call_time,
            poll_period=0.05,
            find_name=find_name,
        )

    def _make_session(self, name: str, where: Any, zid: str, *callbacks: Any) -> Ros2Session:
        self.on_token, self.on_message, _ = callbacks
        return Ros2Session(zid, name, 0, *callbacks, **where)

    def topics(self) -> dict[str, str]:
        return dict(self.node.master.get_published_topics())

    def services(self) -> list[str]:
        return [name for name, _ in self.node.master.get_system_state()[2]]

    def subscribes(self, publisher: Any, *nodes: str) -> None:
        """Wait until bridges subscribe; their questions for the type are connections, too, but over TCP."""
        wanted = {*(nodes or ("/bridge_ros2",))}

        def hold() -> bool:
            return wanted <= {link.peer for link in publisher.links if link.transport == "INTRAPROCESS"}

        wait_until(hold, f"{wanted} subscribe")

    def status(self) -> Any:
        return json.loads(self.bridge.status())

    def close(self) -> None:
        for node in reversed(self._nodes):
            node.shutdown()
        self.master.stop()


@pytest.fixture
def endpoint() -> str:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{unused.getsockname()[1]}"


@pytest.fixture
def bridge(endpoint: str, tmp_path: Path) -> Iterator[RunningBridge]:
    running = RunningBridge(tmp_path, listen=[endpoint])
    yield running
    running.close()


@pytest.fixture
def peer(bridge: RunningBridge, endpoint: str) -> Iterator[Ros2Peer]:
    peer = Ros2Peer(endpoint)
    yield peer
    peer.session.close()


def test_a_node_that_has_ended_before_its_bridge_begins(bridge: RunningBridge) -> None:
    node = bridge.make_node("interrupted")
    node.shutdown()
    closed: list[bool] = []

    class Session(Ros2Session):
        def close(self) -> None:
            super().close()
            closed.append(True)

    with pytest.raises(NodeError):
        Ros2Bridge(
            node,
            "x",
            0,
            Ros2Rules(),
            TypePairs(),
            lambda zid, *callbacks: Session(zid, "x", 0, *callbacks, listen=["tcp/127.0.0.1:0"]),
        )
    assert closed


def test_from_ros1_to_ros2(bridge: RunningBridge, peer: Ros2Peer) -> None:
    publisher: Any = bridge.node.advertise("/chatter", "std_msgs/String", queue_size=10)
    wait_until(lambda: peer.graph.topic("/chatter").publishers, "ROS 2 sees the topic")
    (seen,) = peer.graph.topic("/chatter").publishers
    assert (seen.type, seen.node_name, seen.qos.reliable, seen.qos.transient_local) == (
        "std_msgs/msg/String",
        "bridge",
        True,
        False,
    )
    assert not any(link.transport == "INTRAPROCESS" for link in publisher.links), "nobody in ROS 2 wants it yet"
    peer.subscribe(key("/chatter"))
    bridge.subscribes(publisher)
    publisher.publish("hello")
    assert peer.get() == ("/chatter", string("hello"))


def test_rates_are_in_the_status(bridge: RunningBridge, peer: Ros2Peer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.rates.PERIOD", 0.05)
    peer.publish(key("/chatter"))
    QueuedSubscriber(bridge.node, "/chatter")
    peer.is_subscribed_by("/chatter")

    def is_counted() -> bool:
        peer.send(key("/chatter"), string("hello"))
        return bool(bridge.status()["received"][0]["messages_per_second"])

    wait_until(is_counted, "the status has a rate")


def test_from_ros2_to_ros1(bridge: RunningBridge, peer: Ros2Peer) -> None:
    peer.publish(key("/chatter"))
    wait_until(lambda: bridge.topics().get("/chatter") == "std_msgs/String", "ROS 1 sees the topic")
    assert not peer.graph.topic("/chatter").subscribers, "nobody in ROS 1 wants it yet"
    subscriber = QueuedSubscriber(bridge.node, "/chatter")
    peer.is_subscribed_by("/chatter")
    peer.send(key("/chatter"), string("hello"))
    assert subscriber.get().data == "hello"


def test_latched_both_ways(bridge: RunningBridge, peer: Ros2Peer) -> None:
    publisher: Any = bridge.node.advertise("/map", "std_msgs/String", queue_size=1, latch=True)
    publisher.publish("map")
    peer.publish(key("/robot_description"), LATCHED)
    peer.send(key("/robot_description"), string("robot"))
    peer.subscribe(key("/map"), LATCHED)
    assert peer.get() == ("/map", string("map"))
    for name in ("first", "late"):
        node = bridge.make_node(name)
        assert QueuedSubscriber(node, "/robot_description").get().data == "robot", name


def test_a_latched_message_ends_with_its_publisher(
    bridge: RunningBridge, peer: Ros2Peer, endpoint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.ros2.bridge.sources.GRACE", 0.0)
    monkeypatch.setattr("pyros1.ros2.bridge.worker.POLL_PERIOD", 0.05)
    other = Ros2Peer(endpoint)
    static = key("/static")
    for each, text in ((peer, "one"), (other, "two")):
        each.publish(static, LATCHED)
        each.send(static, string(text))
    subscriber = QueuedSubscriber(bridge.node, "/static")
    assert {subscriber.get().data for _ in range(2)} == {"one", "two"}
    other.session.close()
    names = count()

    def is_forgotten() -> bool:
        late = bridge.make_node(f"late{next(names)}")
        kept = QueuedSubscriber(late, "/static")
        first = kept.get().data
        assert first == "one" or kept.get().data == "one", "its publisher is there"
        late.shutdown()
        return first == "one" and kept.is_silent()

    wait_until(is_forgotten, "late subscribers do not get the message of the publisher that is gone")


def test_each_publisher_keeps_its_latched_message(bridge: RunningBridge, peer: Ros2Peer, endpoint: str) -> None:
    publishers: list[Any] = []

    def publish(name: str) -> None:
        publisher: Any = bridge.make_node(name).advertise("/static", "std_msgs/String", queue_size=1, latch=True)
        publisher.publish(name)
        publishers.append(publisher)

    publish("one")
    publish("two")
    peer.subscribe(key("/static"), LATCHED)
    assert {peer.get(), peer.get()} == {("/static", string("one")), ("/static", string("two"))}
    for number in range(12):
        publishers[0].publish(f"one {number}")
        assert peer.get() == ("/static", string(f"one {number}"))
    publish("three")
    assert peer.get() == ("/static", string("three")), "its publisher is new"
    late = Ros2Peer(endpoint)
    try:
        late.subscribe(key("/static"), LATCHED)
        expected = {("/static", string(text)) for text in ("one 11", "two", "three")}
        assert {late.get() for _ in range(3)} == expected and late.messages.empty()
        publishers[1].unregister()
        wait_until(lambda: len(late.graph.topic("/static").publishers) == 2, "its publisher in ROS 2 is gone, too")
    finally:
        late.session.close()


def test_headers_are_counted(bridge: RunningBridge, peer: Ros2Peer) -> None:
    imu = key("/header", "std_msgs/msg/Header")
    peer.publish(imu)
    subscriber = QueuedSubscriber(bridge.node, "/header", "std_msgs/Header")
    peer.is_subscribed_by("/header")
    for number in range(3):
        peer.send(imu, b"\0\1\0\0" + struct.pack("<iII", number, 5, 2) + b"a\0")
    came = [subscriber.get() for _ in range(3)]
    assert [(each.seq, each.stamp.secs, each.stamp.nsecs, each.frame_id) for each in came] == [
        (1, 0, 5, "a"),
        (2, 1, 5, "a"),
        (3, 2, 5, "a"),
    ]


def test_damaged_messages_are_counted_and_left_out(bridge: RunningBridge, peer: Ros2Peer) -> None:
    peer.publish(key("/chatter"))
    subscriber = QueuedSubscriber(bridge.node, "/chatter")
    peer.is_subscribed_by("/chatter")
    for body in (b"", b"\0\1\0\0", string("hello")[:-3], b"\0\1\0\0\xff\xff\xff\xff"):
        peer.send(key("/chatter"), body)
    peer.send(key("/chatter"), string("good"))
    assert subscriber.get().data == "good"
    wait_until(lambda: bridge.status()["received"][0]["messages"] == 1, "the good one is counted")
    assert bridge.status()["received"][0]["dropped"] == {"could not be converted": 4}


def test_both_sides_publish_on_one_topic(bridge: RunningBridge, peer: Ros2Peer) -> None:
    publisher: Any = bridge.node.advertise("/chatter", "std_msgs/String", queue_size=10)
    subscriber = QueuedSubscriber(bridge.node, "/chatter")
    peer.publish(key("/chatter"))
    peer.subscribe(key("/chatter"))
    peer.is_subscribed_by("/chatter")
    bridge.subscribes(publisher)
    publisher.publish("from ROS 1")
    assert peer.get() == ("/chatter", string("from ROS 1")) and subscriber.get().data == "from ROS 1"
    peer.send(key("/chatter"), string("from ROS 2"))
    assert subscriber.get().data == "from ROS 2"
    publisher.publish("the end")
    assert peer.get() == ("/chatter", string("the end")) and subscriber.get().data == "the end"


def test_two_bridges_of_one_master_make_no_loop(bridge: RunningBridge, peer: Ros2Peer, endpoint: str) -> None:
    second = bridge.make_bridge("another_bridge", "bridge", connect=[endpoint])
    publisher: Any = bridge.node.advertise("/chatter", "std_msgs/String", queue_size=10)
    subscriber = QueuedSubscriber(bridge.node, "/chatter")
    peer.subscribe(key("/chatter"))
    bridge.subscribes(publisher, "/bridge_ros2", "/another_bridge")
    publisher.publish("once")
    assert [peer.get() for _ in range(2)] == [("/chatter", string("once"))] * 2, "once from each bridge"
    publisher.publish("again")
    assert peer.get() == ("/chatter", string("again"))
    assert [subscriber.get().data for _ in range(2)] == ["once", "again"]
    assert bridge.status()["received"] == []
    for running in (bridge.status(), json.loads(second.status())):
        assert "messages arrive twice" in running["problems"]["/bridge"]


def test_bridges_of_a_master_that_is_started_anew(endpoint: str, tmp_path: Path) -> None:
    name = "one"
    bridge = RunningBridge(tmp_path, name=name, find_name=lambda: name, listen=[endpoint])
    peer = Ros2Peer(endpoint)
    try:
        second = bridge.make_bridge("another_bridge", name, find_name=lambda: name, connect=[endpoint])
        statuses = lambda: [bridge.status(), json.loads(second.status())]  # noqa: E731
        publisher: Any = bridge.node.advertise("/map", "std_msgs/String", queue_size=1, latch=True)
        publisher.publish("map")
        peer.subscribe(key("/map"), LATCHED)
        assert [peer.get() for _ in range(2)] == [("/map", string("map"))] * 2, "once from each bridge"
        name = "two"
        wait_until(lambda: all("/two" in status["problems"] for status in statuses()), "each knows the other again")
        assert [peer.get() for _ in range(2)] == [("/map", string("map"))] * 2, "their publishers are new"
        wait_until(lambda: [each.node_name for each in peer.graph.nodes()] == ["two", "two"], "they have new names")
        assert {each.node_name for each in peer.graph.topic("/map").publishers} == {"two"}
        assert all("/one" not in status["problems"] for status in statuses())
        assert all(status["received"] == [] for status in statuses())
    finally:
        peer.session.close()
        bridge.close()


def test_two_masters_with_ros2_between_them(bridge: RunningBridge, endpoint: str, tmp_path: Path) -> None:
    other = RunningBridge(tmp_path, name="other", connect=[endpoint])
    try:
        publisher: Any = bridge.node.advertise("/chatter", "std_msgs/String", queue_size=10)
        subscriber = QueuedSubscriber(other.node, "/chatter")
        bridge.subscribes(publisher)
        wait_until(lambda: bridge.status()["sent"][0]["wanted_by"], "it is wanted")
        publisher.publish("hello")
        assert subscriber.get().data == "hello"
        assert bridge.status()["received"] == [] and other.status()["sent"] == [], "it does not come back"
    finally:
        other.close()


def test_a_topic_ends_with_its_publisher(bridge: RunningBridge, peer: Ros2Peer) -> None:
    peer.publish(key("/chatter"))
    wait_until(lambda: "/chatter" in bridge.topics(), "ROS 1 sees the topic")
    peer.session.close()
    wait_until(lambda: "/chatter" not in bridge.topics(), "it is gone")


def test_status_and_problems(bridge: RunningBridge, peer: Ros2Peer) -> None:
    peer.publish(DataKey(0, "/strange", "strange_msgs/msg/Type", "RIHS01_" + "0" * 64))
    bridge.node.advertise("/chatter", "std_msgs/String", queue_size=10)
    wait_until(lambda: bridge.status()["sent"] and bridge.status()["problems"], "the status says all of it")
    status = bridge.status()
    assert status["sites"] == [{"name": "ROS 2", "state": "present", "round_trip": None}]
    assert [*status_lines(status)][:2] == ["bridge to ROS 2 through zenoh, domain 0", "  nodes: /peer"]
    assert status["problems"]["/strange"].startswith("the definition of strange_msgs/msg/Type is not known here")
    assert status["sent"][0]["type"] == "std_msgs/msg/String" and status["sent"][0]["wanted_by"] == []


def test_a_topic_that_zenoh_refuses(bridge: RunningBridge, peer: Ros2Peer, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(key: DataKey) -> str:
        if key.name == "/bad":
            raise Error("no such key")
        return data_key(key)

    monkeypatch.setattr("pyros1.ros2.zenoh.session.data_key", refuse)
    for name in ("/a", "/bad", "/c"):
        bridge.node.advertise(name, "std_msgs/String", queue_size=10)
    wait_until(lambda: {"/a", "/c"} <= peer.graph.topics().keys(), "ROS 2 sees the others")
    wait_until(lambda: bridge.status()["problems"].get("/bad") == "zenoh refuses it: no such key", "the status says so")


def test_a_router_that_dies_and_returns(endpoint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.link_report.PATIENCE", 0.0)
    listen: Any = lambda: Ros2Session(make_zid(), "router", 0, Mock(), Mock(), Mock(), listen=[endpoint])  # noqa: E731
    router = listen()
    bridge = RunningBridge(tmp_path, connect=[endpoint])
    try:
        logged: list[str] = []
        monkeypatch.setattr(
            bridge.bridge_node.log, "peer_event", lambda level, text, *args: logged.append(text % tuple(args))
        )
        wait_until(lambda: not bridge.status()["link"], "the bridge is connected")
        router.close()
        problem = f"no router responds at {endpoint}"
        wait_until(lambda: bridge.status()["link"] == problem, "the status says that it is gone")
        wait_until(lambda: f"no connection to ROS 2: {problem}" in logged, "the log does, too")
        router = listen()
        wait_until(lambda: "connected to ROS 2" in logged and not bridge.status()["link"], "it is there again")
    finally:
        bridge.close()
        router.close()
