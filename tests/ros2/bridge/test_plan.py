"""What a bridge to ROS 2 does, given the topics of both sides."""

from __future__ import annotations

from typing import Any

from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.rules.rules import Priority
from pyros1.ground.errors import UnknownTypeError
from pyros1.ros2.bridge.plan import LATCHED_DEPTH, QUEUE, Plan, make_plan
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.pairs.type_pairs import TypePair
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2.zenoh.tokens import Entity, Kind

HASHES = {"old", "new"}
VOLATILE = Qos()


class FakeTypes:
    """Types whose md5 sums and hashes say what they are."""

    def for_ros1(self, type: str, md5sum: str, definition: str, hash: str | None = None) -> TypePair:
        package, _, name = type.partition("/")
        if package == "unknown" or hash not in {None, *HASHES}:
            raise UnknownTypeError(f"no definition of {type}")
        transcoder: Any = None
        return TypePair(type, md5sum, definition, f"{package}/msg/{name}", hash or "new", transcoder)

    def for_ros2(self, type: str, hash: str, local: LocalTopic | None = None) -> TypePair:
        name = type.replace("/msg/", "/")
        if local is not None and local.type == name:
            return self.for_ros1(name, local.md5sum, local.definition, hash)
        return self.for_ros1(name, f"md5 of {name}", "text", hash)


def topic(name: str, type: str = "std_msgs/String", latched: bool = False) -> LocalTopic:
    return LocalTopic(name, type, f"md5 of {type}", "text", latched, ("/talker",))


def entity(
    name: str, type: str = "std_msgs/msg/String", hash: str = "new", node: str = "n", qos: Qos = VOLATILE
) -> Entity:
    return Entity(0, "ab", 0, 1, Kind.PUBLISHER, node, topic=name, type=type, hash=hash, qos=qos)


def plan(
    topics: list[LocalTopic],
    publishers: list[Entity] | None = None,
    subscribers: list[Entity] | None = None,
    rules: Ros2Rules | None = None,
) -> Plan:
    by_topic: list[dict[str, list[Entity]]] = []
    for entities in (publishers or [], subscribers or []):
        found: dict[str, list[Entity]] = {}
        for each in entities:
            found.setdefault(each.topic, []).append(each)
        by_topic.append(found)
    return make_plan(7, rules or Ros2Rules(), topics, by_topic[0], by_topic[1], FakeTypes())


def key(name: str, hash: str = "new", type: str = "std_msgs/msg/String") -> DataKey:
    return DataKey(7, name, type, hash)


def test_the_log_is_not_latched() -> None:
    latched = Qos(transient_local=True, depth=1000)
    made = plan([], [entity("/rosout", qos=latched), entity("/map", qos=latched)])
    assert [(name, taken.latched) for name, taken in made.takes.items()] == [("/map", True), ("/rosout", False)]
    assert made.takes["/rosout"].keys[key("/rosout")][1] == Qos(True, False, QUEUE)


def test_ros2_sees_topics_that_nobody_subscribes_to() -> None:
    made = plan([topic("/a"), topic("/map", latched=True)])
    assert {each: announced.qos for each, announced in made.announces.items()} == {
        key("/a"): Qos(True, False, QUEUE),
        key("/map"): Qos(True, True, LATCHED_DEPTH),
    }
    assert not made.subscribed_topics() and not made.problems


def test_messages_pass_where_somebody_subscribes() -> None:
    made = plan([topic("/a"), topic("/cmd_vel", "geometry_msgs/Twist")], [], [entity("/a"), entity("/other")])
    ((found, announced),) = made.subscribed_topics()["/a"]
    assert made.subscribed_topics().keys() == {"/a"} and found == key("/a")
    assert announced.routes(found) == [announced.route(found, "/talker")] == ["7/a/std_msgs::msg::dds_::String_/new"]
    assert announced.priority is Priority.NORMAL
    assert made.announces[key("/cmd_vel", type="geometry_msgs/msg/Twist")].priority is Priority.URGENT


def test_each_publisher_of_a_latched_topic_has_a_publisher_of_its_own() -> None:
    made = plan([topic("/map", latched=True)._replace(publishers=("/one", "/two"))])
    qos = Qos(True, True, LATCHED_DEPTH)
    assert made.publishers() == {
        f"7/map/std_msgs::msg::dds_::String_/new {name}": (key("/map"), qos, Priority.NORMAL)
        for name in ("/one", "/two")
    }
    made = plan([topic("/a")._replace(publishers=("/one", "/two"))])
    assert made.publishers() == {
        "7/a/std_msgs::msg::dds_::String_/new": (key("/a"), Qos(True, False, QUEUE), Priority.NORMAL)
    }


