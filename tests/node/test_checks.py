"""checks: what users hand to a node by mistake is refused at once, with a text that says what was meant.

Feature: errors for wrong arguments, misspelt imports, types and options suggest what was probably meant --
    immediately, where they occur
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy
import pytest

import pyros1
from pyros1.ground import errors
from pyros1.ground.errors import InvalidNameError, SerializationError, UnknownTypeError
from pyros1.ground.timing import Duration
from pyros1.msgs import load_message, load_service

Float64: Any = load_message("std_msgs/Float64")
String: Any = load_message("std_msgs/String")
Empty: Any = load_service("std_srvs/Empty")


class Foreign:
    """A class as genpy makes them."""

    _type = "std_msgs/String"
    _md5sum = "992ce8a1687cec8c8bd883ec73ca41d1"


class Typed:
    """A class of a program, that has a name of a type but is none."""

    _type = "std_msgs/String"


def listen(message: Any) -> None:
    """A callback."""


MISTAKES: dict[str, tuple[Callable[[Any], Any], str]] = {
    "type": (
        lambda n: n.subscribe("t", int, listen),
        "must be a message type, not the class int; pass a class, such as",
    ),
    "order": (
        lambda n: n.subscribe("t", listen, String),
        "type and callback are swapped: the order is subscribe(",
    ),
    "callback": (lambda n: n.subscribe("t", String, 5), "callback must be a function, not 5"),
    "no callback": (lambda n: n.subscribe("t", String, None), "callback must be a function, not None"),
    "class as callback": (lambda n: n.subscribe("t", "std_msgs/String", String), "not the class String"),
    "service": (lambda n: n.subscribe("t", Empty, listen), "not the class Empty; [std_srvs/Empty] is a service"),
    "message": (lambda n: n.advertise("t", String("x")), "it is a message: pass its class, std_msgs/String"),
    "genpy": (lambda n: n.advertise("t", Foreign), 'it is from another library: pass the name "std_msgs/String"'),
    "typed": (lambda n: n.advertise("t", Typed), "not the class Typed; pass a class, such as"),
    "module": (
        lambda n: n.advertise("t", ModuleType("std_msgs.msg")),
        "not the module std_msgs.msg; pass a class of that module",
    ),
    "name": (lambda n: n.advertise(String, "t"), "advertise: the name must be a str, not the class String"),
    "wait": (lambda n: n.wait_for_message("t", int, 1), "wait_for_message: the type must be a message type"),
    "queue": (lambda n: n.advertise("t", String, queue_size="5"), "queue_size must be a whole number or None, not '5'"),
    "provide": (lambda n: n.advertise_service("s", Empty, 5), "handler must be a function, not 5"),
    "provide order": (lambda n: n.advertise_service("s", listen, Empty), "type and handler are swapped"),
    "provide type": (lambda n: n.advertise_service("s", String, listen), "[std_msgs/String] is a message"),
    "call": (lambda n: n.service("s", String), "service: the type must be a service type"),
    "timer": (lambda n: n.timer(1, None), "timer: callback must be a function, not None"),
    "timer's period": (lambda n: n.timer("x", listen), "a timer's period must be a number of s, not 'x'"),
    "a duration": (lambda n: n.timer(Duration(1), listen), "; use its to_sec()"),
    "rate": (lambda n: n.rate("x"), "a rate must be a number of Hz, not 'x'"),
    "sleep": (lambda n: n.sleep(None), "sleep: seconds must be a number of seconds, not None"),
    "spin_once": (lambda n: n.spin_once("x"), "timeout must be a number of seconds, not 'x'"),
    "timeout of a wait": (lambda n: n.wait_for_service("s", "x"), "timeout must be a number of seconds, not 'x'"),
    "timeout of a message": (lambda n: n.wait_for_message("t", String, "x"), "timeout must be a number of"),
    "name of a wait": (lambda n: n.wait_for_service(None), "wait_for_service: the name must be a str, not None"),
    "resolve": (lambda n: n.resolve(5), "the name must be a str, not 5"),
    "parameter": (lambda n: n.params[5], "the name must be a str, not 5"),
    "search": (lambda n: n.params.search(5), "search: the name must be a str, not 5"),
    "headers": (lambda n: n.advertise("t", String, headers={"a": 5}), "headers must have strings as keys and values"),
    "no headers": (lambda n: n.service("s", Empty, headers="x"), "headers must be a dict of strings"),
    "raw type": (lambda n: n.advertise("t", String, raw_type="x"), "raw_type must be a TopicType"),
    "size": (lambda n: n.subscribe("t", String, listen, max_datagram_size="x"), "max_datagram_size must be a whole"),
    "request": (lambda n: n.service("s", Empty).call(5), "service [/s]: the request must be a EmptyRequest, not 5"),
    "timeout of a call": (
        lambda n: n.service("s", Empty).call(Empty._request_class(), "x"),
        "timeout must be a number",
    ),
    "throttle": (lambda n: n.log.info("x", throttle="x"), "throttle must be a number of seconds, not 'x'"),
    "hook": (lambda n: n.on_shutdown(5), "on_shutdown: hook must be a function, not 5"),
}


NODES: dict[str, tuple[dict[str, Any], str]] = {
    "name": ({"name": 5}, "Node: name must be a str, not 5"),
    "namespace": ({"namespace": 5}, "Node: namespace must be a str, not 5"),
    "argv": ({"argv": "_x:=1"}, "argv must be a list of strings, such as"),
    "argument": ({"argv": [1]}, "argv must contain only strings, not 1"),
    "uri": ({"master_uri": 11311}, "Node: master_uri must be a str, not 11311"),
    "environ": ({"environ": []}, "Node: environ must be a dict of environment variables, not []"),
    "patience": ({"wait_for_master": "x"}, "Node: wait_for_master must be a number of seconds, not 'x'"),
    "range": (
        {"ports": "40000-40099"},
        "Node: ports must be two port numbers, 0 for any, such as (0, 40000), not",
    ),
    "module": ({"name": numpy}, "Node: name must be a str, not the module numpy"),
    "function": ({"name": print}, "Node: name must be a str, not the function print"),
    "ports": ({"ports": 40000}, "not 40000; for a range set PYROS1_PORTS"),
    "one port": ({"ports": (0,)}, "not (0,); for a range set PYROS1_PORTS"),
    "level": ({"log_level": 1}, "a log level must be a str such as 'info', not 1"),
}


@pytest.mark.parametrize("mistake", NODES)
def test_a_node_that_cannot_be_made_says_which_argument(make_node: Any, mistake: str) -> None:
    options, text = NODES[mistake]
    with pytest.raises(TypeError, match=re.escape(text)):
        make_node(**{"name": "n", **options})


def test_wrong_messages_are_named_with_what_was_given(make_node: Any, transport: str) -> None:
    node = make_node("n", rosout=False)
    publisher = node.advertise("t", Float64)
    with pytest.raises(TypeError, match=re.escape("publish() on /t: Float64 is a class: pass a message, Float64(...)")):
        publisher.publish(Float64)  # whether or not somebody listens
    subscriber = make_node("listener", rosout=False).subscribe("t", Float64, listen)
    assert publisher.wait_for_subscribers(timeout=10)
    with pytest.raises(SerializationError, match="/t: field data must be float type, not str 'x'"):
        publisher.publish(Float64("x"))
    for wait in (publisher.wait_for_subscribers, subscriber.wait_for_publishers):
        with pytest.raises(TypeError, match="count must be a whole number, not 'x'"):
            wait("x")
        with pytest.raises(TypeError, match="timeout must be a number of seconds, not 'x'"):
            wait(2, "x")
    with pytest.raises(TypeError, match="takes an AnyMsg or its bytes, not 5"):
        node.advertise("any", pyros1.AnyMsg).publish(5)


def test_numbers_that_are_none(make_node: Any) -> None:
    node = make_node("n", rosout=False)
    for period in (0, -1, float("inf"), 1e300, float("nan")):
        with pytest.raises(ValueError, match=r"a timer's period must be above 0 and at most 1e\+09 s, not"):
            node.timer(period, listen)
    with pytest.raises(ValueError, match="seconds must be a number of seconds, not nan"):
        node.sleep(float("nan"))
    with pytest.raises(ValueError, match="a log level must be one of 1, 2, 4, 8, 16, not 'debug'"):
        node.log.level = "debug"


class Array:
    """Has `__index__`, as numpy's arrays, and refuses."""

    def __index__(self) -> int:
        raise TypeError("only integer scalar arrays can be converted to a scalar index")


