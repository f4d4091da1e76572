"""A site's end of service calls: services that the bridge provides on the master, and calls that it makes there.

Requests and responses stay encoded. Each call from a local node waits in its service's thread; each call from another
site is made in a pool thread. Both stop waiting when the bridge closes.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from functools import lru_cache, partial
from itertools import count
from time import monotonic

from pyros1.bridge.bridge_publishers import BRIDGE_FIELD
from pyros1.bridge.exchange.actions import Action, CallService, Provide, Return, ServiceAction, StopProviding
from pyros1.bridge.exchange.services.call_packets import encode_error
from pyros1.bridge.exchange.services.served import MAX_RUNNING, LocalService
from pyros1.bridge.exchange.site import Site
from pyros1.bridge.local_graph import find_bridges
from pyros1.bridge.local_services import LocalServices
from pyros1.bridge.parameters import PARAMETER_SERVICE, ParameterError, decode_parameter_request, respond
from pyros1.bridge.protocol.calls import Status
from pyros1.bridge.rules.rules import Rules
from pyros1.bridge.rules.services import PARAMETERS, match_served
from pyros1.graph import Graph, SystemState
from pyros1.ground.errors import Error, NodeError, NodeShutdownError, ServiceError, ServiceRefusal
from pyros1.ground.names import FullName
from pyros1.msgs import AnyMsg, Service
from pyros1.node import Node
from pyros1.node.log.levels import WARN
from pyros1.node.services.client import ServiceClient
from pyros1.node.services.server import ServiceServer
from pyros1.node.services.workers import Workers

PARAMETERS_TIMEOUT = 10.0
"""Seconds to wait for another site's parameters."""
_POLL_INTERVAL = 0.2
"""Seconds between checks, by a waiting call, of whether the bridge is closing."""
_RETRY_PERIOD = 1.0
"""Seconds between attempts to provide a service."""
_CLOSE_TIME = 1.0
Do = Callable[[Callable[[float], Iterable[Action]]], None]
"""Calls a function of the state machine with the current time, and carries out the actions that it returns."""


@lru_cache(1024)
def raw_service(type_name: str, md5sum: str, request: str, response: str) -> type[Service]:
    """Return a service class whose requests and responses stay encoded.

    Args:
        type_name, md5sum: the service's type.
        request, response: the types of its requests and responses.
    """
    parts = {
        f"_{part}_class": type(part, (AnyMsg,), {"__slots__": [], "_type": each})
        for part, each in (("request", request), ("response", response))
    }
    members = {"_type": type_name, "_md5sum": md5sum, "_full_text": "", **parts}
    return type("RawService", (Service,), members)


PARAMETERS_CLASS = raw_service(
    "pyros1_bridge/Parameters", "0" * 32, "pyros1_bridge/ParametersRequest", "pyros1_bridge/ParametersResponse"
)
"""The class of the service `PARAMETER_SERVICE`, see `pyros1.bridge.parameters`."""


class _WaitingCall:
    """A call from a local node that waits for its result."""

    def __init__(self) -> None:
        self.ended = threading.Event()
        self.status = Status.REFUSED
        self.body = b""


