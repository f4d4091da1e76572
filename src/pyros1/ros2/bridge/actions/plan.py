"""Plans which actions a bridge to ROS 2 exchanges, given the current state of both sides. No I/O.

An action whose type is not known here, or which both sides provide, is reported as a problem; its topics in ROS 1 are
then exchanged like any others.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.graph import SystemState
from pyros1.ground.errors import Error
from pyros1.ros2.bridge.actions.pairs import CANCEL_TYPE, STATUS_TYPE, ActionPair
from pyros1.ros2.bridge.rules import ACTION_TOPICS, Ros2Rules
from pyros1.ros2.zenoh.graph import Service, Topic
from pyros1.ros2.zenoh.names import DataKey, data_key, is_full_name
from pyros1.ros2.zenoh.tokens import Entity
from pyros1.wire.handshake import TopicType

HIDDEN = "/_action/"
"""Part of the name of each service and topic of a ROS 2 action."""
_STATUS_ARRAY = "actionlib_msgs/GoalStatusArray"
_SEND_GOAL = "_SendGoal"


class ActionTypes(Protocol):
    """Finds pairs of ROS 1 and ROS 2 action types, see `pyros1.ros2.bridge.actions.pairs.ActionPairs`."""

    def for_ros1(self, type: str, topics: Mapping[str, TopicType], hash: str | None = None) -> ActionPair:
        """Return the pair of types for a ROS 1 action type."""
        ...

    def for_ros2(self, type: str, hash: str) -> ActionPair:
        """Return the pair of types for a ROS 2 action type."""
        ...


class LocalAction(NamedTuple):
    """An action server in ROS 1.

    Attributes:
        name: the name of the action.
        type: its type, ``package/Type``.
        node: the server's node.
        topics: the types of its topics ``result`` and ``feedback``, and of ``goal`` if a client publishes it.
    """

    name: str
    type: str
    node: str
    topics: tuple[tuple[str, TopicType], ...]


class ActionKeys(NamedTuple):
    """The keys of an action in ROS 2."""

    send_goal: DataKey
    get_result: DataKey
    cancel_goal: DataKey
    feedback: DataKey
    status: DataKey

    @property
    def services(self) -> tuple[DataKey, DataKey, DataKey]:
        """The keys of the services of the action."""
        return self[:3]


class OfferedPlan(NamedTuple):
    """A ROS 1 action that ROS 2 can use."""

    local: LocalAction
    pair: ActionPair
    keys: ActionKeys


class ProvidedPlan(NamedTuple):
    """A ROS 2 action that ROS 1 can use, and the full name of its server's node."""

    name: str
    pair: ActionPair
    keys: ActionKeys
    node: str


@dataclass
class ActionPlan:
    """The actions that a bridge exchanges.

    Attributes:
        offers: the ROS 1 actions, by name.
        provides: the ROS 2 actions, by name.
        problems: action -> why it is not exchanged, or not with every node.
    """

    offers: dict[str, OfferedPlan] = field(default_factory=dict)
    provides: dict[str, ProvidedPlan] = field(default_factory=dict)
    problems: dict[str, str] = field(default_factory=dict)

    def has(self, topic: str, more: Collection[str] = ()) -> bool:
        """Return whether a ROS 1 topic belongs to an action that is exchanged, or to one of `more`."""
        name, _, last = topic.rpartition("/")
        return last in ACTION_TOPICS and (name in self.offers or name in self.provides or name in more)


def find_local_actions(
    topics: Iterable[LocalTopic], state: SystemState, bridges: Collection[str]
) -> Iterator[LocalAction]:
    """Yield the action servers in ROS 1: the nodes that have all five topics of an action, with the right types.

    Args:
        topics: what nodes other than bridges publish.
        state: the state of the master.
        bridges: the nodes that are bridges.
    """
    by_name = {topic.name: topic for topic in topics}
    for status in by_name.values():
        name = status.name.removesuffix("/status")
        result, feedback = by_name.get(f"{name}/result"), by_name.get(f"{name}/feedback")
        if status.type != _STATUS_ARRAY or name == status.name or result is None or feedback is None:
            continue
        type_name = result.type.removesuffix("ActionResult")
        if (result.type, feedback.type) != (f"{type_name}ActionResult", f"{type_name}ActionFeedback"):
            continue
        nodes = [each for each in status.publishers if each in result.publishers and each in feedback.publishers]
        for topic in ("goal", "cancel"):
            nodes = [each for each in nodes if each in state.subscribers.get(f"{name}/{topic}", ())]
        goal = by_name.get(f"{name}/goal")
        if nodes and nodes[0] not in bridges:
            found = {"result": result, "feedback": feedback}
            if goal is not None and goal.type == f"{type_name}ActionGoal":
                found["goal"] = goal
            types = {key: TopicType(each.type, each.md5sum, each.definition) for key, each in found.items()}
            yield LocalAction(name, type_name, nodes[0], (*types.items(),))


