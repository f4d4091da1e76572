"""Calls that find the types of services, and call services."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from time import monotonic
from typing import Any

from pyros1.doctor.concurrent import run_concurrently
from pyros1.graph import probe_service
from pyros1.msgs import load_service
from pyros1.msgs.json_form import from_json
from pyros1.web.models.forms import form as form_of
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.service_calls import ServiceCalls
from pyros1.web.views.message import tree
from pyros1.web.views.view import number_arg, string_arg

_PROBE_TIMEOUT = 2.0
_MAX_CALL_SECONDS = 600.0
_MAX_TYPES = 50


def form(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Return a service's type, and the forms for its request and response. Args: service."""
    type_name = _probe_type(robot, string_arg(args, "service"))
    cls = load_service(type_name)
    return {
        "type": type_name,
        "request": form_of(cls._request_class),
        "response": form_of(cls._response_class),
    }


def types(robot: Robot, args: Mapping[str, Any]) -> dict[str, str]:
    """Return the types of services; empty if a provider does not respond. Args: services (a list of names)."""
    names = args.get("services")
    if not isinstance(names, list) or len(names) > _MAX_TYPES or not all(isinstance(name, str) for name in names):
        raise RequestError(f"services must be a list of at most {_MAX_TYPES} names")
    responses = run_concurrently({name: partial(_probe_type, robot, name) for name in names}, _PROBE_TIMEOUT + 0.5)
    return {name: response if isinstance(response, str) else "" for name, response in responses.items()}


def call(robot: Robot, args: Mapping[str, Any], service_calls: ServiceCalls) -> dict[str, Any]:
    """Call a service; return the response as a tree, and the duration. Args: service, value, timeout (in seconds)."""
    name = string_arg(args, "service")
    robot.check_visible(name)
    cls = load_service(_probe_type(robot, name))
    request = from_json(cls._request_class, args.get("value"), robot.node.now())
    started_at = monotonic()
    response = service_calls.call(
        robot.node, name, cls, request, number_arg(args, "timeout", 0.1, _MAX_CALL_SECONDS, 10.0)
    )
    return {"value": tree(response), "seconds": monotonic() - started_at}


def _probe_type(robot: Robot, name: str) -> str:
    robot.check_visible(name)
    uri = robot.graph.service_uri(name)
    if uri is None:
        raise RequestError(f"no node provides the service {name}")
    header = probe_service(name, uri, robot.node.name, _PROBE_TIMEOUT)
    if not header.get("type"):
        raise RequestError(f"the provider of {name} does not report its type")
    return header["type"]


CALLS: dict[str, Callable[..., Any]] = {"form": form, "types": types, "call": call}
CHANGES = frozenset({"call"})
