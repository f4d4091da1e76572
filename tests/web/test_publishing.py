"""Publishers that pages make."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pyros1.msgs import from_definition
from pyros1.web.publishing import IDLE_TIMEOUT, LATCHED_IDLE_TIMEOUT, PagePublishers
from pyros1.web.server.wire import RequestError

FLOAT = "std_msgs/Float64"


class Clock:
    """Seconds that pass when one says so."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def node(make_node: Callable[..., Any]) -> Any:
    return make_node("publishes")


def published(node: Any) -> list[str]:
    return sorted(name for name, _ in node.master.get_published_topics() if name != "/rosout")


def test_publishers_end_some_time_after_their_last_message(node: Any, clock: Clock) -> None:
    publishing = PagePublishers(lambda: node, clock=clock)
    for name in ("/a", "/b"):
        publishing.publish(name, FLOAT, {"data": 1.0})
    publishing.publish("/latched", FLOAT, {"data": 1.0}, latch=True)
    clock.now = IDLE_TIMEOUT - 1
    publishing.publish("/b", FLOAT, {"data": 2.0})
    publishing.clean_up()
    assert published(node) == ["/a", "/b", "/latched"]
    clock.now = IDLE_TIMEOUT + 1
    publishing.clean_up()
    assert published(node) == ["/b", "/latched"]
    clock.now = LATCHED_IDLE_TIMEOUT - 1
    publishing.clean_up()
    assert published(node) == ["/latched"]
    clock.now = LATCHED_IDLE_TIMEOUT + 1
    publishing.clean_up()
    assert published(node) == []
    publishing.publish("/a", FLOAT, {"data": 1.0})
    publishing.close()
    assert published(node) == []


def test_the_one_that_was_used_least_recently_makes_room(
    node: Any, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.web.publishing.MAX_PUBLISHERS", 4)
    publishing = PagePublishers(lambda: node, clock=clock)
    names = [f"/t{number}" for number in range(4)]
    for name in names:
        publishing.publish(name, FLOAT, {"data": 1.0})
    publishing.publish(names[0], FLOAT, {"data": 1.0})
    publishing.publish("/more", FLOAT, {"data": 1.0})
    assert set(published(node)) == {*names, "/more"} - {names[1]}
    publishing.close()


def test_a_type_with_another_definition_is_another_type(node: Any, clock: Clock) -> None:
    definition = "int32 one"
    publishing = PagePublishers(lambda: node, lambda name: from_definition(name, definition), clock)
    publishing.publish("/a", "nowhere_msgs/Thing", {"one": 1})
    definition = "int32 two"
    publishing.publish("/a", "nowhere_msgs/Thing", {"two": 1})
    publishing.close()


def test_the_first_message_reaches_all_who_are_there(make_node: Callable[..., Any], node: Any) -> None:
    listeners = [make_node(f"listener{number}") for number in range(3)]
    publishing = PagePublishers(lambda: node)
    for number in range(5):
        for listener in listeners:
            listener.subscribe(f"/first{number}", FLOAT, lambda message: None)
    assert [publishing.publish(f"/first{number}", FLOAT, {"data": 1.0}) for number in range(5)] == [3] * 5
    publishing.close()


def test_a_type_that_nobody_takes_is_refused(node: Any, make_node: Callable[..., Any], clock: Clock) -> None:
    """The master told everybody the new type, and the page that the message was sent to nobody."""
    robot = make_node("robot")
    subscriber = robot.subscribe("/vel_cmd", FLOAT, lambda message: None)
    publishing = PagePublishers(lambda: node, clock=clock)
    with pytest.raises(RequestError, match="/vel_cmd has the type std_msgs/Float64"):
        publishing.publish("/vel_cmd", "std_msgs/String", {"data": "x"})
    assert publishing.publish("/vel_cmd", FLOAT, {"data": 1.0}) == 1
    subscriber.unregister()
    publishing.unadvertise("/vel_cmd")
    assert publishing.publish("/vel_cmd", "std_msgs/String", {"data": "x"}) == 0  # it is free
    publishing.close()
