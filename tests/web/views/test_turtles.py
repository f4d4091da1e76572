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


class Shown:
    """All that a view has pushed so far; each push has what has changed."""

    def __init__(self, watched: Any) -> None:
        self._watched = watched
        self.look = lambda: watched.view.change({})  # now, and not within a second
        self.now: dict[str, Any] = {}
        self.drawings = 0

    def until(self, fits: Callable[[], bool]) -> None:
        """Wait until something holds after a push."""

        def look(data: dict[str, Any]) -> bool:
            self.now.update(data)
            self.drawings += "drawing" in data
            return fits()

        if not fits():
            self._watched.until(look)


def test_turtles_come_move_draw_and_go(simulator: Node, make_node: Make, watch: Make) -> None:
    shown, user = Shown(watch("turtles")), make_node("user")
    shown.until(lambda: "facts" in shown.now and "drawing" in shown.now)
    assert shown.now["facts"] == {"node": "/turtlesim", "nodes": ["/turtlesim"], "there": True}
    drawing = shown.now["drawing"]
    assert (drawing["encoding"], drawing["width"], drawing["height"]) == ("rgb8", 500, 500)
    call(user, "/spawn", Spawn, 2.0, 3.0, 1.5, "friend")
    call(user, "/turtle1/teleport_absolute", TeleportAbsolute, 8.0, 9.0, 0.5)
    shown.look()
    wanted = {"friend": [2.0, 3.0, 1.5], "turtle1": [8.0, 9.0, 0.5]}
    shown.until(lambda: shown.now.get("turtles") == wanted and shown.drawings == 2)
    call(user, "/kill", Kill, "friend")
    shown.look()
    shown.until(lambda: shown.now.get("turtles") == {"turtle1": wanted["turtle1"]})


def test_nothing_is_pushed_while_nothing_moves(make_node: Make, watch: Make) -> None:
    poses = make_node("sim").advertise("turtle1/pose", Pose)
    watched = watch("turtles")
    watched.until(lambda data: "facts" in data)
    assert poses.wait_for_subscribers(timeout=PATIENCE)
    poses.publish(1.0, 2.0, 3.0, 0.0, 0.0)
    watched.until(lambda data: data.get("turtles") == {"turtle1": [1.0, 2.0, 3.0]})
    poses.publish(1.0, 2.0, 3.0, 0.0, 0.0)
    assert watched.view.poll() is None


def test_two_simulators_and_stocks_without_a_drawing(make_node: Make, watch: Make) -> None:
    watched = watch("turtles")
    assert not watched.until(lambda data: "facts" in data)["facts"]["there"]
    for node, y in (("left", 1.0), ("right", 2.0)):
        make_node(node, namespace=f"/{node}").advertise("turtle1/pose", Pose, latch=True).publish(1.0, y, 0.0, 0.0, 0.0)
    shown: dict[str, Any] = {}

    def wait_until_shown(**parts: Any) -> None:
        """Wait for parts, which may come together or one after the other."""
        if not all(shown.get(name) == part for name, part in parts.items()):
            watched.until(
                lambda data: shown.update(data) or all(shown.get(name) == part for name, part in parts.items())
            )

    watched.view.change({})
    both = ["/left/left", "/right/right"]
    wait_until_shown(facts={"node": both[0], "nodes": both, "there": True}, turtles={"turtle1": [1.0, 1.0, 0.0]})
    watched.view.change({"node": both[1]})
    wait_until_shown(turtles={"turtle1": [1.0, 2.0, 0.0]})
    watched.view.change({"node": "/nobody"})
    wait_until_shown(facts={"node": "/nobody", "nodes": both, "there": False})


def test_numbers_that_are_none(make_node: Make, watch: Make) -> None:
    make_node("broken").advertise("turtle1/pose", Pose, latch=True).publish(float("nan"), 1.0, 0.0, 0.0, 0.0)
    watch("turtles").until(lambda data: data.get("turtles") == {"turtle1": None})
