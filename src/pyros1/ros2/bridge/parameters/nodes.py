"""Finds the ROS 2 nodes that offer parameter services. No I/O."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from pyros1.ros2.bridge.parameters.messages import EVENT_TYPE, SERVICE_TYPES
from pyros1.ros2.zenoh.graph import Service
from pyros1.ros2.zenoh.names import HUMBLE_HASH, DataKey

EVENTS = "/parameter_events"
"""The topic on which all nodes publish changes of their parameters."""


class ParameterNode(NamedTuple):
    """A ROS 2 node that has parameters.

    Attributes:
        name: its full name.
        services: last part of a service's name -> its key.
        event_key: the key of the topic on which it publishes changes.
    """

    name: str
    services: tuple[tuple[str, DataKey], ...]
    event_key: DataKey

    def key(self, service: str) -> DataKey:
        """Return the key of one of the node's services."""
        return dict(self.services)[service]


def find_nodes(
    domain: int, services: Mapping[str, Service], hashes: Mapping[str, str], event_hash: str
) -> tuple[dict[str, ParameterNode], dict[str, str]]:
    """Return the nodes by name, and, by the names of other nodes, why their parameters cannot be used.

    Args:
        domain: the ROS domain.
        services: the ROS 2 services.
        hashes: last part of a service's name -> the hash of its type.
        event_hash: the hash of the topic's type.
    """
    found: dict[str, dict[str, DataKey]] = {}
    problems: dict[str, str] = {}
    for name, service in services.items():
        node, _, last = name.rpartition("/")
        type = SERVICE_TYPES.get(last)
        if type is None or not node:
            continue
        there = [server.hash for server in service.servers if server.type == type]
        known = next((each for each in there if each in (hashes[last], HUMBLE_HASH)), None)
        if known is not None:
            found.setdefault(node, {})[last] = DataKey(domain, name, type, known)
        elif there:
            problems[node] = "its parameters cannot be used, since it has another version of rcl_interfaces"
    nodes = {}
    for node, keys in found.items():
        if keys.keys() == SERVICE_TYPES.keys():
            is_humble = any(key.hash == HUMBLE_HASH for key in keys.values())
            event_key = DataKey(domain, EVENTS, EVENT_TYPE, HUMBLE_HASH if is_humble else event_hash)
            nodes[node] = ParameterNode(node, tuple(sorted(keys.items())), event_key)
    return nodes, {node: text for node, text in problems.items() if node not in nodes}
