"""Turtles on the page."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.msgs.turtlesim.msg import Pose
from pyros1.msgs.turtlesim.srv import Kill, Spawn, TeleportAbsolute
from pyros1.node import Node
from pyros1.turtlesim.simulator import Simulator

PATIENCE = 20.0
Make = Callable[..., Any]


@pytest.fixture
def simulator(make_node: Make) -> Iterator[Node]:
    """A running turtlesim_node."""
    node: Node = make_node("turtlesim", wall_time=True)
    running = threading.Thread(target=Simulator(node).run)
    running.start()
    yield node
    node.shutdown()
    running.join(PATIENCE)


def call(node: Node, service: str, kind: Any, *args: object) -> None:
    node.service(service, kind).call(kind._request_class(*args), PATIENCE)


def test_turtles_come_move_draw_and_go(simulator: Node, make_node: Make, watch: Make) -> None:
    watched, user = watch("turtles"), make_node("user")
    facts = watched.until(lambda data: "facts" in data)["facts"]
    assert facts == {"node": "/turtlesim", "nodes": ["/turtlesim"], "there": True}
    drawing = watched.until(lambda data: "drawing" in data)["drawing"]
    assert (drawing["encoding"], drawing["width"], drawing["height"]) == ("rgb8", 500, 500)
    call(user, "/spawn", Spawn, 2.0, 3.0, 1.5, "friend")
    call(user, "/turtle1/teleport_absolute", TeleportAbsolute, 8.0, 9.0, 0.5)
    watched.until(lambda data: "drawing" in data)
    wanted = {"friend": [2.0, 3.0, 1.5], "turtle1": [8.0, 9.0, 0.5]}
    watched.until(lambda data: data.get("turtles") == wanted)
    call(user, "/kill", Kill, "friend")
    watched.until(lambda data: data.get("turtles") == {"turtle1": wanted["turtle1"]})
    assert watched.view.take() is None, "nothing moves"


def test_two_simulators_and_stocks_without_a_drawing(make_node: Make, watch: Make) -> None:
    watched = watch("turtles")
    assert not watched.until(lambda data: "facts" in data)["facts"]["there"]
    for node, y in (("left", 1.0), ("right", 2.0)):
        make_node(node, namespace=f"/{node}").advertise("turtle1/pose", Pose, latch=True).publish(1.0, y, 0.0, 0.0, 0.0)
    both = ["/left/left", "/right/right"]
    watched.until(lambda data: data.get("facts") == {"node": both[0], "nodes": both, "there": True})
    watched.until(lambda data: data.get("turtles") == {"turtle1": [1.0, 1.0, 0.0]})
    watched.view.change({"node": both[1]})
    watched.until(lambda data: data.get("turtles") == {"turtle1": [1.0, 2.0, 0.0]})
    watched.view.change({"node": "/nobody"})
    watched.until(lambda data: data.get("facts") == {"node": "/nobody", "nodes": both, "there": False})


def test_numbers_that_are_none(make_node: Make, watch: Make) -> None:
    make_node("broken").advertise("turtle1/pose", Pose, latch=True).publish(float("nan"), 1.0, 0.0, 0.0, 0.0)
    watch("turtles").until(lambda data: data.get("turtles") == {"turtle1": None})