class ServiceEnds:
    """The bridge's end of service calls on a site's master.

    Args:
        node: the bridge's node.
        rules: the site's rules.
        site: the site's state machine; used only through `do`, or with its lock held.
        do: see `Do`; takes the lock of the state machine.
    """

    def __init__(self, node: Node, rules: Rules, site: Site, do: Do) -> None:
        self._node = node
        self._rules = rules
        self._site = site
        self._do = do
        graph = Graph(node.master)
        self._graph = graph
        self._local = LocalServices(graph, lambda name: match_served(rules, name) is not None)
        self._wanted: dict[str, Provide] = {}
        self._provided: dict[str, tuple[Provide, ServiceServer]] = {}
        self._changed: set[str] = set()  # services that may differ from what is wanted
        self._retry_at = 0.0
        self._clients: set[ServiceClient] = set()
        self._types: dict[str, LocalService] = {}
        self._workers = Workers(f"{node.name}:call", MAX_RUNNING)
        self._waiting: dict[int, _WaitingCall] = {}
        self._tokens = count(1)
        self._is_closing = False

    @property
    def problems(self) -> dict[str, str]:
        """Service -> why it cannot be served."""
        return self._local.problems

    def start(self) -> None:
        """Provide the service by which local programs read other sites' parameters.

        Raises:
            NodeError: the node cannot provide it.
        """
        self._node.advertise_service(f"~{PARAMETER_SERVICE}", PARAMETERS_CLASS, self._on_question)

    def act(self, action: ServiceAction, now: float) -> list[Action]:
        """Carry out an action of the state machine, or queue it if it may block; return the resulting actions. Called
        with the state machine's lock held.
        """
        match action:
            case Provide(local):
                self._wanted[local] = action
                self._changed.add(local)
            case StopProviding(local):
                self._wanted.pop(local, None)
                self._changed.add(local)
            case Return(token, status, body):
                if (waiting := self._waiting.get(token)) is not None:
                    waiting.status, waiting.body = status, body
                    waiting.ended.set()
            case CallService(call, local):
                if not self._workers.submit(partial(self._make_call, action, self._types.get(local))):
                    text = f"too many calls at once at site {self._rules.site}"
                    return self._site.services.served.on_result(call, Status.REFUSED, encode_error(text), now)
        return []

    # Services of other sites, provided here ---------------------------------------------------------------------------

    def poll(self, state: SystemState) -> None:
        """Record which services the master knows. This waits for providers."""
        services = self._local.services(state, find_bridges(state))
        taken = {name: nodes[0] for name, nodes in state.services.items() if nodes and nodes[0] != self._node.name}
        types = {service.name: service for service in services}

        def note(now: float) -> list[Action]:
            self._types = types
            return self._site.set_services(services, taken, now)

        self._do(note)

    def update(self) -> None:
        """Provide the wanted services. This waits for the master. Failures are retried later."""
        if not self._changed or monotonic() < self._retry_at or self._is_closing:
            return
        for local in sorted([*self._changed]):
            self._changed.discard(local)  # do this first: the service may change again meanwhile
            wanted, known = self._wanted.get(local), self._provided.get(local)
            try:
                if known is not None and known[0] is not wanted:
                    known[1].shutdown()
                    del self._provided[local]
                if wanted is not None and local not in self._provided:
                    self._provided[local] = (wanted, self._provide(wanted))
            except Error as error:
                self._changed.add(local)
                self._retry_at = monotonic() + _RETRY_PERIOD
                if self._node.ok():
                    self._node.log.peer_event(WARN, "cannot provide a service of another site: %s", error)

    def _provide(self, action: Provide) -> ServiceServer:
        """Provide a service of another site, unless another node already provides it.

        Raises:
            Error: another node provides it, or the master does not respond.
        """
        local = action.local
        if self._graph.service_uri(local) is not None:
            others = [node for node in self._graph.state().services.get(local, ()) if node != self._node.name]
            if others:
                raise NodeError(f"{others[0]} already provides {local} here")
        service_class = raw_service(*action[1:])
        return self._node.advertise_service(FullName(local), service_class, partial(self._on_request, local))

    def _on_request(self, local: str, request: AnyMsg) -> AnyMsg:
        """Call a service of another site, and wait for the result. Called in the service's thread."""
        body = bytes(request._buff)
        return self._wait(lambda token, now: self._site.services.calls.call(token, local, body, now))

    def _on_question(self, request: AnyMsg) -> AnyMsg:
        body = bytes(request._buff)
        try:
            site = decode_parameter_request(body).site
        except ParameterError as error:
            raise ServiceRefusal(str(error)) from None
        return self._wait(
            lambda token, now: self._site.services.calls.ask_parameters(token, site, body, PARAMETERS_TIMEOUT, now)
        )

    def _wait(self, call: Callable[[int, float], list[Action]]) -> AnyMsg:
        token, waiting = next(self._tokens), _WaitingCall()
        self._waiting[token] = waiting
        try:
            self._do(partial(call, token))
            while not waiting.ended.wait(_POLL_INTERVAL):
                if self._is_closing or not self._node.ok():
                    raise ServiceRefusal(f"the bridge of site {self._rules.site} has ended")
        finally:
            del self._waiting[token]
        if waiting.status is Status.OK:
            return AnyMsg(waiting.body)
        raise ServiceRefusal(waiting.body.decode("utf-8", "replace"))

    # Services of this site, called for others -------------------------------------------------------------------------

    def _make_call(self, action: CallService, service: LocalService | None) -> None:
        status, body = Status.OK, b""
        try:
            if action.local == PARAMETERS:
                body = respond(self._rules, self._node.master, action.body)
            elif service is None:
                raise ServiceError(f"service [{action.local}] no longer exists")
            else:
                body = self._call_service(action, service)
        except NodeShutdownError:
            return  # the call may have been carried out, as the other site says when it hears that this one leaves
        except ServiceRefusal as error:
            status, body = Status.FAILED, encode_error(str(error.args[0]))
        except ServiceError as error:
            if error.answer is not None:
                status, body = Status.FAILED, error.answer
            else:
                status, body = Status.REFUSED, encode_error(str(error))
                self._local.check(action.local)
        except Error as error:
            status, body = Status.REFUSED, encode_error(str(error))
        except Exception as error:  # noqa: BLE001 - a bug must not leave the caller without a result
            self._node.log.internal_error(error)
            status, body = Status.REFUSED, encode_error(f"internal error at site {self._rules.site}")
        self._do(lambda now: self._site.services.served.on_result(action.call, status, body, now))

    def _call_service(self, action: CallService, service: LocalService) -> bytes:
        service_class = raw_service(*service[1:5])
        headers = {BRIDGE_FIELD: self._rules.site}
        with self._node.service(FullName(action.local), service_class, headers=headers) as client:
            self._clients.add(client)
            try:
                return bytes(client.call(AnyMsg(action.body), action.timeout)._buff)
            finally:
                self._clients.discard(client)

    # Shutdown ---------------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """End all calls, and stop providing services."""
        self._is_closing = True
        for client in [*self._clients]:
            client.close()
        self._workers.close(_CLOSE_TIME)
        if self._node.ok():  # a node that is shutting down unregisters everything itself
            for _, server in self._provided.values():
                server.shutdown()
