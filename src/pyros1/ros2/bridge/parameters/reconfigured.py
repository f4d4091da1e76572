"""Presents a ROS 2 node as a dynamic_reconfigure server in ROS 1.

A pool thread queries the node for its parameters, and the master thread then advertises them. Requests to change them
run on the service's threads, and changes made in ROS 2 arrive on the worker's thread. No thread waits while it holds
the lock.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from time import monotonic
from typing import Any

from pyros1.bridge.bridge_publishers import BRIDGE_FIELD
from pyros1.graph import Graph
from pyros1.ground.errors import Error, NodeError, ServiceRefusal
from pyros1.ground.names import FullName, is_legal_name
from pyros1.ground.terminal_text import one_line
from pyros1.msgs.dynamic_reconfigure.msg import Config as ConfigMessage
from pyros1.msgs.dynamic_reconfigure.msg import ConfigDescription
from pyros1.msgs.dynamic_reconfigure.srv import Reconfigure, ReconfigureResponse
from pyros1.node import Node
from pyros1.node.log.levels import ERROR, INFO, WARN
from pyros1.node.publishing.publisher import Publisher
from pyros1.node.services.server import ServiceServer
from pyros1.ros2.bridge.parameters.configuration import Configuration
from pyros1.ros2.bridge.parameters.messages import Event, Value
from pyros1.ros2.bridge.parameters.nodes import ParameterNode
from pyros1.ros2.bridge.parameters.parameter_client import MAX_PARAMETERS, ParameterClient
from pyros1.ros2.bridge.services import SITE

REFRESH_PAUSE = 2.0
"""Minimum seconds between queries for all parameters of a node."""
_GATHER_TIME = 0.3
"""Seconds to wait before querying a node whose set of parameters has changed: usually several change together."""
RETRY_PAUSE = 5.0
"""Seconds until a node that did not answer is queried again; doubled each time."""
_LONGEST_PAUSE = 300.0
_MAX_LINES = 10
"""Maximum number of log lines about one request."""


class ReconfiguredNode:
    """A ROS 2 node that is presented as a dynamic_reconfigure server.

    Args:
        node: the bridge's node in ROS 1.
        graph: asks the master.
        remote: the ROS 2 node.
        parameter_client: queries that node.

    Attributes:
        remote: the ROS 2 node.
        problem: why it cannot be a dynamic_reconfigure server; empty if it is one, or may become one.
    """

    def __init__(self, node: Node, graph: Graph, remote: ParameterNode, parameter_client: ParameterClient) -> None:
        self.remote = remote
        self.problem = "" if is_legal_name(remote.name) else "ROS 1 does not allow its name"
        self._node = node
        self._graph = graph
        self._parameter_client = parameter_client
        self._lock = threading.Lock()
        self._configuration: Configuration | None = None
        self._is_new = False  # whether the description must be published
        self._versions: dict[str, int] = {}  # parameter in the configuration -> the number of its last change
        self._version = 0
        self._missed: dict[str, Value | None] = {}  # changes since all parameters were requested
        self._publishers: tuple[Publisher[Any], Publisher[Any]] | None = None
        self._service: ServiceServer | None = None
        self._due: float | None = monotonic() if not self.problem else None
        self._asked_at = 0.0
        self._is_asking = False
        self._pause = RETRY_PAUSE
        self._last_logged: object = None

    # The parameters ---------------------------------------------------------------------------------------------------

    def begin(self) -> bool:
        """Return whether to query the node's parameters now; if so, `ask` must be called."""
        with self._lock:
            if self._is_asking or self._due is None or monotonic() < self._due:
                return False
            self._is_asking, self._due, self._asked_at = True, None, monotonic()
            self._missed.clear()
            return True

    def cancel_query(self) -> None:
        """Undo `begin`: the node cannot be queried now."""
        with self._lock:
            self._is_asking, self._due = False, monotonic()

    def ask(self) -> None:
        """Query all parameters of the node. This waits for it."""
        try:
            names = self._parameter_client.names(self.remote)
            descriptors = self._parameter_client.descriptors(self.remote, names)
            configuration = Configuration(descriptors, self._parameter_client.values(self.remote, names))
        except Error as error:
            with self._lock:
                self._is_asking = False
                self._due = monotonic() + self._pause
                self._pause = min(2 * self._pause, _LONGEST_PAUSE)
                self.problem = one_line(_text(error), 300) if self._configuration is None else ""
            return
        with self._lock:
            self._is_asking = False
            self._pause = RETRY_PAUSE
            self.problem = ""
            self._configuration, self._is_new = configuration, True
            self._versions = {}
            if not configuration.update(self._missed):
                self._ask_again()

    def on_event(self, event: Event) -> None:
        """Record a change made in ROS 2, and publish it."""
        with self._lock:
            configuration = self._configuration
            if event.has_others:
                self._ask_again()
            if self._is_asking:  # the answer may be older than the event
                self._missed |= event.changed
                if len(self._missed) > MAX_PARAMETERS:
                    self._missed.clear()
                    self._ask_again()
            if configuration is None:
                return
            self._version += 1
            self._versions |= dict.fromkeys(event.changed.keys() & {*configuration.names}, self._version)
            self._apply(configuration, event.changed)

    def _ask_again(self) -> None:
        """Query all parameters again soon. Called with the lock held."""
        if self._due is None and not self.problem:
            self._due = max(monotonic() + _GATHER_TIME, self._asked_at + REFRESH_PAUSE)

    def _apply(self, configuration: Configuration, values: Mapping[str, Value | None]) -> None:
        """Record values, and publish them. Called with the lock held; publishing only fills queues."""
        if not configuration.update(values):
            self._ask_again()
        if self._publishers is not None and not self._is_new:
            self._publishers[1].publish(configuration.message())

    # The ROS 1 side ---------------------------------------------------------------------------------------------------

    def adjust(self) -> None:
        """Start the server if the parameters are known, and publish a new description. This waits for the master.

        Raises:
            Error: another node already provides this server's service, or the master does not respond.
        """
        with self._lock:
            configuration = self._configuration if self._is_new else None
        if configuration is None:
            return
        self._log_left_out(configuration)
        if configuration.names:
            self._advertise()
        elif self._publishers is not None:
            self.close()
        with self._lock:
            if self._configuration is configuration:
                self._is_new = False
            if self._publishers is not None:
                self._publishers[0].publish(configuration.description())
                self._publishers[1].publish(configuration.message())

    def _advertise(self) -> None:
        name = self.remote.name
        service = f"{name}/set_parameters"
        if self._service is None and self._graph.service_uri(service) is not None:
            others = [each for each in self._graph.state().services.get(service, ()) if each != self._node.name]
            if others:
                raise NodeError(f"{others[0]} provides {service} in ROS 1 already")
        if self._publishers is None:
            headers = {BRIDGE_FIELD: SITE}
            descriptions: Publisher[Any] = self._node.advertise(
                FullName(f"{name}/parameter_descriptions"),
                ConfigDescription,
                queue_size=10,
                latch=True,
                headers=headers,
            )
            try:
                updates: Publisher[Any] = self._node.advertise(
                    FullName(f"{name}/parameter_updates"), ConfigMessage, queue_size=10, latch=True, headers=headers
                )
            except BaseException:
                descriptions.unregister()
                raise
            with self._lock:
                self._publishers = descriptions, updates
        if self._service is None:
            self._service = self._node.advertise_service(FullName(service), Reconfigure, self._on_request)

    def _log_left_out(self, configuration: Configuration) -> None:
        """Log the parameters that are left out, once."""
        left_out = configuration.left_out
        summary = len(configuration.names), left_out
        if summary != self._last_logged:
            self._last_logged = summary
            reasons = ", ".join(f"{name} ({reason})" for name, reason in left_out.items())
            self._node.log.peer_event(
                INFO,
                "dynamic_reconfigure can change %s of the %s parameters of %s%s",
                len(configuration.names),
                len(configuration.names) + len(left_out),
                self.remote.name,
                one_line(f"; not: {reasons}", 500) if left_out else "",
                link=self.remote.name,
            )

    def _on_request(self, request: Any) -> Any:
        """Set the parameters in a ROS 1 node's request. Called on a thread of the service; this waits for ROS 2.

        Raises:
            ServiceRefusal: the ROS 2 node does not respond, or its response is invalid.
        """
        with self._lock:
            configuration = self._configuration
            if configuration is None:
                raise ServiceRefusal(f"node {self.remote.name} is gone in ROS 2")
            values, problems = configuration.requested(request.config)
            version = self._version
        self._log(WARN, [f"{self.remote.name}: {problem}" for problem in problems])
        refused: Mapping[str, str] = {}
        if values:
            refused = self._parameter_client.set(self.remote, values)
            self._log(
                ERROR,
                [
                    f"{self.remote.name} of ROS 2 refuses to set {name} to {values[name]!r:.100}: {reason:.300}"
                    for name, reason in refused.items()
                ],
            )
            held = self._parameter_client.values(self.remote, [*values])
        with self._lock:
            if values:
                # Changes made by others in the meantime arrived as events, and may be newer than these values.
                news = {name: value for name, value in held.items() if self._versions.get(name, 0) <= version}
                self._version += 1
                self._apply(configuration, news)
            return ReconfigureResponse(configuration.message())

    def _log(self, level: int, lines: list[str]) -> None:
        for line in lines[:_MAX_LINES]:
            self._node.log.peer_event(level, "%s", line, link=self.remote.name)
        if len(lines) > _MAX_LINES:
            self._node.log.peer_event(level, "%s: and %s more", self.remote.name, len(lines) - _MAX_LINES)

    def close(self) -> None:
        """Stop being a server. This waits for the master."""
        service, self._service = self._service, None
        with self._lock:
            publishers, self._publishers = self._publishers, None
        if service is not None:
            service.shutdown()
        for publisher in publishers or ():
            publisher.unregister()


def _text(error: Error) -> str:
    return str(error.args[0]) if isinstance(error, ServiceRefusal) else str(error)
