"""Service calls through a bridge to ROS 2, in both directions: provides ROS 2 services in ROS 1, and calls ROS 1
services for clients in ROS 2.

A call from ROS 1 waits in a thread of the provided service; a call from ROS 2 is made in a pool thread. Both waits end
when the bridge closes.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from pyros1.bridge.bridge_publishers import BRIDGE_FIELD
from pyros1.bridge.exchange.services.call_packets import CallCounts
from pyros1.bridge.exchange.services.served import LocalService
from pyros1.bridge.local_graph import find_bridges
from pyros1.bridge.local_services import LocalServices
from pyros1.bridge.parameters import ROS2_SITE
from pyros1.bridge.service_ends import raw_service
from pyros1.graph import Graph, SystemState
from pyros1.ground.errors import Error, NodeError, ServiceError, ServiceRefusal
from pyros1.ground.names import FullName
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.node.services.client import ServiceClient
from pyros1.node.services.server import ServiceServer
from pyros1.node.services.workers import Workers
from pyros1.ros2.bridge.call_shares import CallShares
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.bridge.service_plan import ProvidedService, ServicePlan, ServiceTypes, plan_services
from pyros1.ros2.bridge.side import Call, Ros2Side
from pyros1.ros2.zenoh.graph import Service

SITE = ROS2_SITE
CALL_TIME = 60.0
"""Seconds to wait for a service's response, in ROS 1 and in ROS 2."""
MAX_CALLS = 128
"""Maximum number of calls from ROS 2 in progress, of which one client may have half; more are refused."""
_CLOSE_TIME = 1.0


