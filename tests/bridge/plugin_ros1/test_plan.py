"""What a bridge does, given what there is."""

from __future__ import annotations

from typing import Any

from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.plugin_ros1.keys import Kind, Resource
from pyros1.bridge.plugin_ros1.plan import LocalService, make_plan

from .test_rules import rules

MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"
OTHER = "0" * 32


def topic(name: str, type_name: str = "std_msgs/String", md5sum: str = MD5) -> LocalTopic:
    return LocalTopic(name, type_name, md5sum, "string data", False, ("/talker",))


def resource(name: str, kind: Kind = Kind.PUBLISHER, namespace: str = "*", **values: Any) -> Resource:
    return Resource(kind, "std_msgs/String", MD5, namespace, name)._replace(**values)


def test_topics_that_are_sent() -> None:
    plan = make_plan(rules(send="/odom /odd robot1:/cmd_vel"), map(topic, ("/odom", "/robot1/cmd_vel", "/x")), [], [])
    assert [*plan.sends] == [resource("/odom"), resource("/cmd_vel", namespace="robot1")]
    assert [sent.settings.local for sent in plan.sends.values()] == ["/odom", "/robot1/cmd_vel"]
    assert [*plan.announced(())] == [*plan.sends] and not plan.problems
    plan = make_plan(rules(send="/odd"), [topic("/odd", "Odd")], [], [])
    assert plan.sends == {} and plan.problems == {"/odd": "its type cannot be announced"}


def test_topics_that_are_taken() -> None:
    first, second = resource("/odom"), resource("/odom", namespace="robot2")
    plan = make_plan(rules(take="/odom"), [], [], [first, resource("/x"), second])
    assert [*plan.takes] == ["/odom"] and plan.takes["/odom"].sources == [first, second]
    assert plan.topics_to_receive(()) == [] and [*plan.announced(())] == []
    assert plan.topics_to_receive({"/odom"}) == [first, second]
    assert [*plan.announced({"/odom"})] == [each._replace(kind=Kind.SUBSCRIBER) for each in (first, second)]


def test_of_two_types_the_first_counts() -> None:
    first, second = resource("/odom"), resource("/odom", type="nav_msgs/Odometry", md5sum=OTHER)
    plan = make_plan(rules(take="/odom"), [], [], [first, second, resource("/odom", md5sum=OTHER)])
    assert plan.takes["/odom"].sources == [first]
    assert plan.problems == {"/odom": "others of that name are ignored, since their type is not std_msgs/String"}


def test_services() -> None:
    local = [LocalService("/set", "std_srvs/SetBool", MD5), LocalService("/own"), LocalService("/untyped")]
    there, taken_here = resource("/far", Kind.SERVICE), resource("/own", Kind.SERVICE)
    plan = make_plan(rules(serve="/set /untyped", call="/**"), [], local, [there, taken_here])
    assert plan.serves == {Resource(Kind.SERVICE, "std_srvs/SetBool", MD5, "*", "/set"): "/set"}
    assert [*plan.calls] == ["/far"] and plan.takes == {}
    assert plan.problems == {"/own": "not called elsewhere, since a node of this master provides it"}
    assert [*plan.announced(())] == [*plan.serves, there._replace(kind=Kind.CLIENT)]
