"""Names are remapped once, wherever they enter: under ``a:=b b:=c``, ``a`` is ``/b``, as in stock ROS.

Except where stock remaps twice, as mux and demux do (O30)."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from time import monotonic
from typing import Any

import pytest

from pyros1.bag.record.topic_selection import TopicSelection
from pyros1.bag.record.topics import TopicSearch
from pyros1.graph import Graph
from pyros1.msgs import AnyMsg
from pyros1.msgs.std_srvs.srv import Empty, Trigger
from pyros1.node import Node
from pyros1.topic_tools.mux import Mux
from pyros1.web.foxglove.requests import ClientChannel
from pyros1.web.foxglove.viewer_actions import Publishers
from pyros1.web.foxglove.viewer_context import ViewerContext
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.client import Client
from pyros1.web.server.access import Access

CHAIN = ["a:=b", "b:=c"]
KIND = "std_msgs/String"
PATIENCE = 20.0
AFTERWARDS = json.dumps({"op": "set_level", "level": "error"})
"""What comes behind a subscription waits until it is made."""
Use = Callable[[Node, Robot, str], object]


@pytest.fixture
def node(make_node: Callable[..., Node]) -> Node:
    """A node with a chain of remappings."""
    return make_node("me", argv=CHAIN, rosout=False)


@pytest.fixture
def robot(node: Node, environ: dict[str, str]) -> Iterator[Robot]:
    """A robot of the web server with that node."""
    robot = Robot(environ["ROS_MASTER_URI"], Access(), lambda: node)
    robot.start()
    assert robot.wait_for_node(PATIENCE)
    yield robot
    robot.close()


def record(node: Node, robot: Robot, name: str) -> None:
    (topic,) = TopicSearch(node, TopicSelection([name])).new_topics()
    assert topic == "/a"  # its name in the bag, as in stock ROS (O30)
    node.subscribe(topic, AnyMsg, print)


def listen(node: Node, robot: Robot, name: str) -> None:
    ready = threading.Event()
    robot.listen(f"/{name.lstrip('/')}", print, ready.set)
    assert ready.wait(PATIENCE)


def bridge(**frame: Any) -> Use:
    """Return a use: a client of rosbridge sends a frame, with the name as its topic and service."""

    def use(node: Node, robot: Robot, name: str) -> None:
        ready = threading.Event()
        client = Client(robot, lambda function: function(), lambda: None, ready.set)
        done = client.handle([json.dumps(frame | {"topic": name, "service": name}), AFTERWARDS])
        while not done:
            assert ready.wait(PATIENCE)
            ready.clear()
            done = client.handle(())
        told = client.take(monotonic()).frames
        assert not list(told)

    return use


def page_publishes(node: Node, robot: Robot, name: str) -> None:
    robot.publishers.publish(f"/{name.lstrip('/')}", KIND, {})


def viewer_publishes(node: Node, robot: Robot, name: str) -> None:
    Publishers(ViewerContext(robot)).advertise(ClientChannel(1, name, "json", KIND, ""))


USES: list[tuple[str, Use, str]] = [
    ("subscribe", lambda node, robot, name: node.subscribe(name, KIND, print), "/b"),
    ("advertise", lambda node, robot, name: node.advertise(name, KIND), "/b"),
    ("service", lambda node, robot, name: node.advertise_service(name, Empty, lambda request: None), "/b"),
    ("resolved by the program", lambda node, robot, name: node.advertise(node.resolve(name), KIND), "/c"),
    ("mux", lambda node, robot, name: Mux(node, "other", [name]), "/c"),
    ("bag record", record, "/b"),
    ("page, messages", listen, "/b"),
    ("page, publishing", page_publishes, "/b"),
    ("rosbridge, subscribe", bridge(op="subscribe", type=KIND), "/b"),
    ("rosbridge, advertise", bridge(op="advertise", type=KIND), "/b"),
    ("rosbridge, service", bridge(op="advertise_service", type="std_srvs/Empty"), "/b"),
    ("foxglove, publish", viewer_publishes, "/b"),
]


@pytest.mark.parametrize("name", ["a", "/a"])
@pytest.mark.parametrize(("use", "expected"), [pytest.param(*rest, id=what) for what, *rest in USES])
def test_names_of_a_chain(node: Node, robot: Robot, name: str, use: Use, expected: str) -> None:
    use(node, robot, name)
    state = Graph(node.master).state()
    tables = (state.publishers, state.subscribers, state.services)
    names = {each for table in tables for each, nodes in table.items() if node.name in nodes}
    assert names & {"/a", "/b", "/c"} == {expected}


def test_clients_call_the_service_that_the_first_remapping_names(robot: Robot, make_node: Callable[..., Node]) -> None:
    provider = make_node("provider")
    for name in ("/a", "/b", "/c"):
        provider.advertise_service(name, Trigger, lambda request, name=name: (True, name))
    for name in ("a", "/a"):
        client = Client(robot, lambda function: function(), lambda: None)
        assert client.handle([json.dumps({"op": "call_service", "service": name, "id": "1"})])
        told = client.take(monotonic()).frames
        (answer,) = map(json.loads, told)
        assert answer["values"] == {"success": True, "message": "/b"}
        client.close()
