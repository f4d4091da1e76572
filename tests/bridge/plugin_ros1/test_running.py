"""Bridges of the dialect: with each other, and with a program that does what zenoh-plugin-ros1 does by its source.

Feature: topics and services of robots that run zenoh-bridge-ros1 -- `pyros1 bridge --dialect zenoh-plugin-ros1`
"""

from __future__ import annotations

import json
import queue
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pyros1.bridge.plugin_ros1.config import parse_plugin_config
from pyros1.ground.errors import NodeError, ServiceError
from pyros1.master.server import Master
from pyros1.msgs import AnyMsg, from_definition
from pyros1.node import Node

from ..conftest import PATIENCE, QueuedSubscriber, subscriptions, wait_for_subscribers, wait_until

MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"
CHATTER = f"7374645f6d7367732f537472696e67/{MD5}/*/chatter"
CHATTER_BEACON = f"ros1_discovery_info/*/pub/7374645f6d7367732f537472696e67/{MD5}/*/chatter"
HELLO = b"\x05\x00\x00\x00hello"
SET_MD5 = "09fb03525b03e7ea1fd3992bafd87e16"
SET = f"7374645f737276732f536574426f6f6c/{SET_MD5}/*/set"
SET_BEACON = f"ros1_discovery_info/*/srv/7374645f737276732f536574426f6f6c/{SET_MD5}/*/set"