class Ros2Services:
    """The services of a bridge.

    Args:
        node: the bridge's node in ROS 1.
        session: its session in ROS 2.
        domain: the ROS domain.
        rules: what may be called.
        types: knows the types of both sides.
        warn: logs a warning, given its text and an error, for which ``%s`` stands in the text.
        call_time: maximum number of seconds for the response of a service.
    """

    def __init__(
        self,
        node: Node,
        session: Ros2Side,
        domain: int,
        rules: Ros2Rules,
        types: ServiceTypes,
        warn: Callable[[str, Error], object],
        call_time: float = CALL_TIME,
    ) -> None:
        self.plan = ServicePlan()
        self._node = node
        self._session = session
        self._domain = domain
        self._rules = rules
        self._types = types
        self._warn = warn
        self._call_time = call_time
        self._graph = Graph(node.master)
        self._local = LocalServices(self._graph, rules.serves)
        self._services: list[LocalService] = []
        self._taken: dict[str, str] = {}
        self._provided: dict[str, tuple[ProvidedService, ServiceServer]] = {}
        self._clients: set[ServiceClient] = set()
        self._workers = Workers(f"{node.name}:call", MAX_CALLS)
        self._shares = CallShares(MAX_CALLS)
        self._counts: dict[tuple[str, str], CallCounts] = {}
        self._lock = threading.Lock()
        self._is_closing = False

    # Current state ----------------------------------------------------------------------------------------------------

    @property
    def problems(self) -> dict[str, str]:
        """Service -> why its type is not known."""
        return self._local.problems

    @property
    def ros1_state(self) -> object:
        """The state of ROS 1 at the last check; equal states give equal plans."""
        return self._services, self._taken

    def poll(self, state: SystemState) -> None:
        """Ask service providers for their types. This waits for them.

        Args:
            state: the state of the master.
        """
        self._services = self._local.services(state, find_bridges(state))
        providers = {name: nodes[0] for name, nodes in state.services.items() if nodes}
        self._taken = {name: node for name, node in providers.items() if node != self._node.name}

    def make_plan(self, services: Mapping[str, Service]) -> None:
        """Recompute the plan.

        Args:
            services: the ROS 2 services, without bridges of the same master.
        """
        offered = {key.name for key in self.plan.offers}
        plan = plan_services(self._domain, self._rules, self._services, self._taken, services, offered, self._types)
        with self._lock:
            self.plan = plan
            names = {("served", key.name) for key in plan.offers} | {("called", name) for name in plan.provides}
            self._counts = {name: counts for name, counts in self._counts.items() if name in names}

    def adjust(self) -> dict[str, str]:
        """Provide exactly the planned services in ROS 1. This waits for the master.

        Returns:
            Service -> why it could not be provided.
        """
        problems = {}
        provides = self.plan.provides
        for name, (provided, server) in [*self._provided.items()]:
            wanted = provides.get(name)
            if wanted is None or (wanted.key, wanted.pair) != (provided.key, provided.pair):
                del self._provided[name]
                server.shutdown()
        for name, provided in provides.items():
            if name not in self._provided:
                try:
                    self._provided[name] = (provided, self._provide(name, provided))
                except Error as error:
                    problems[name] = one_line(error)
        return problems

    def counts(self, kind: str, name: str) -> CallCounts:
        """Return how often a service was called.

        Args:
            kind: ``served`` for a ROS 1 service, ``called`` for a ROS 2 service.
            name: its name.
        """
        with self._lock:
            return self._counts.setdefault((kind, name), CallCounts())

    # Calls from ROS 1 -------------------------------------------------------------------------------------------------

    def _provide(self, name: str, provided: ProvidedService) -> ServiceServer:
        """Provide a ROS 2 service in ROS 1.

        Raises:
            Error: another node has begun to provide it, or the master does not respond.
        """
        if self._graph.service_uri(name) is not None:
            others = [node for node in self._graph.state().services.get(name, ()) if node != self._node.name]
            if others:
                raise NodeError(f"{others[0]} provides it in ROS 1, and {provided.node} in ROS 2")
        pair = provided.pair
        service_class = raw_service(pair.ros1, pair.md5sum, f"{pair.ros1}Request", f"{pair.ros1}Response")
        return self._node.advertise_service(FullName(name), service_class, partial(self._call_ros2, name, provided))

    def _call_ros2(self, name: str, provided: ProvidedService, request: AnyMsg) -> AnyMsg:
        """Return the response of a ROS 2 service. Called on a thread of the service.

        Raises:
            ServiceRefusal: there is none.
        """
        counts = self.counts("called", name)
        counts.calls += 1
        try:
            body = provided.pair.request.to_cdr(request._buff)
            response = self._session.call(provided.key, body, self._call_time)
            return AnyMsg(provided.pair.response.from_cdr(response))
        except Error as error:
            text = str(error.args[0]) if isinstance(error, ServiceRefusal) else one_line(error)
            counts.fail(text.encode("utf-8", "replace"))
            raise ServiceRefusal(text) from None

    # Calls from ROS 2 -------------------------------------------------------------------------------------------------

    def on_call(self, call: Call) -> None:
        """Start handling a call, which is answered later. Called on the session's threads."""
        if call.origin is None:
            self._count_failure(call.key.name, "a request without a valid attachment was dropped")
            call.drop()
        elif not self._begin(call, call.origin.gid):
            self._count_failure(call.key.name, "there were too many calls at once")
            call.fail("the bridge to ROS 1 has too many calls at once")

    def _begin(self, call: Call, client: bytes) -> bool:
        """Hand a call to the pool; return whether there was room for it."""
        if not self._shares.begin(client):
            return False

        def answer() -> None:
            try:
                self._answer(call)
            finally:
                self._shares.end(client)

        if self._workers.submit(answer):
            return True
        self._shares.end(client)
        return False

    def _count_failure(self, name: str, text: str) -> None:
        counts = self.counts("served", name)
        counts.calls += 1
        counts.fail(text.encode("utf-8", "replace"))

    def _answer(self, call: Call) -> None:
        """Call a ROS 1 service for a client in ROS 2. Called on a pool thread."""
        name = call.key.name
        try:
            call.respond(self._call_ros1(call))
            self.counts("served", name).calls += 1
        except Exception as error:  # noqa: BLE001 - the session's, the node's, or a mistake of ours: the call must end
            text = _error_text(error)
            self._count_failure(name, text)
            call.fail(text)
            if isinstance(error, Error):
                self._warn("a call from ROS 2 has failed, so it gets no response: %s", error)
            elif not self._is_closing:
                self._node.log.internal_error(error)

    def _call_ros1(self, call: Call) -> bytes:
        """Return the response of a ROS 1 service as CDR.

        Raises:
            Error: there is none, or the request or the response cannot be converted.
        """
        offered = self.plan.offers.get(call.key)
        if offered is None or self._is_closing:
            raise ServiceError(f"service [{call.key.name}] no longer exists")
        request = offered.pair.request.from_cdr(call.body)
        local = offered.local
        service_class = raw_service(local.type, local.md5sum, local.request, local.response)
        with self._node.service(FullName(local.name), service_class, headers={BRIDGE_FIELD: SITE}) as client:
            self._clients.add(client)
            try:
                response: Any = client.call(AnyMsg(request), self._call_time)
            except ServiceError as error:
                if error.answer is None:
                    self._local.check(local.name)  # its provider or type may have changed
                raise
            finally:
                self._clients.discard(client)
        return offered.pair.response.to_cdr(response._buff)

    # Shutdown ---------------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """End all calls, and stop providing services."""
        self._is_closing = True
        for client in [*self._clients]:
            client.close()
        self._workers.close(_CLOSE_TIME)
        if self._node.ok():  # a node that is shutting down unregisters everything itself
            for _, server in [*self._provided.values()]:  # a copy: the master thread may still change it
                server.shutdown()


def _error_text(error: Exception) -> str:
    """Return the text of an error for the client: the service's own error message, if there is one."""
    if isinstance(error, ServiceError) and error.answer is not None:
        return one_line(error.answer.decode("utf-8", "replace"), 300)
    return one_line(error, 300) if isinstance(error, Error) else "internal error of the bridge to ROS 1"
