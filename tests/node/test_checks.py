"""checks: what users hand to a node by mistake is refused at once, with a text that says what was meant."""

from __future__ import annotations

import re
from collections.abc import Callable
from types import ModuleType
from typing import Any

import pytest

from pyros1.errors import UnknownTypeError
from pyros1.msgs import load_message, load_service

String: Any = load_message("std_msgs/String")
Empty: Any = load_service("std_srvs/Empty")


class Foreign:
    """A class as genpy makes them."""

    _type = "std_msgs/String"
    _md5sum = "992ce8a1687cec8c8bd883ec73ca41d1"


def listen(message: Any) -> None:
    """A callback."""


MISTAKES: dict[str, tuple[Callable[[Any], Any], str]] = {
    "type": (
        lambda n: n.subscribe("t", int, listen),
        "must be a message type, not the class int; give a class, such as",
    ),
    "order": (
        lambda n: n.subscribe("t", listen, String),
        "type and callback have changed places: the order is subscribe(",
    ),
    "callback": (lambda n: n.subscribe("t", String, 5), "callback must be a function, not 5"),
    "no callback": (lambda n: n.subscribe("t", String, None), "callback must be a function, not None"),
    "class as callback": (lambda n: n.subscribe("t", "std_msgs/String", String), "not the class String"),
    "service": (lambda n: n.subscribe("t", Empty, listen), "not the class Empty; [std_srvs/Empty] is a service"),
    "message": (lambda n: n.advertise("t", String("x")), "it is a message: give its class, std_msgs/String"),
    "genpy": (lambda n: n.advertise("t", Foreign), 'it is of another library: give the name "std_msgs/String"'),
    "module": (
        lambda n: n.advertise("t", ModuleType("std_msgs.msg")),
        "not the module std_msgs.msg; give a class of it",
    ),
    "name": (lambda n: n.advertise(String, "t"), "advertise: the name must be a str, not the class String"),
    "wait": (lambda n: n.wait_for_message("t", int, 1), "wait_for_message: the type must be a message type"),
    "queue": (lambda n: n.advertise("t", String, queue_size="5"), "queue_size must be a whole number or None, not '5'"),
    "provide": (lambda n: n.advertise_service("s", Empty, 5), "handler must be a function, not 5"),
    "provide order": (lambda n: n.advertise_service("s", listen, Empty), "type and handler have changed places"),
    "provide type": (lambda n: n.advertise_service("s", String, listen), "[std_msgs/String] is a message"),
    "call": (lambda n: n.service("s", String), "service: the type must be a service type"),
    "timer": (lambda n: n.timer(1, None), "timer: callback must be a function, not None"),
    "hook": (lambda n: n.on_shutdown(5), "on_shutdown: hook must be a function, not 5"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_wrong_argument_is_refused_at_once(make_node: Any, master: Any, mistake: str) -> None:
    node = make_node("n", rosout=False)
    make, text = MISTAKES[mistake]
    with pytest.raises(TypeError, match=re.escape(text)):
        make(node)
    publishers, subscribers, services = node.master.get_system_state()
    assert not (publishers or subscribers) and not [name for name, _ in services if name in ("/s", "/t")]


def test_a_queue_size_below_zero(make_node: Any) -> None:
    node = make_node("n", rosout=False)
    with pytest.raises(ValueError, match="queue_size must be at least 0, or None, not -1"):
        node.advertise("t", String, queue_size=-1)
    with pytest.raises(ValueError, match="queue_size must be at least 1, or None, not 0"):
        node.subscribe("t", String, listen, queue_size=0)


def test_a_type_without_its_package(make_node: Any) -> None:
    node = make_node("n", rosout=False)
    with pytest.raises(UnknownTypeError, match=r"must have the form package/Type \(did you mean .*'std_msgs/String'"):
        node.advertise("t", "String")
    with pytest.raises(UnknownTypeError, match=r"\(did you mean .*'std_srvs/SetBool'"):
        node.service("s", "SetBool")


def test_publishing_after_the_end_is_passed_over_as_in_rospy(make_node: Any) -> None:
    node = make_node("n", rosout=False)
    publisher, latched = node.advertise("t", String), node.advertise("l", String, latch=True)
    node.shutdown()
    publisher.publish("x")
    latched.publish("x")


def test_an_argument_that_is_no_parameter_is_warned_of(make_node: Any, capfd: pytest.CaptureFixture[str]) -> None:
    make_node("n", rosout=False, argv=["_rate=10", "_fine:=1", "a=b", "_x"])
    lines = [line for line in capfd.readouterr().err.splitlines() if "WARN" in line]
    assert len(lines) == 1 and "'_rate=10' sets and renames nothing: write _rate:=10" in lines[0]
