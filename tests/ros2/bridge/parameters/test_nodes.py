"""Which ROS 2 nodes have parameters."""

from __future__ import annotations

from pyros1.ros2.bridge.parameters.messages import SERVICE_TYPES
from pyros1.ros2.bridge.parameters.nodes import ParameterNode, find_nodes
from pyros1.ros2.zenoh.graph import Service
from pyros1.ros2.zenoh.names import HUMBLE_HASH, DataKey
from pyros1.ros2.zenoh.tokens import Entity, Kind

from .fake_node import EVENT_HASH, EVENTS, HASHES


def services(node: str, **other: str) -> dict[str, Service]:
    """Return the services of a node; a hash may be another one, and `type` is that of all."""
    return {
        f"{node}/{last}": Service(
            (
                Entity(
                    0,
                    "a",
                    0,
                    1,
                    Kind.SERVICE,
                    "n",
                    topic=f"{node}/{last}",
                    type=other.get("type", type),
                    hash=other.get(last, other.get("all", HASHES[last])),
                ),
            )
        )
        for last, type in SERVICE_TYPES.items()
    }


def find(there: dict[str, Service]) -> tuple[dict[str, ParameterNode], dict[str, str]]:
    return find_nodes(0, there, HASHES, EVENT_HASH)


def test_nodes() -> None:
    nodes, problems = find(services("/a/b") | services("/c") | {"/a/other": Service()})
    assert [*nodes] == ["/a/b", "/c"] and not problems
    assert nodes["/a/b"].event_key == EVENTS
    assert nodes["/a/b"].key("get_parameters") == DataKey(
        0, "/a/b/get_parameters", "rcl_interfaces/srv/GetParameters", HASHES["get_parameters"]
    )


def test_humble() -> None:
    nodes, _ = find(services("/a", all=HUMBLE_HASH))
    assert nodes["/a"].event_key.hash == nodes["/a"].key("set_parameters").hash == HUMBLE_HASH


def test_what_is_no_node_with_parameters() -> None:
    there = services("/a")
    del there["/a/set_parameters"]
    assert find(there) == ({}, {})
    clients_only = {name: Service((), each.servers) for name, each in services("/a").items()}
    assert find(clients_only) == ({}, {})
    assert find(services("/a", type="std_srvs/srv/Empty")) == ({}, {})
    assert find(services("")) == ({}, {})
    nodes, problems = find(services("/a", list_parameters="RIHS01_0"))
    assert not nodes and "another version of rcl_interfaces" in problems["/a"]