def test_parameters_that_cannot_be_sent_are_named(make_node: Any) -> None:
    node = make_node("n", rosout=False)
    for value in (object(), None, {1: 2}, [{1, 2}], Array()):
        with pytest.raises(SerializationError, match=r"parameter \[/x\]: .*\. A parameter is a bool, number"):
            node.params["x"] = value
    with pytest.raises(InvalidNameError, match="subscribe: the name is empty"):
        node.subscribe("", String, listen)


@pytest.mark.parametrize("name", [name for name, value in vars(errors).items() if isinstance(value, type)])
def test_every_error_can_be_imported_from_pyros1(name: str) -> None:
    assert name in pyros1.__all__
    assert getattr(pyros1, name) is getattr(errors, name)


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
    assert len(lines) == 1 and "'_rate=10' is neither a remapping nor a parameter: write _rate:=10" in lines[0]


def test_what_behaves_as_wanted_is_taken(make_node: Any, capfd: pytest.CaptureFixture[str]) -> None:
    node = make_node("n", rosout=False, argv=(word for word in ["_rate:=10", "a:=b"]))
    assert (node.params["~rate"], node.resolve("a")) == (10, "/b")
    size: Any = numpy.int64(2000)
    node.subscribe("t", String, listen, queue_size=size, max_datagram_size=size, transports={"tcp"})
    assert node.advertise("t", String, queue_size=size).wait_for_subscribers(numpy.int64(1), 10)
    node.advertise("any", pyros1.AnyMsg).publish(array("B", [0, 0, 0, 0]))
    for _ in range(2):
        node.log.warn("once in a while", throttle=Duration(100))
    assert capfd.readouterr().err.count("once in a while") == 1
