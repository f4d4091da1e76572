"""Which actions a bridge to ROS 2 offers and provides."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.graph import SystemState
from pyros1.ros2.bridge.actions.plan import (
    ActionPlan,
    LocalAction,
    action_keys,
    find_local_actions,
    plan_actions,
)
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2.zenoh.graph import Service, Topic
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.tokens import Entity, Kind

FIBONACCI = "actionlib_tutorials/Fibonacci"
NAME = "/fib"
TYPES = TypePairs().actions
PAIR = TYPES.for_ros1(FIBONACCI, {})
KEYS = action_keys(0, NAME, PAIR)


def topic(name: str, type: str, *nodes: str) -> LocalTopic:
    return LocalTopic(name, type, "0" * 32, "", False, nodes or ("/server",))


def topics(**changed: LocalTopic) -> list[LocalTopic]:
    found = {
        "status": topic(f"{NAME}/status", "actionlib_msgs/GoalStatusArray"),
        "result": topic(f"{NAME}/result", f"{FIBONACCI}ActionResult"),
        "feedback": topic(f"{NAME}/feedback", f"{FIBONACCI}ActionFeedback"),
    }
    return [*(found | changed).values()]


def state(*subscribed: str) -> SystemState:
    return SystemState({}, {f"{NAME}/{each}": ["/server"] for each in subscribed}, {})


def find(topics: list[LocalTopic], state: SystemState) -> list[LocalAction]:
    return [*find_local_actions(topics, state, ())]


def test_action_servers_of_ros1() -> None:
    whole = state("goal", "cancel")
    (found,) = find(topics(), whole)
    assert (found.name, found.type, found.node) == (NAME, FIBONACCI, "/server")
    assert {name for name, _ in found.topics} == {"result", "feedback"}
    goal = topic(f"{NAME}/goal", f"{FIBONACCI}ActionGoal", "/client")
    assert {name for name, _ in find(topics(goal=goal), whole)[0].topics} == {"result", "feedback", "goal"}


@pytest.mark.parametrize(
    "changed",
    [
        {"status": topic(f"{NAME}/status", "std_msgs/String")},
        {"result": topic(f"{NAME}/result", "std_msgs/String")},
        {"feedback": topic(f"{NAME}/feedback", "other/FibonacciActionFeedback")},
        {"feedback": topic(f"{NAME}/feedback", f"{FIBONACCI}ActionFeedback", "/another")},
    ],
)
def test_topics_that_are_no_action(changed: dict[str, LocalTopic]) -> None:
    assert find(topics(**changed), state("goal", "cancel")) == []
    assert find(topics(), state("goal")) == [], "nobody would get a request to cancel"


def entity(key: DataKey, kind: Kind, **changed: Any) -> Entity:
    return Entity(0, "abc", 1, 2, kind, "peer", topic=key.name, type=key.type, hash=key.hash)._replace(**changed)


def ros2(**changed: Any) -> tuple[dict[str, Service], dict[str, Topic]]:
    """Return the services and topics of a server in ROS 2."""
    services = {key.name: Service((entity(key, Kind.SERVICE, **changed),)) for key in KEYS.services}
    return services, {key.name: Topic((entity(key, Kind.PUBLISHER),)) for key in KEYS[3:]}


def plan(
    local: list[LocalAction] | None = None,
    services: dict[str, Service] | None = None,
    topics: dict[str, Topic] | None = None,
    taken: dict[str, str] | None = None,
    rules: Ros2Rules | None = None,
    offered: Any = (),
) -> ActionPlan:
    return plan_actions(
        0, rules or Ros2Rules(), local or [], taken or {}, services or {}, topics or {}, dict(offered), TYPES
    )


LOCAL = LocalAction(NAME, FIBONACCI, "/server", ())


def test_offers() -> None:
    made = plan([LOCAL])
    assert made.offers[NAME].keys == KEYS and not made.problems
    assert made.has("/fib/goal") and not made.has("/fib/other") and not made.has("/fib")
    assert KEYS.cancel_goal == (0, "/fib/_action/cancel_goal", "action_msgs/srv/CancelGoal", PAIR.hashes.cancel_goal)
    assert not plan([LOCAL], rules=Ros2Rules(["/other"])).offers
    assert "does not allow" in plan([LOCAL._replace(name="/1st")]).problems["/1st"]
    assert "strange" in plan([LOCAL._replace(type="strange/Dance")]).problems[NAME]


def test_clients_that_expect_other_types() -> None:
    def offer(*clients: Entity, offered: Any = ()) -> ActionPlan:
        return plan([LOCAL], {KEYS.send_goal.name: Service((), clients)}, offered=offered)

    default = entity(KEYS.send_goal, Kind.CLIENT)
    humble = default._replace(hash="TypeHashNotSupported")
    assert offer(default).offers[NAME].pair == PAIR
    assert offer(humble).offers[NAME].keys.status.hash == "TypeHashNotSupported"
    both = offer(default, humble)
    assert both.offers[NAME].pair == PAIR and "has another version" in both.problems[NAME]
    for_humble = {NAME: TYPES.for_ros1(FIBONACCI, {}, "TypeHashNotSupported")}
    assert offer(default, humble, offered=for_humble).offers[NAME].pair.hashes.send_goal == "TypeHashNotSupported"
    assert "another definition" in offer(default._replace(hash="RIHS01_" + "0" * 64)).problems[NAME]
    assert "uses it as" in offer(default._replace(type="a/action/B_SendGoal")).problems[NAME]


def test_provides() -> None:
    made = plan(None, *ros2())
    assert made.provides[NAME].keys == KEYS and made.provides[NAME].node == "/peer"
    assert not plan(None, *ros2(), rules=Ros2Rules([], ["/other"])).provides
    assert plan(None, *ros2(), taken={NAME: "/node"}).problems == {
        NAME: "/node provides it in ROS 1, and /peer in ROS 2"
    }
    services, topics = ros2()
    for missing in (KEYS.get_result.name, KEYS.cancel_goal.name):
        assert not plan(None, {name: each for name, each in services.items() if name != missing}, topics).provides
    assert not plan(None, services, {}).provides
    other = services | {KEYS.get_result.name: Service((entity(KEYS.get_result, Kind.SERVICE, node_name="other"),))}
    assert not plan(None, other, topics).provides, "a server is one node"
    wrong = services | {KEYS.cancel_goal.name: Service((entity(KEYS.cancel_goal, Kind.SERVICE, hash="x"),))}
    assert "has another type" in plan(None, wrong, topics).problems[NAME]
    assert "is not the type" in plan(None, *ros2(type="std_srvs/srv/Empty")).problems[NAME]


def test_both_sides_have_it() -> None:
    made = plan([LOCAL], *ros2())
    assert not made.offers and "in ROS 1, and /peer in ROS 2" in made.problems[NAME]
    assert plan([LOCAL], *ros2(), taken={NAME: "/server"}, offered={NAME: PAIR}).offers, "it was here first"
