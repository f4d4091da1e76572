"""A page's gamepad on a topic."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError

PATIENCE = 20.0
DRIVE = {"axes": [0.0, 1.0], "buttons": [1]}
ARGS = {"topic": "joy", "frame_id": "pad", "hz": 50, "state": None}
Make = Callable[..., Any]


class Ear:
    """What is heard on a topic."""

    def __init__(self, node: Any, topic: str = "/joy") -> None:
        self._heard: queue.Queue[Any] = queue.Queue()
        self.subscriber = node.subscribe(topic, Joy, self._heard.put)

    def hear(self) -> tuple[list[float], list[int]]:
        """Return the axes and buttons of the next message."""
        message = self._heard.get(timeout=PATIENCE)
        assert message.header.frame_id == "pad" and message.header.stamp.to_sec() > 0
        return list(message.axes), list(message.buttons)

    def hear_until(self, axes: list[float]) -> None:
        """Wait for a message with some axes."""
        while self.hear()[0] != axes:
            pass

    def hears_more(self, seconds: float) -> bool:
        """Return whether a message arrives in some time."""
        try:
            self._heard.get(timeout=seconds)
        except queue.Empty:
            return False
        return True


@pytest.fixture
def ear(make_node: Make) -> Ear:
    return Ear(make_node("teleop"))


def test_a_gamepad_is_repeated_until_the_page_lets_go_or_is_gone(ear: Ear, watch: Make, robot: Robot) -> None:
    watched = watch("gamepad", **{**ARGS, "state": DRIVE})
    shown = watched.until(lambda data: data["subscribers"] == 0)
    assert shown == {"topic": "/joy", "sent": 0, "subscribers": 0, "problem": ""}  # the first state may be old
    watched.view.change({**ARGS, "state": DRIVE})
    assert ear.hear() == ear.hear() == ([0.0, 1.0], [1])
    watched.view.change(ARGS)
    ear.hear_until([0.0, 0.0])
    assert not ear.hears_more(0.1)
    watched.view.change({**ARGS, "state": DRIVE})
    ear.hear_until([0.0, 1.0])
    watched.view.close()
    ear.hear_until([0.0, 0.0])
    assert not ear.hears_more(0.1) and not robot.gamepads


def test_a_page_that_says_nothing_more_stops_the_robot(ear: Ear, watch: Make) -> None:
    watched = watch("gamepad", **ARGS)
    watched.view.change({**ARGS, "state": DRIVE})
    ear.hear_until([0.0, 1.0])
    ear.hear_until([0.0, 0.0])  # after SILENCE, though the connection is there
    assert not ear.hears_more(0.1)


def test_a_state_is_not_published_late(ear: Ear, watch: Make, robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    """The publisher has been closed, and to open it again takes longer than the page drives."""
    idle = {**ARGS, "hz": 5}
    watched = watch("gamepad", **idle)
    for state, axes in ((DRIVE, [0.0, 1.0]), (None, [0.0, 0.0])):
        watched.view.change({**idle, "state": state})
        ear.hear_until(axes)
    may_open, is_opening = threading.Event(), threading.Event()

    def slowly(call: Callable[..., Any], *args: Any) -> Any:
        is_opening.set()
        assert may_open.wait(PATIENCE)
        return call(*args)

    monkeypatch.setattr(robot.publishers, "advertise", partial(slowly, robot.publishers.advertise))
    monkeypatch.setattr(robot.publishers, "publish", partial(slowly, robot.publishers.publish))
    watched.view.change({**idle, "state": DRIVE})
    assert is_opening.wait(PATIENCE)
    watched.view.change(idle)
    may_open.set()
    assert not ear.hears_more(0.2)
    watched.view.change({**idle, "state": DRIVE})
    ear.hear_until([0.0, 1.0])


def test_one_page_at_a_time(watch: Make, robot: Robot) -> None:
    watched = watch("gamepad", **ARGS)
    with pytest.raises(RequestError, match="another page is already publishing /joy"):
        watch("gamepad", **ARGS)
    watch("gamepad", **{**ARGS, "topic": "/other/joy"})
    watched.view.close()
    watch("gamepad", **ARGS)
    assert {*robot.gamepads} == {"/joy", "/other/joy"}


def test_what_is_refused(make_node: Make, watch: Make, robot: Robot) -> None:
    with pytest.raises(RequestError, match="hz must be a number from 5 to 100"):
        watch("gamepad", **{**ARGS, "hz": 0})
    make_node("driver").advertise("/joy", "std_msgs/Float64")
    with pytest.raises(RequestError, match="/joy has the type std_msgs/Float64"):
        watch("gamepad", **ARGS)
    assert not robot.gamepads


def test_pages_that_may_not_publish(make_robot: Make, watch: Make) -> None:
    with pytest.raises(RequestError, match="read-only"):
        watch("gamepad", make_robot(read_only=True), **ARGS)
    with pytest.raises(RequestError, match="this server does not show"):
        watch("gamepad", make_robot(topics=("/a",)), **ARGS)
