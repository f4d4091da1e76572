"""Channels and services as a running system has them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from pyros1.master.server import Master
from pyros1.msgs import AnyMsg, from_definition
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node.topic_type import topic_type
from pyros1.web.foxglove.catalogue import Catalogue
from pyros1.web.foxglove.offers import Offers
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.wire.handshake import TopicType

PAIR = "float64 a\nfloat64 b\n"
Make = Callable[..., Any]


def catalogue(robot: Robot, may_see: Callable[[str], bool] = lambda name: True) -> Catalogue:
    return Catalogue(robot.graph, may_see)


def advertise_pair(node: Any, topic: str, text: str = PAIR) -> Any:
    cls = from_definition("my_msgs/Pair", text)
    return node.advertise(topic, AnyMsg, raw_type=topic_type(cls))


def everything(one: Catalogue) -> Offers:
    while True:
        found = one.current_offers(0.0)
        if not found.has_pending_queries:
            return found
        one.query_nodes()


def test_topics_and_services(robot: Robot, make_node: Make) -> None:
    node = make_node("talker")
    publisher = node.advertise("a", Float64)
    node.subscribe("b", "sensor_msgs/Image", print)
    node.advertise_service("add", "rospy_tutorials/AddTwoInts", lambda request: 0)
    one = catalogue(robot)
    found = everything(one)
    a, b = found.channels["/a"], found.channels["/b"]
    assert (a.type, a.schema, a.md5sum) == ("std_msgs/Float64", Float64._full_text, Float64._md5sum)
    assert "MSG: std_msgs/Header" in b.schema
    add = found.services["/add"]
    assert (add.type, add.request.split(), add.response.split()) == (
        "rospy_tutorials/AddTwoInts",
        ["int64", "a", "int64", "b"],
        ["int64", "sum"],
    )
    assert found.nodes.publishers["/a"] == ["/talker"]
    assert not found.problems
    publisher.unregister()
    assert "/a" not in one.current_offers(0.0).channels
    node.advertise("a", Float64)
    again = one.current_offers(0.0)
    assert again.channels["/a"] == a  # with the same number, as it is the same
    assert one.current_offers(100.0) is again


def test_a_type_that_only_its_publisher_knows(robot: Robot, make_node: Make) -> None:
    node = make_node("talker")
    advertise_pair(node, "pair")
    one = catalogue(robot)
    assert "/pair" not in one.current_offers(0.0).channels
    found = everything(one).channels["/pair"]
    assert (found.type, found.schema) == ("my_msgs/Pair", PAIR)
    assert found.carries({"md5sum": from_definition("my_msgs/Pair", PAIR)._md5sum})


def test_a_type_that_nobody_tells_is_a_problem(robot: Robot, make_node: Make) -> None:
    node = make_node("talker")
    node.advertise("strange", AnyMsg, raw_type=TopicType("my_msgs/Strange", "0" * 32, "what is this"))
    found = everything(catalogue(robot))
    assert "/strange" not in found.channels
    assert "my_msgs/Strange" in found.problems["/strange"]


def test_another_version_of_an_installed_type(robot: Robot, make_node: Make) -> None:
    for name in ("old", "new"):
        make_node(name).advertise("a", Float64)
    one = catalogue(robot)
    ours = one.current_offers(0.0).channels["/a"]
    text = "float64 data\nfloat64 more\n"
    header = {
        "type": "std_msgs/Float64",
        "md5sum": from_definition("std_msgs/Float64", text)._md5sum,
        "message_definition": text,
        "callerid": "/old",
    }
    assert not ours.carries(header)
    one.add_header(ours, header)
    theirs = one.current_offers(100.0).channels["/a"]
    assert theirs.carries(header)
    assert (theirs.schema, theirs.id != ours.id) == (text, True)
    other = {"md5sum": Float64._md5sum, "message_definition": "float64 data", "callerid": "/new"}
    one.add_header(theirs, {**header, **other})
    assert one.current_offers(100.0).channels["/a"] == theirs
    assert "/new publishes a different" in one.current_offers(100.0).problems["/a"]
    one.add_header(theirs, {"type": "std_msgs/Float64", "md5sum": "1" * 32, "message_definition": "nonsense"})
    assert "unusable" in one.current_offers(0.0).problems["/a"]


@pytest.mark.slow
def test_of_what_publishers_say_while_nobody_looks_the_newest_is_kept(robot: Robot, make_node: Make) -> None:
    make_node("talker").advertise("a", Float64)
    one = catalogue(robot)
    channel = one.current_offers(0.0).channels["/a"]

    def header(text: str) -> dict[str, str]:
        md5sum = from_definition("std_msgs/Float64", text)._md5sum
        return {"type": "std_msgs/Float64", "md5sum": md5sum, "message_definition": text, "callerid": "/talker"}

    one.add_header(channel, header("float64 data\nint8 old"))
    for _ in range(998):
        one.add_header(replace(channel, topic="/b"), header("int8 x"))
    assert one.current_offers(100.0).channels["/a"].schema.endswith("int8 old")
    one.add_header(channel, header("float64 data\nint8 new"))
    for _ in range(1000):
        one.add_header(replace(channel, topic="/b"), header("int8 x"))
    assert one.current_offers(100.0).channels["/a"].schema.endswith("int8 old")  # there was no room for the new one


def test_a_definition_goes_with_its_publisher(robot: Robot, make_node: Make) -> None:
    """Nodes are built anew, started again, and take the places of others; the master remembers types for ever."""
    one = catalogue(robot)

    def header(text: str, who: str) -> dict[str, str]:
        md5sum = from_definition("my_msgs/Pair", text)._md5sum
        return {"type": "my_msgs/Pair", "md5sum": md5sum, "message_definition": text, "callerid": who}

    first = make_node("talker")
    advertise_pair(first, "pair")
    before = everything(one).channels["/pair"]
    first.shutdown()
    one.current_offers(0.0)
    again = make_node("talker")  # with another definition
    advertise_pair(again, "pair", "float64 a\n")
    other = make_node("other")
    advertise_pair(other, "pair", "float64 b\n")
    one.add_header(before, header("float64 a\n", "/talker"))
    one.add_header(before, header("float64 b\n", "/other"))
    found = one.current_offers(0.0)
    assert found.channels["/pair"].schema == "float64 a\n"
    assert "/other publishes a different" in found.problems["/pair"]
    again.shutdown()
    found = one.current_offers(0.0)
    assert (found.channels["/pair"].schema, found.problems) == ("float64 b\n", {})
    other.shutdown()
    make_node("third").advertise("pair", Float64)
    assert everything(one).channels["/pair"].type == "std_msgs/Float64"


def test_only_what_may_be_seen(robot: Robot, make_node: Make) -> None:
    node = make_node("talker")
    for name in ("/open/a", "/secret/b"):
        node.advertise(name, Float64)
        node.advertise_service(name, "std_srvs/Trigger", lambda request: (True, ""))
    found = everything(catalogue(robot, lambda name: name.startswith("/open")))
    assert ([*found.channels], [*found.services]) == (["/open/a"], ["/open/a"])
    assert [[*table] for table in found.nodes] == [["/open/a"], [], ["/open/a"]]


def test_without_a_master_what_was_known_is_not_given_out_as_true(
    robot: Robot, make_node: Make, master: Master
) -> None:
    make_node("talker").advertise("a", Float64)
    one = catalogue(robot)
    assert "/a" in one.current_offers(0.0).channels
    master.stop()
    for max_age in (0.0, 100.0):
        with pytest.raises(RequestError, match="master"):
            one.current_offers(max_age)
