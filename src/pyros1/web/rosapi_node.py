"""rosapi_node: the rosapi services, for nodes of the running system (https://wiki.ros.org/rosapi).

Clients of a rosbridge server do not need this node: `pyros1.web.rosbridge.rosapi` answers them directly.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import Error, ServiceRefusal
from pyros1.msgs import Message, Service, load_service
from pyros1.node import Node
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node
from pyros1.web.robot import Robot
from pyros1.web.rosbridge import rosapi
from pyros1.web.rosbridge.values import from_args
from pyros1.web.rosbridge_server.settings import read_patterns
from pyros1.web.server.access import Access

_TYPES = {"action_servers": "GetActionServers"}
"""Services whose type's name does not follow from the service's name."""


def service_type(name: str) -> str:
    """Return the type of a rosapi service: ``rosapi/TopicType`` for ``topic_type``."""
    return "rosapi/" + _TYPES.get(name, "".join(word.capitalize() for word in name.split("_")))


def start(node: Node) -> Robot:
    """Advertise the services; return the `Robot` that answers them until the node shuts down.

    Raises:
        UnsupportedError: a parameter with patterns is invalid.
    """
    parameters = PrivateParameters.of(node)
    access = Access(
        topics=read_patterns(parameters, "topics_glob"),
        services=read_patterns(parameters, "services_glob"),
        parameters=read_patterns(parameters, "params_glob"),
    )
    robot = Robot(node.master_uri, access, lambda: node, has_console=False)
    node.on_shutdown(robot.close)
    robot.start()
    robot.wait_for_node()
    for name in rosapi.service_names():
        cls = load_service(service_type(name))
        node.advertise_service(rosapi.PREFIX + name, cls, _make_handler(robot, name, cls))
    return robot


def _make_handler(robot: Robot, name: str, cls: type[Service]) -> Callable[[Any], Message]:
    def handle(request: Any) -> Message:
        args = {field: getattr(request, field) for field in request.__slots__}
        try:
            values = rosapi.run(robot, rosapi.PREFIX + name, args)
            return from_args(cls._response_class, values, robot.node.now())
        except Error as error:
            raise ServiceRefusal(str(error)) from error

    return handle


def main(argv: list[str]) -> int:
    """Run rosapi_node until it is shut down; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "rosapi", start)
