"""rosapi's services that describe nodes and return the time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.web.robot import Robot
from pyros1.web.rosbridge.rosapi import Services


def _nodes(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    return {"nodes": sorted(robot.graph.state().nodes())}


def _node_details(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    registered = robot.graph.state().of_node(args["node"])
    return {
        "subscribing": robot.access.visible_names(registered.subscriptions),
        "publishing": robot.access.visible_names(registered.publications),
        "services": robot.access.for_services.visible_names(registered.services),
    }


def _get_time(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    now = robot.node.now()
    return {"time": {"secs": now.secs, "nsecs": now.nsecs}}


SERVICES: Services = {
    "nodes": ((), _nodes),
    "node_details": (("node",), _node_details),
    "get_time": ((), _get_time),
}
