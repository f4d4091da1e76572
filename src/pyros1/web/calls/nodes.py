"""Calls that describe nodes, shut them down, and set their log levels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.ground.errors import Error, ServiceError
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.view import string_arg

_TIMEOUT = 3.0


def info(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Return a node's topics, services, process id and connections. Args: node."""
    name = string_arg(args, "node")
    uri = _find_uri(robot, name)
    registered = robot.graph.state().of_node(name)
    details: dict[str, Any] = {
        "name": name,
        "uri": uri,
        "publishes": robot.access.visible_names(registered.publications),
        "subscribes": robot.access.visible_names(registered.subscriptions),
        "services": robot.access.visible_names(registered.services),
    }
    node = robot.graph.node_api(uri, _TIMEOUT)
    try:
        details["pid"] = node.pid()
        details["connections"] = [
            {"topic": link.topic, "peer": link.destination, "direction": link.direction, "transport": link.transport}
            for link in node.connections()
            if robot.access.may_see(link.topic)
        ]
    except Error as error:
        details["problem"] = str(error)
    finally:
        node.close()
    return details


def kill(robot: Robot, args: Mapping[str, Any]) -> None:
    """Tell a node to shut down, like `rosnode kill`. Args: node."""
    name = string_arg(args, "node")
    if name == robot.node.name:
        raise RequestError(
            f"{name} belongs to this page's server: to stop it, press Ctrl-C in the terminal where `pyros1 web` runs"
        )
    node = robot.graph.node_api(_find_uri(robot, name), _TIMEOUT)
    try:
        node.shutdown("user request")
    finally:
        node.close()


def loggers(robot: Robot, args: Mapping[str, Any]) -> list[list[str]]:
    """Return the names and levels of a node's loggers. Args: node."""
    response = _call_logger_service(robot, string_arg(args, "node"), "get_loggers", "roscpp/GetLoggers", {})
    return [[logger.name, logger.level.lower()] for logger in response.loggers]


def set_level(robot: Robot, args: Mapping[str, Any]) -> None:
    """Set the level of a node's logger. Args: node, logger, level (debug, info, warn, error or fatal)."""
    level = string_arg(args, "level")
    if level not in ("debug", "info", "warn", "error", "fatal"):
        raise RequestError(f"unknown level {level[:50]!r}")
    request = {"logger": string_arg(args, "logger"), "level": level}
    _call_logger_service(robot, string_arg(args, "node"), "set_logger_level", "roscpp/SetLoggerLevel", request)


def _find_uri(robot: Robot, name: str) -> str:
    uri = robot.graph.node_uri(name)
    if uri is None:
        raise RequestError(f"there is no node {name}")
    return uri


def _call_logger_service(robot: Robot, node: str, service: str, type_name: str, request: dict[str, str]) -> Any:
    robot.check_visible(f"{node}/{service}")
    with robot.node.service(f"{node}/{service}", type_name) as client:
        try:
            return client.call(client.type._request_class(**request), _TIMEOUT)
        except ServiceError as error:
            raise RequestError(f"the logger levels of {node} cannot be changed: {error}") from None


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {
    "info": info,
    "kill": kill,
    "loggers": loggers,
    "set_level": set_level,
}
CHANGES = frozenset({"kill", "set_level"})
