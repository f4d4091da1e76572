"""rosapi's services about services."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any

from pyros1.doctor.concurrent import run_concurrently
from pyros1.graph import probe_service
from pyros1.ground.errors import Error
from pyros1.net.hosts import parse_uri
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.rosapi import Services

_PROBE_TIMEOUT = 2.0


def _services(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    return {"services": robot.access.visible(sorted(robot.graph.state().services))}


def _uri(robot: Robot, name: str) -> str:
    """Return the address of a service; empty if it does not exist."""
    robot.check_visible(name)
    return robot.graph.service_uri(name) or ""


def _type_of(robot: Robot, name: str) -> str:
    """Return the type of a service; empty if it does not exist or its node does not respond."""
    uri = _uri(robot, name)
    try:
        return probe_service(name, uri, robot.master.caller_id, _PROBE_TIMEOUT).get("type", "") if uri else ""
    except Error:
        return ""


def _type(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    return {"type": _type_of(robot, args["service"])}


def _with_type(robot: Robot, names: Iterable[str], type_name: str) -> list[str]:
    types = (
        run_concurrently({name: partial(_type_of, robot, name) for name in names}, _PROBE_TIMEOUT) if type_name else {}
    )
    return [name for name, actual_type in types.items() if actual_type == type_name]


def _of_type(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    names = robot.access.visible(sorted(robot.graph.state().services))
    return {"services": _with_type(robot, names, args["type"])}


def _providers(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    """Return the nodes that provide a service or services of a type, since clients use both."""
    services = robot.graph.state().services
    name_or_type = args["service"]
    is_name = name_or_type in services
    names = [name_or_type] if is_name else _with_type(robot, robot.access.visible(services), name_or_type)
    return {"providers": list(dict.fromkeys(node for name in robot.access.visible(names) for node in services[name]))}


def _node(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    robot.check_visible(args["service"])
    return {"node": next(iter(robot.graph.state().services.get(args["service"], [])), "")}


def _host(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    uri = _uri(robot, args["service"])
    return {"host": parse_uri(uri, "rosrpc")[0] if uri else ""}


SERVICES: Services = {
    "services": ((), _services),
    "services_for_type": (("type",), _of_type),
    "service_type": (("service",), _type),
    "service_providers": (("service",), _providers),
    "service_node": (("service",), _node),
    "service_host": (("service",), _host),
}