class RunningBridge:
    """A master with a bridge of the dialect, and a node for the test."""

    def __init__(self, name: str, rules: str, folder: Path, connect: tuple[str, ...], listen: tuple[str, ...]) -> None:
        from pyros1.bridge.plugin_ros1.keys import beacon_patterns
        from pyros1.bridge.plugin_ros1.runner import PluginBridge
        from pyros1.bridge.plugin_ros1.session import PluginSession

        self.master = Master(port=0, bind_host="127.0.0.1")
        self.master.start()
        self._environ = {"ROS_MASTER_URI": self.master.uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": str(folder / name)}
        self._nodes: list[Node] = []
        parsed = parse_plugin_config(rules, "rules.yaml").rules
        self.node = self.make_node("user")
        self.bridge_node = self.make_node(f"bridge_{name}")
        self.bridge = PluginBridge(
            self.bridge_node,
            parsed,
            lambda *functions: PluginSession(*functions, beacon_patterns(parsed.namespaces()), connect, listen),
        )

    def make_node(self, name: str) -> Node:
        node = Node(name, argv=[], environ=self._environ, handle_signals=False)
        self._nodes.append(node)
        return node

    def topics(self) -> dict[str, str]:
        return dict(self.node.master.get_published_topics())

    def services(self) -> dict[str, list[str]]:
        return dict(self.node.master.get_system_state()[2])

    def has_topic(self, topic: str) -> None:
        wait_until(lambda: topic in self.topics(), f"{topic} is there")

    def status(self) -> Any:
        return json.loads(self.bridge.status())

    def close(self) -> None:
        for node in reversed(self._nodes):
            node.shutdown()
        self.master.stop()


MakeBridge = Callable[..., RunningBridge]


@pytest.fixture
def make_bridge(tmp_path: Path) -> Iterator[MakeBridge]:
    """Return a function that starts a bridge: name, rules as YAML, endpoints to connect to and to listen on."""
    pytest.importorskip("zenoh")
    bridges: list[RunningBridge] = []

    def make(name: str, rules: str, connect: tuple[str, ...] = (), listen: tuple[str, ...] = ()) -> RunningBridge:
        bridges.append(RunningBridge(name, rules, tmp_path, connect, listen))
        return bridges[-1]

    yield make
    for bridge in reversed(bridges):
        bridge.close()


class SimulatedPlugin:
    """Does what zenoh-plugin-ros1 does, with keys as its source makes them: none of our code."""

    def __init__(self, endpoint: str, listens: bool = False) -> None:
        import zenoh

        self.zenoh = zenoh
        config = zenoh.Config()
        config.insert_json5("mode", '"peer"')
        config.insert_json5(f"{'listen' if listens else 'connect'}/endpoints", json.dumps([endpoint]))
        config.insert_json5("scouting/multicast/enabled", "false")
        self.session = zenoh.open(config)
        self.beacons: list[str] = []
        self.messages: queue.Queue[tuple[str, bytes]] = queue.Queue()
        self.heard: list[str] = []
        self._publishers: dict[str, Any] = {}
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._declared = [self._subscribe("ros1_discovery_info/*/*/*/*/*/*/**", self._on_beacon)]
        self._thread.start()

    def _subscribe(self, key: str, callback: Callable[[Any], object]) -> Any:
        return self.session.declare_subscriber(key, callback, allowed_origin=self.zenoh.Locality.REMOTE)

    def _on_beacon(self, sample: Any) -> None:
        assert sample.payload.to_bytes() == b""
        self.heard.append(str(sample.key_expr))

    def _run(self) -> None:
        while not self._end.wait(1.0):
            for key in [*self.beacons]:
                self.session.put(
                    key,
                    b"",
                    congestion_control=self.zenoh.CongestionControl.DROP,
                    priority=self.zenoh.Priority.BACKGROUND,
                    allowed_destination=self.zenoh.Locality.REMOTE,
                )

    def receive(self, key: str) -> None:
        """Receive the messages with a key."""
        self._declared.append(
            self._subscribe(key, lambda each: self.messages.put((str(each.key_expr), each.payload.to_bytes())))
        )

    def publish(self, key: str, body: bytes) -> None:
        """Publish a message."""
        if key not in self._publishers:
            self._publishers[key] = self.session.declare_publisher(
                key,
                congestion_control=self.zenoh.CongestionControl.BLOCK,
                allowed_destination=self.zenoh.Locality.REMOTE,
            )
        self._publishers[key].put(body)

    def is_received(self, key: str) -> bool:
        """Return whether a bridge receives the messages with a key."""
        self.publish(key, b"\x00\x00\x00\x00") if key not in self._publishers else None
        return bool(self._publishers[key].matching_status.matching)

    def serve(self, key: str, answer: Callable[[bytes], bytes]) -> None:
        """Answer the calls of a service."""

        def on_query(query: Any) -> None:
            query.reply(query.key_expr, answer(query.payload.to_bytes()))

        self._declared.append(self.session.declare_queryable(key, on_query, allowed_origin=self.zenoh.Locality.REMOTE))

    def call(self, key: str, request: bytes) -> Any:
        """Call a service; return the first reply."""
        return self.session.get(key, payload=request, allowed_destination=self.zenoh.Locality.REMOTE).recv()

    def close(self) -> None:
        self._end.set()
        self._thread.join()
        self.session.close()


@pytest.fixture
def make_plugin(make_bridge: MakeBridge) -> Iterator[Callable[..., SimulatedPlugin]]:
    """Return a function that starts a simulated plugin, which connects to an endpoint, or listens on it."""
    plugins: list[SimulatedPlugin] = []

    def make(endpoint: str, listens: bool = False) -> SimulatedPlugin:
        plugins.append(SimulatedPlugin(endpoint, listens))
        return plugins[-1]

    yield make
    for plugin in plugins:
        plugin.close()


MakePlugin = Callable[..., SimulatedPlugin]


def test_a_node_that_has_ended_before_its_bridge_begins(make_bridge: MakeBridge, endpoint: str) -> None:
    from pyros1.bridge.plugin_ros1.runner import PluginBridge
    from pyros1.bridge.plugin_ros1.session import PluginSession

    node = make_bridge("base", "{}", (), (endpoint,)).make_node("interrupted")
    node.shutdown()
    sessions: list[PluginSession] = []

    def make_session(*functions: Any) -> PluginSession:
        sessions.append(PluginSession(*functions, (), (), ("tcp/127.0.0.1:0",)))
        return sessions[0]

    with pytest.raises(NodeError):
        PluginBridge(node, parse_plugin_config("{}", "rules.yaml").rules, make_session)
    assert sessions[0].is_closing


@pytest.mark.slow
def test_a_topic_of_a_plugin(make_bridge: MakeBridge, make_plugin: MakePlugin, endpoint: str) -> None:
    base = make_bridge("base", "take: [/chatter]", (), (endpoint,))
    plugin = make_plugin(endpoint)
    plugin.beacons = [CHATTER_BEACON]
    base.has_topic("/chatter")
    assert base.topics()["/chatter"] == "std_msgs/String"
    assert not plugin.is_received(CHATTER), "nobody here subscribes"
    typed = QueuedSubscriber(base.node, "/chatter")
    raw = QueuedSubscriber(base.make_node("raw"), "/chatter", AnyMsg)  # type: ignore[arg-type]
    wait_until(lambda: plugin.is_received(CHATTER), "the bridge receives it")
    plugin.publish(CHATTER, HELLO)
    assert typed.get().data == "hello"
    header = raw.get()._connection_header
    assert (header["type"], header["md5sum"], header["latching"]) == ("std_msgs/String", MD5, "0")
    assert header["message_definition"].startswith("string data"), "the type is bundled, so its definition is known"
    wait_until(lambda: CHATTER_BEACON.replace("/pub/", "/sub/") in plugin.heard, "the bridge says that it receives it")
    plugin.publish(CHATTER.replace("*", "robot1"), b"\x05\x00\x00\x00other")  # matches, but is not what was announced
    plugin.session.delete(CHATTER)
    plugin.publish(CHATTER, HELLO)
    assert typed.get().data == "hello" and typed.is_silent()
    plugin.beacons = []
    wait_until(lambda: "/chatter" not in base.topics(), "it is gone with its beacons")
    wait_until(lambda: not plugin.is_received(CHATTER), "the bridge receives it no longer")


@pytest.mark.slow
def test_a_topic_for_a_plugin(make_bridge: MakeBridge, make_plugin: MakePlugin, endpoint: str) -> None:
    base = make_bridge("base", "send: [/chatter]", (), (endpoint,))
    plugin = make_plugin(endpoint)
    publisher: Any = base.node.advertise("/chatter", "std_msgs/String")
    wait_until(lambda: CHATTER_BEACON in plugin.heard, "the bridge announces it")
    assert subscriptions(publisher) == 0, "nobody receives it"
    plugin.receive(CHATTER)
    wait_until(lambda: _is_wanted(base, "/chatter"), "the bridge knows that somebody receives it")
    wait_for_subscribers(publisher)
    publisher.publish("hello")
    assert plugin.messages.get(timeout=PATIENCE) == (CHATTER, HELLO)
    publisher.unregister()
    wait_until(lambda: base.status()["sent"] == [], "the bridge notes that it is gone")


@pytest.mark.slow
def test_plugins_that_listen(make_bridge: MakeBridge, make_plugin: MakePlugin, free_ports: Any) -> None:
    endpoints = [f"tcp/127.0.0.1:{port}" for port in free_ports(3)]
    for number, connect in enumerate((endpoints[:1], endpoints[1:])):  # as a client, and as a router
        base = make_bridge(f"base{number}", "take: [/chatter]", tuple(connect))
        plugins = [make_plugin(endpoint, True) for endpoint in connect]
        plugins[-1].beacons = [CHATTER_BEACON]
        base.has_topic("/chatter")
        subscriber = QueuedSubscriber(base.node, "/chatter")
        wait_until(partial(plugins[-1].is_received, CHATTER), "the bridge receives it")
        plugins[-1].publish(CHATTER, HELLO)
        assert subscriber.get().data == "hello"


@pytest.mark.slow
def test_namespaces(make_bridge: MakeBridge, make_plugin: MakePlugin, endpoint: str) -> None:
    rules = "{take: ['robot1:/chatter'], send: [{topic: 'robot1:/chatter', here: /to_robot1}]}"
    base = make_bridge("base", rules, (), (endpoint,))
    plugin = make_plugin(endpoint)
    plugin.receive(CHATTER.replace("*", "robot1"))
    plugin.receive(CHATTER.replace("*", "robot2"))
    plugin.beacons = [CHATTER_BEACON.replace(f"{MD5}/*", f"{MD5}/{name}") for name in ("robot1", "robot2")]
    base.has_topic("/robot1/chatter")
    subscriber = QueuedSubscriber(base.node, "/robot1/chatter")
    key = CHATTER.replace("*", "robot1")
    wait_until(lambda: plugin.is_received(key), "the bridge receives it")
    plugin.publish(key, HELLO)
    assert subscriber.get().data == "hello"
    publisher: Any = base.node.advertise("/to_robot1", "std_msgs/String")
    wait_until(lambda: _is_wanted(base, "/to_robot1"), "the bridge knows that somebody receives it")
    wait_for_subscribers(publisher)
    publisher.publish("go")
    assert plugin.messages.get(timeout=PATIENCE) == (key, b"\x02\x00\x00\x00go")
    assert "/robot2/chatter" not in base.topics() and plugin.messages.empty()


def test_a_type_that_is_not_installed_has_no_definition(
    make_bridge: MakeBridge, make_plugin: MakePlugin, endpoint: str
) -> None:
    base = make_bridge("base", "take: ['/**']", (), (endpoint,))
    plugin = make_plugin(endpoint)
    # nowhere_msgs/Strange
    key = f"{b'nowhere_msgs/Strange'.hex()}/{'1' * 32}/*/strange"
    plugin.beacons = [f"ros1_discovery_info/*/pub/{key}"]
    base.has_topic("/strange")
    subscriber = QueuedSubscriber(base.node, "/strange", AnyMsg)  # type: ignore[arg-type]
    wait_until(lambda: plugin.is_received(key), "the bridge receives it")
    plugin.publish(key, b"\x01")
    header = subscriber.get()._connection_header
    assert header["message_definition"] == "*" and header["type"] == "nowhere_msgs/Strange"


@pytest.mark.slow
def test_a_service_of_a_plugin(make_bridge: MakeBridge, make_plugin: MakePlugin, endpoint: str) -> None:
    base = make_bridge("base", "call: [/set]", (), (endpoint,))
    plugin = make_plugin(endpoint)
    # The plugin passes the text of an error as if it were a response.
    plugin.serve(SET, lambda request: b"\x01\x02\x00\x00\x00ok" if request == b"\x01" else b"service crashed")
    plugin.beacons = [SET_BEACON]
    wait_until(lambda: "/set" in base.services(), "the service is there")
    client = base.node.service("/set", "std_srvs/SetBool")
    response = client(True)
    assert (response.success, response.message) == (True, "ok")
    with pytest.raises(ServiceError, match="service crashed"):
        client(False)
    wait_until(lambda: SET_BEACON.replace("/srv/", "/cl/") in plugin.heard, "the bridge says that it calls")
    (entry,) = base.status()["plugin_services"]
    assert (entry["calls"], entry["errors"], entry["last_error"]) == (2, 1, "service crashed")
    plugin.beacons = []
    wait_until(lambda: "/set" not in base.services(), "it is gone with its beacons")


def test_a_service_for_a_plugin(make_bridge: MakeBridge, make_plugin: MakePlugin, endpoint: str) -> None:
    base = make_bridge("base", "serve: [/set]", (), (endpoint,))
    plugin = make_plugin(endpoint)

    def handle(request: Any) -> tuple[bool, str]:
        if not request.data:
            raise RuntimeError("out of order")
        return True, "ok"

    base.node.advertise_service("/set", "std_srvs/SetBool", handle)
    wait_until(lambda: SET_BEACON in plugin.heard, "the bridge announces it")
    assert plugin.call(SET, b"\x01").ok.payload.to_bytes() == b"\x01\x02\x00\x00\x00ok"
    error = plugin.call(SET, b"\x00").err.payload.to_bytes()
    assert error == b"error processing request: out of order"
    (entry,) = base.status()["plugin_services"]
    assert (entry["kind"], entry["calls"], entry["errors"]) == ("serves", 2, 1)


def test_a_service_that_a_node_here_provides_is_not_replaced(
    make_bridge: MakeBridge, make_plugin: MakePlugin, endpoint: str
) -> None:
    base = make_bridge("base", "call: ['/**']", (), (endpoint,))
    base.node.advertise_service("/set", "std_srvs/SetBool", lambda _: (True, "here"))
    plugin = make_plugin(endpoint)
    plugin.serve(SET, lambda _: b"\x00\x00\x00\x00\x00")
    wait_until(lambda: base.status()["overflowed"] == 0 and len(base.services()) > 2, "the bridge runs")
    plugin.beacons = [SET_BEACON]
    wait_until(lambda: "/set" in base.status()["problems"], "the bridge says why it does not call it")
    assert base.node.service("/set", "std_srvs/SetBool")(True).message == "here"


@pytest.mark.slow
def test_two_bridges(make_bridge: MakeBridge, endpoint: str) -> None:
    rules = "{send: ['/**'], take: ['/**'], serve: ['/set'], call: ['/set']}"
    base, red = make_bridge("base", rules, (), (endpoint,)), make_bridge("red", rules, (endpoint,))
    cls: Any = from_definition("nowhere_msgs/Strange", "float64 strange\n")
    publisher: Any = red.node.advertise("/strange", cls)
    base.has_topic("/strange")
    subscriber = QueuedSubscriber(base.node, "/strange", AnyMsg)  # type: ignore[arg-type]
    wait_until(lambda: _is_wanted(red, "/strange"), "the bridge knows that somebody receives it")
    wait_for_subscribers(publisher)
    publisher.publish(1.5)
    assert len(subscriber.get()._buff) == 8
    red.node.advertise_service("/set", "std_srvs/SetBool", lambda _: (True, "red"))
    wait_until(lambda: "/set" in base.services(), "the service is there")
    assert base.node.service("/set", "std_srvs/SetBool")(True).message == "red"


def _is_wanted(bridge: RunningBridge, local: str) -> bool:
    return any(entry["wanted_by"] for entry in bridge.status()["sent"] if entry["local"] == local)


def test_nothing_comes_back(make_bridge: MakeBridge, endpoint: str) -> None:
    rules = "{send: ['/text'], take: ['/text']}"
    base, red = make_bridge("base", rules, (), (endpoint,)), make_bridge("red", rules, (endpoint,))
    publishers: list[Any] = [site.node.advertise("/text", "std_msgs/String") for site in (base, red)]
    subscribers = [QueuedSubscriber(site.make_node("listener"), "/text") for site in (base, red)]
    for site in (base, red):
        wait_until(lambda site=site: _is_wanted(site, "/text"), "the other one receives it")
        wait_until(
            lambda site=site: [entry["state"] for entry in site.status()["received"]] == ["subscribed"], "it takes it"
        )
    for number, publisher in enumerate(publishers):
        wait_for_subscribers(publisher, 2)
        publisher.publish(str(number))
    for subscriber in subscribers:
        assert sorted([subscriber.get().data, subscriber.get().data]) == ["0", "1"]
    for number, publisher in enumerate(publishers):
        publisher.publish(f"last {number}")
    for subscriber in subscribers:
        assert sorted([subscriber.get().data, subscriber.get().data]) == ["last 0", "last 1"]
        assert subscriber.is_silent()


@pytest.mark.slow
def test_a_bridge_that_cannot_connect_says_so(make_bridge: MakeBridge, endpoint: str) -> None:
    red = make_bridge("red", "{send: ['/text'], call: ['/set']}", (endpoint,))
    wait_until(lambda: red.status()["link"], "the reason")
    publisher: Any = red.node.advertise("/text", "std_msgs/String", latch=True)
    publisher.publish("first")
    wait_until(lambda: red.status()["sent"], "it would be sent")
    base = make_bridge("base", "take: ['/text']", (), (endpoint,))
    base.has_topic("/text")
    QueuedSubscriber(base.node, "/text").receives("first")
    assert red.status()["link"] == ""
