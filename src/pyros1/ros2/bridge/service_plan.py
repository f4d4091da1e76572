"""Plans which services a bridge to ROS 2 exchanges, given the services of both sides. No I/O.

As with topics, each side sees all services of the other side that the rules allow.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

from pyros1.bridge.exchange.services.served import LocalService
from pyros1.ground.errors import Error
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.pairs.type_pairs import ServicePair
from pyros1.ros2.zenoh.graph import Service
from pyros1.ros2.zenoh.names import DataKey, is_full_name
from pyros1.ros2.zenoh.tokens import Entity


class ServiceTypes(Protocol):
    """Finds pairs of ROS 1 and ROS 2 service types, see `pyros1.ros2.pairs.type_pairs.TypePairs`."""

    def service_for_ros1(self, type: str, md5sum: str, hash: str | None = None) -> ServicePair:
        """Return the pair of types for a ROS 1 service type."""
        ...

    def service_for_ros2(self, type: str, hash: str) -> ServicePair:
        """Return the pair of types for a ROS 2 service type."""
        ...


class OfferedService(NamedTuple):
    """A ROS 1 service that ROS 2 can call, and its type on both sides."""

    local: LocalService
    pair: ServicePair


class ProvidedService(NamedTuple):
    """A ROS 2 service that ROS 1 can call.

    Attributes:
        key: its key in ROS 2.
        pair: its type on both sides.
        node: the full name of the node that offers it.
    """

    key: DataKey
    pair: ServicePair
    node: str


@dataclass
class ServicePlan:
    """The services that a bridge exchanges.

    Attributes:
        offers: the ROS 1 services, by their keys in ROS 2.
        provides: the ROS 2 services, by name.
        problems: service -> why it is not exchanged, or not with every node.
    """

    offers: dict[DataKey, OfferedService] = field(default_factory=dict)
    provides: dict[str, ProvidedService] = field(default_factory=dict)
    problems: dict[str, str] = field(default_factory=dict)


def plan_services(
    domain: int,
    rules: Ros2Rules,
    local: Iterable[LocalService],
    taken: Mapping[str, str],
    services: Mapping[str, Service],
    offered: Collection[str],
    types: ServiceTypes,
) -> ServicePlan:
    """Return the plan for the current state of both sides.

    Args:
        domain: the ROS domain.
        rules: what may be exchanged.
        local: the ROS 1 services that nodes other than bridges provide, if their types are known.
        taken: the services that nodes other than this bridge provide in ROS 1 -> those nodes.
        services: the ROS 2 services, without bridges of the same master.
        offered: the names of the services that the bridge already offers in ROS 2.
        types: knows the types of both sides.
    """
    plan = ServicePlan()
    for each in local:
        if rules.serves(each.name):
            _offer(plan, domain, each, services.get(each.name, Service()), each.name in offered, types)
    for name in sorted(services):
        if rules.calls(name) and services[name].servers:
            _provide(plan, domain, name, services[name].servers, taken.get(name), types)
    return plan


def _offer(
    plan: ServicePlan, domain: int, local: LocalService, there: Service, is_offered: bool, types: ServiceTypes
) -> None:
    if not is_full_name(local.name):
        plan.problems[local.name] = "ROS 2 does not allow such a name"
        return
    if there.servers and not is_offered:
        # With two servers, each call would be made twice. But two bridges that offer the same service must not keep
        # giving way to each other.
        plan.problems[local.name] = _conflict(local.node, there.servers)
        return
    try:
        default = types.service_for_ros1(local.type, local.md5sum)
    except Error as error:
        plan.problems[local.name] = str(error)
        return
    pairs = {default.hash: default}
    wanted = set()
    for client in there.clients:
        if client.type != default.ros2:
            plan.problems[local.name] = f"{client.full_node_name} calls it as {client.type}, not {default.ros2}"
            continue
        try:
            if client.hash not in pairs:
                pairs[client.hash] = types.service_for_ros1(local.type, local.md5sum, client.hash)
            wanted.add(client.hash)
        except Error as error:
            plan.problems[local.name] = str(error)
    for type_hash, pair in pairs.items():
        if type_hash in wanted or not wanted:
            plan.offers[DataKey(domain, local.name, pair.ros2, type_hash)] = OfferedService(local, pair)


def _provide(
    plan: ServicePlan, domain: int, name: str, servers: Sequence[Entity], taken_by: str | None, types: ServiceTypes
) -> None:
    if taken_by is not None:
        plan.problems[name] = _conflict(taken_by, servers)
        return
    for server in servers:
        try:
            pair = types.service_for_ros2(server.type, server.hash)
        except Error as error:
            plan.problems[name] = str(error)
            continue
        provided = ProvidedService(DataKey(domain, name, server.type, server.hash), pair, server.full_node_name)
        first = plan.provides.setdefault(name, provided)
        if first.key != provided.key:
            plan.problems[name] = f"it has two types in ROS 2, or two versions of one: calls go to {first.node}"


def _conflict(node: str, servers: Sequence[Entity]) -> str:
    return f"{node} provides it in ROS 1, and {servers[0].full_node_name} in ROS 2"
