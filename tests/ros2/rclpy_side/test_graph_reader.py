"""What rclpy says of ROS 2, as tokens."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.ground.errors import UnknownTypeError
from pyros1.ros2.rclpy_side.graph_reader import GraphReader
from pyros1.ros2.rclpy_side.qos import to_rclpy
from pyros1.ros2.zenoh.graph import HashedType, Ros2Graph
from pyros1.ros2.zenoh.names import HUMBLE_HASH
from pyros1.ros2.zenoh.qos import Qos

from .fake_rclpy import QOS, Network, Node

STRING, SET_BOOL = "std_msgs/msg/String", "std_srvs/srv/SetBool"
LATCHED = Qos(transient_local=True, depth=1)


class Reading:
    """A network with our node, and what is read of it."""

    def __init__(self) -> None:
        self.network = Network()
        self.ours = Node(self.network, "bridge")
        self.reader = GraphReader(self.ours, 3, "bridge", self._hash_of)

    def _hash_of(self, name: str) -> str:
        if name.startswith("no_msgs"):
            raise UnknownTypeError("package no_msgs is not installed")
        return "RIHS01_installed"

    def graph(self) -> Ros2Graph:
        graph = Ros2Graph(3, "b0")
        for token in self.reader.read():
            assert graph.add(token), "each token is valid, and no two are of the same entity"
        return graph


@pytest.fixture
def reading() -> Reading:
    return Reading()


def fill(node: Node, qos: Qos = LATCHED, topic: str = "/map") -> tuple[Any, Any]:
    publisher = node.create_publisher(STRING, topic, to_rclpy(qos, QOS))
    subscriber = node.create_subscription(STRING, topic, None, to_rclpy(Qos(), QOS), raw=True, callback_group=None)
    subscriber.gid = f"{topic:16}".encode()
    return publisher, subscriber


def test_topics(reading: Reading) -> None:
    reading.network.hashes["/map"] = "RIHS01_told"
    fill(Node(reading.network, "mapper", "/robot"))
    topic = reading.graph().topic("/map")
    assert [each.full_node_name for each in (*topic.publishers, *topic.subscribers)] == ["/robot/mapper"] * 2
    assert topic.types == (HashedType(STRING, "RIHS01_told"),)
    assert topic.publishers[0].qos == LATCHED and topic.subscribers[0].qos == Qos()


def test_services(reading: Reading) -> None:
    node = Node(reading.network, "switch")
    node.create_service(SET_BOOL, "/switch", None, callback_group=None)
    node.create_client("no_msgs/srv/Go", "/go", callback_group=None)
    node.create_service("a_msgs/action/Walk_SendGoal", "/walk/_action/send_goal", None, callback_group=None)
    graph = reading.graph()
    assert graph.service("/switch").servers[0].full_node_name == "/switch"
    assert graph.service("/switch").types == (HashedType(SET_BOOL, "RIHS01_installed"),)
    assert graph.service("/go").clients[0].hash == HUMBLE_HASH
    assert graph.service("/walk/_action/send_goal").servers[0].type == "a_msgs/action/Walk_SendGoal"


def test_without_hashes(reading: Reading) -> None:
    """Nodes of Humble, and programs that use DDS without ROS."""
    node = Node(reading.network, "_CREATED_BY_BARE_DDS_APP_", "_CREATED_BY_BARE_DDS_APP_")
    fill(node)
    publisher = reading.graph().topic("/map").publishers[0]
    assert (publisher.hash, publisher.full_node_name) == ("RIHS01_installed", "/_CREATED_BY_BARE_DDS_APP_")


def test_our_own_is_left_out(reading: Reading) -> None:
    fill(reading.ours)
    reading.ours.create_service(SET_BOOL, "/ours", None, callback_group=None)
    assert reading.reader.read() == set()
    other = Node(reading.network, "bridge", "/")
    graph = reading.graph()
    assert [node.full_node_name for node in graph.nodes()] == ["/bridge"], "there is another one"
    other.destroy_node()
    assert reading.reader.read() == set()


def test_own_publishers(reading: Reading) -> None:
    ours, _ = fill(reading.ours)
    theirs, _ = fill(Node(reading.network, "mapper"))
    theirs.gid = b"another publisher"
    assert reading.reader.own_gids("/map") == {ours.gid: True, theirs.gid[:16]: False}


def test_a_node_that_ends_meanwhile(reading: Reading) -> None:
    for name in ("gone", "switch"):
        Node(reading.network, name).create_service(SET_BOOL, f"/{name}_on", None, callback_group=None)
    graph = reading.graph()
    assert [*graph.services()] == ["/switch_on"]


def test_illegal_names_and_what_is_never_bridged(reading: Reading) -> None:
    node = Node(reading.network, "mapper")
    for topic in ("/rosout", "/parameter_events", "no slash", "/map"):
        fill(node, topic=topic)
    assert {*reading.graph().topics()} == {"/rosout", "/map"}  # the log is bridged to ROS 1


def test_not_more_than_is_kept(reading: Reading, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.ros2.rclpy_side.graph_reader.MAX_ENTITIES", 10)
    for number in range(30):
        Node(reading.network, f"node{number}")
    assert len(reading.reader.read()) == 10


def test_tokens_stay_the_same(reading: Reading) -> None:
    publisher, _ = fill(Node(reading.network, "mapper"))
    before = reading.reader.read()
    assert reading.reader.read() == before
    publisher.qos = to_rclpy(Qos(), QOS)
    assert len(reading.reader.read() - before) == 1, "another QoS is another publisher"
