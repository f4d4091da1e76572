"""rosapi's services that describe services: their types, nodes and hosts."""

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
    return {"services": robot.access.for_services.visible_names(sorted(robot.graph.state().services))}


def _uri(robot: Robot, name: str) -> str:
    """Return a service's URI; empty if the service does not exist."""
    robot.check_service_visible(name)
    return robot.graph.service_uri(name) or ""


def _type_of(robot: Robot, name: str) -> str:
    """Return a service's type; empty if the service does not exist or its node does not respond."""
    uri = _uri(robot, name)
    try:
        return probe_service(name, uri, robot.master.caller_id, _PROBE_TIMEOUT).get("type", "") if uri else ""
    except Error:
        return ""


def _service_type(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    return {"type": _type_of(robot, args["service"])}


def _filter_by_type(robot: Robot, names: Iterable[str], type_name: str) -> list[str]:
    types = (
        run_concurrently({name: partial(_type_of, robot, name) for name in names}, _PROBE_TIMEOUT) if type_name else {}
    )
    return [name for name, actual_type in types.items() if actual_type == type_name]


def _services_for_type(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    names = robot.access.for_services.visible_names(sorted(robot.graph.state().services))
    return {"services": _filter_by_type(robot, names, args["type"])}


def _service_providers(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    """Return the nodes that provide a service, or any service with a type: clients send either a name or a type."""
    services = robot.graph.state().services
    name_or_type = args["service"]
    is_name = name_or_type in services
    access = robot.access.for_services
    names = [name_or_type] if is_name else _filter_by_type(robot, access.visible_names(services), name_or_type)
    return {"providers": list(dict.fromkeys(node for name in access.visible_names(names) for node in services[name]))}


def _service_node(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    robot.check_service_visible(args["service"])
    return {"node": next(iter(robot.graph.state().services.get(args["service"], [])), "")}


def _service_host(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    uri = _uri(robot, args["service"])
    return {"host": parse_uri(uri, "rosrpc")[0] if uri else ""}


SERVICES: Services = {
    "services": ((), _services),
    "services_for_type": (("type",), _services_for_type),
    "service_type": (("service",), _service_type),
    "service_providers": (("service",), _service_providers),
    "service_node": (("service",), _service_node),
    "service_host": (("service",), _service_host),
}