def plan_actions(
    domain: int,
    rules: Ros2Rules,
    local: Iterable[LocalAction],
    taken: Mapping[str, str],
    services: Mapping[str, Service],
    topics: Mapping[str, Topic],
    offered: Mapping[str, ActionPair],
    types: ActionTypes,
) -> ActionPlan:
    """Return the plan for the current state of both sides.

    Args:
        domain: the ROS domain.
        rules: what may be exchanged.
        local: the ROS 1 actions.
        taken: the actions whose status a node other than this bridge publishes in ROS 1 -> that node.
        services, topics: ROS 2's services and topics, without bridges of the same master.
        offered: the actions already offered, and their types.
        types: knows the types of both sides.
    """
    plan = ActionPlan()
    for each in local:
        if rules.sends(each.name):
            sender = services.get(f"{each.name}{HIDDEN}send_goal", Service())
            _offer(plan, domain, each, sender, offered.get(each.name), types)
    for service in sorted(services):
        name = service.removesuffix(f"{HIDDEN}send_goal")
        if name != service and rules.takes(name) and services[service].servers and name not in plan.offers:
            _provide(plan, domain, name, taken.get(name), services, topics, types)
    return plan


def action_keys(domain: int, name: str, pair: ActionPair) -> ActionKeys:
    """Return the keys of an action.

    Raises:
        InvalidNameError: a name is too long.
    """
    types = {
        "send_goal": f"{pair.ros2}{_SEND_GOAL}",
        "get_result": f"{pair.ros2}_GetResult",
        "cancel_goal": CANCEL_TYPE,
        "feedback": f"{pair.ros2}_FeedbackMessage",
        "status": STATUS_TYPE,
    }
    hashes = pair.hashes._asdict()
    keys = [DataKey(domain, f"{name}{HIDDEN}{part}", type_name, hashes[part]) for part, type_name in types.items()]
    for key in keys:
        data_key(key)  # raises an error if the name is too long
    return ActionKeys(*keys)


def _offer(
    plan: ActionPlan, domain: int, local: LocalAction, there: Service, offered: ActionPair | None, types: ActionTypes
) -> None:
    if not is_full_name(local.name):
        plan.problems[local.name] = "ROS 2 does not allow such a name"
        return
    if there.servers and offered is None:
        # As for services: two bridges that offer the same action must not keep giving way to each other.
        plan.problems[local.name] = _conflict(local.node, there.servers[0])
        return
    try:
        pair = types.for_ros1(local.type, dict(local.topics))
        if offered is not None and any(client.hash == offered.hashes.send_goal for client in there.clients):
            pair = types.for_ros1(local.type, dict(local.topics), offered.hashes.send_goal)
        for client in there.clients:
            if client.type != f"{pair.ros2}{_SEND_GOAL}":
                plan.problems[local.name] = f"{client.full_node_name} uses it as {client.type}, not {pair.ros2}"
            elif client.hash != pair.hashes.send_goal:
                if any(each.hash == pair.hashes.send_goal for each in there.clients):
                    plan.problems[local.name] = f"{client.full_node_name} has another version of {pair.ros2}"
                else:
                    pair = types.for_ros1(local.type, dict(local.topics), client.hash)
        plan.offers[local.name] = OfferedPlan(local, pair, action_keys(domain, local.name, pair))
    except Error as error:
        plan.problems[local.name] = str(error)


def _provide(
    plan: ActionPlan,
    domain: int,
    name: str,
    taken_by: str | None,
    services: Mapping[str, Service],
    topics: Mapping[str, Topic],
    types: ActionTypes,
) -> None:
    server = services[f"{name}{HIDDEN}send_goal"].servers[0]
    if taken_by is not None:
        plan.problems[name] = _conflict(taken_by, server)
        return
    type_name = server.type.removesuffix(_SEND_GOAL)
    if type_name == server.type or "/action/" not in type_name:
        plan.problems[name] = f"{server.type} is not the type of an action's service"
        return
    try:
        pair = types.for_ros2(type_name, server.hash)
        keys = action_keys(domain, name, pair)
    except Error as error:
        plan.problems[name] = str(error)
        return
    for key in keys:
        ends = (
            topics.get(key.name, Topic()).publishers if key in keys[3:] else services.get(key.name, Service()).servers
        )
        own = [each for each in ends if each.full_node_name == server.full_node_name]
        if not own:
            return  # the server is just starting or stopping
        if all((each.type, each.hash) != (key.type, key.hash) for each in own):
            plan.problems[name] = f"{key.name} of {server.full_node_name} has another type than {key.type} here"
            return
    plan.provides[name] = ProvidedPlan(name, pair, keys, server.full_node_name)


def _conflict(node: str, server: Entity) -> str:
    return f"{node} provides it in ROS 1, and {server.full_node_name} in ROS 2"