def test_subscribers_with_another_definition() -> None:
    made = plan([topic("/a")], [], [entity("/a", hash="old")])
    assert made.announces.keys() == {key("/a", "old")}
    made = plan([topic("/a")], [], [entity("/a", hash="old"), entity("/a")])
    assert made.announces.keys() == {key("/a", "old"), key("/a")} and len(made.subscribed_topics()["/a"]) == 2
    made = plan([topic("/a")], [], [entity("/a", hash="strange")])
    assert made.announces.keys() == {key("/a")} and not made.subscribed_topics()
    assert made.problems == {"/a": "/n: no definition of std_msgs/String"}


def test_subscribers_that_expect_another_type() -> None:
    made = plan([topic("/a")], [], [entity("/a", "std_msgs/msg/Int32", node="listener"), entity("/a")])
    assert made.problems == {"/a": "/listener expects std_msgs/msg/Int32, not std_msgs/msg/String"}
    assert made.subscribed_topics().keys() == {"/a"}


def test_topics_that_ros2_cannot_have() -> None:
    made = plan([topic("/a", "unknown/Type"), topic("/b__", "std_msgs/String"), topic("/1st")])
    assert made.problems["/a"] == "no definition of unknown/Type"
    assert made.problems["/1st"] == "ROS 2 does not allow such a name"


def test_ros1_sees_topics_of_ros2() -> None:
    made = plan([], [entity("/b", node="talker"), entity("/b", node="talker2")])
    taken = made.takes["/b"]
    assert taken.pair.ros1 == "std_msgs/String" and taken.publishers == ["/talker", "/talker2"] and not taken.latched
    assert made.keys_to_subscribe(set()) == {} and made.keys_to_subscribe({"/b"}) == {
        key("/b"): Qos(True, False, QUEUE)
    }


def test_a_subscriber_expects_no_more_than_all_publishers_offer() -> None:
    best_effort, latched = Qos(False, False, 5), Qos(True, True, 50)
    for order in ([best_effort, latched], [latched, best_effort]):
        made = plan([], [entity("/b", qos=qos) for qos in order])
        assert made.keys_to_subscribe({"/b"}) == {key("/b"): Qos(False, False, QUEUE)} and made.takes["/b"].latched
    made = plan([], [entity("/b", qos=latched)])
    assert made.keys_to_subscribe({"/b"}) == {key("/b"): Qos(True, True, 50)}
    made = plan([], [entity("/b", qos=Qos(True, True, 1 << 40))])
    assert made.keys_to_subscribe({"/b"}) == {key("/b"): Qos(True, True, 1000)}, "no unbounded memory"


def test_both_sides_publish() -> None:
    made = plan([topic("/a")], [entity("/a")], [entity("/a")])
    assert made.subscribed_topics().keys() == made.takes.keys() == {"/a"} and not made.problems


def test_both_sides_publish_different_types() -> None:
    made = plan([topic("/a")], [entity("/a", "std_msgs/msg/Int32")])
    assert not made.takes and key("/a") in made.announces
    assert made.problems == {"/a": "/talker publishes it as std_msgs/String, /n of ROS 2 as std_msgs/msg/Int32"}


def test_two_definitions_in_ros2() -> None:
    made = plan([], [entity("/b"), entity("/b", hash="old")])
    assert made.keys_to_subscribe({"/b"}).keys() == {key("/b"), key("/b", "old")}
    made = plan([], [entity("/b"), entity("/b", "std_msgs/msg/Int32")])
    assert made.problems == {"/b": "it has two types in ROS 2: std_msgs/msg/String and std_msgs/msg/Int32"}
    assert made.keys_to_subscribe({"/b"}).keys() == {key("/b")}


def test_rules() -> None:
    made = plan([topic("/a"), topic("/b")], [entity("/c"), entity("/d")], rules=Ros2Rules(["/a"], ["/c"]))
    assert made.announces.keys() == {key("/a")} and made.takes.keys() == {"/c"}


def test_topics_that_come_on_two_ways() -> None:
    taken: Any = None
    plan = Plan(takes={"/a": taken, "/b": taken, "/c": taken, "/rosout": taken}, problems={"/c": "another"})
    publishers = {"/a": ["/x", "/bridge_b", "/bridge_a"], "/b": ["/x"], "/c": ["/bridge_a"], "/d": ["/bridge_a"]}
    publishers["/rosout"] = ["/bridge_a"]  # its own log
    plan.add_duplicates(publishers, {"/bridge_a", "/bridge_b"})
    assert plan.problems == {
        "/a": "/bridge_a also publishes it in ROS 1, so its messages may arrive twice",
        "/c": "another",
    }
