"""The parameters of a bridge: which ROS 2 nodes it presents as dynamic_reconfigure servers, and which it queries.

`make_plan` and `adjust` are for the master thread, `on_message` for the worker; requests from
`pyros1 bridge param ros2:` run on the threads of their service.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from functools import partial
from time import monotonic

from pyros1.bridge.parameters import PARAMETER_SERVICE
from pyros1.bridge.service_ends import PARAMETERS_CLASS
from pyros1.graph import Graph
from pyros1.ground.errors import Error, ServiceRefusal
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.node.services.workers import Workers
from pyros1.ros2.bridge.parameters.nodes import EVENTS, ParameterNode, find_nodes
from pyros1.ros2.bridge.parameters.parameter_client import CALL_TIME, ParameterClient
from pyros1.ros2.bridge.parameters.reconfigured import ReconfiguredNode
from pyros1.ros2.bridge.parameters.requests import respond
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.zenoh.graph import Service
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.qos import Qos

MAX_NODES = 200
"""Maximum number of nodes presented as dynamic_reconfigure servers."""
MAX_ASKED = 50
"""Maximum number of other nodes whose service clients are kept."""
_ASKED_TIME = 60.0
"""Seconds for which a node's service clients are kept after a request for its parameters."""
_DECLARE_TIME = 3.0
_MAX_THREADS = 8
_CLOSE_TIME = 1.0
_EVENT_QOS = Qos(depth=1000)
"""The QoS that ROS 2 nodes use for this topic."""


class Ros2Parameters:
    """The parameters of a bridge.

    Args:
        node: the bridge's node in ROS 1.
        domain: the ROS domain.
        rules: which nodes to present as servers, and whose parameters may be read.
        call: calls a ROS 2 service, given its key, the encoded request and a number of seconds.
        wake: wakes the master thread, to check what it needs from ROS 2.
        call_time: seconds to wait for a node's response.
    """

    def __init__(
        self,
        node: Node,
        domain: int,
        rules: Ros2Rules,
        call: Callable[[DataKey, bytes, float], bytes],
        wake: Callable[[], object],
        call_time: float = CALL_TIME,
    ) -> None:
        self._node = node
        self._domain = domain
        self._rules = rules
        self._wake = wake
        self._parameter_client = ParameterClient(call, call_time)
        self._graph = Graph(node.master)
        self._workers = Workers(f"{node.name}:parameters", _MAX_THREADS)
        self._changed = threading.Condition()  # guards the following attributes
        self._nodes: dict[str, ParameterNode] = {}
        self._asked: dict[str, float] = {}  # node -> until when it has clients
        self._declared: frozenset[DataKey] = frozenset()
        self._is_closing = False
        self._problems: dict[str, str] = {}
        self._servers: dict[str, ReconfiguredNode] = {}  # replaced as a whole, since other threads read it
        self._gone: list[ReconfiguredNode] = []
        self._required: tuple[dict[DataKey, Qos], frozenset[DataKey]] = {}, frozenset()

    def start(self) -> None:
        """Provide the service through which ROS 1 programs read ROS 2 parameters.

        Raises:
            NodeError: the node cannot provide it.
        """
        self._node.advertise_service(f"~{PARAMETER_SERVICE}", PARAMETERS_CLASS, self._on_question)

    # Demand -----------------------------------------------------------------------------------------------------------

    def make_plan(self, services: Mapping[str, Service]) -> None:
        """Record which nodes exist, and which of them to present as servers.

        Args:
            services: the ROS 2 services, without bridges of the same master.
        """
        messages = self._parameter_client.messages
        nodes, problems = find_nodes(self._domain, services, messages.hashes, messages.event_hash)
        self._problems = {name: text for name, text in problems.items() if self._rules.reconfigures(name)}
        with self._changed:
            self._nodes = nodes
        servers: dict[str, ReconfiguredNode] = {}
        for name in sorted(filter(self._rules.reconfigures, nodes)):
            if len(servers) >= MAX_NODES:
                self._problems[name] = f"only {MAX_NODES} nodes can be servers of dynamic_reconfigure"
                continue
            known = self._servers.get(name)
            if known is not None and known.remote == nodes[name]:
                servers[name] = known
            else:
                servers[name] = ReconfiguredNode(self._node, self._graph, nodes[name], self._parameter_client)
        self._gone += [each for name, each in self._servers.items() if servers.get(name) is not each]
        self._servers = servers

    def required_endpoints(self) -> tuple[dict[DataKey, Qos], frozenset[DataKey]]:
        """Return the ROS 2 topics to subscribe to, and the ROS 2 services that need clients."""
        now = monotonic()
        with self._changed:
            self._asked = {name: until for name, until in self._asked.items() if until > now and name in self._nodes}
            asked = [self._nodes[name] for name in self._asked]
        servers = [each.remote for each in self._servers.values()]
        required = (
            {remote.event_key: _EVENT_QOS for remote in servers},
            frozenset(key for remote in (*servers, *asked) for _, key in remote.services),
        )
        if required != self._required:
            self._required = required
        return self._required

    def on_declared(self) -> None:
        """Record that the required subscriptions and clients have been declared."""
        with self._changed:
            self._declared = self._required[1]
            self._changed.notify_all()

    def adjust(self) -> dict[str, str]:
        """Start and stop servers in ROS 1 as planned, and query nodes. This waits for the master.

        Returns:
            Node -> why it has no dynamic_reconfigure server.
        """
        while self._gone:
            self._gone.pop().close()
        problems = {**self._problems}
        for name, server in self._servers.items():
            is_declared = self._declared.issuperset(key for _, key in server.remote.services)
            if is_declared and server.begin() and not self._workers.submit(partial(self._ask, server)):
                server.cancel_query()
            try:
                server.adjust()
            except Error as error:
                problems[name] = one_line(error)
            if server.problem:
                problems[name] = server.problem
        return problems

    def _ask(self, server: ReconfiguredNode) -> None:
        try:
            server.ask()
        except Exception as error:  # noqa: BLE001 - zenoh's, or a bug: the thread goes on
            if not self._is_closing:
                self._node.log.internal_error(error)
        self._wake()

    # Incoming messages ------------------------------------------------------------------------------------------------

    def on_message(self, key: DataKey, body: bytes) -> bool:
        """Handle a message if it is a parameter event, and return whether it is.

        Raises:
            MessageError: it is not valid.
        """
        if key.name != EVENTS:
            return False
        if servers := self._servers:
            event = self._parameter_client.messages.event(body)
            server = servers.get(event.node)
            if server is not None:
                server.on_event(event)
        return True

    def _on_question(self, request: AnyMsg) -> AnyMsg:
        """Answer a parameter query. Called on a thread of the service; this waits for ROS 2.

        Raises:
            ServiceRefusal: there is no answer.
        """
        with self._changed:
            nodes = {name: node for name, node in self._nodes.items() if self._rules.reads(name)}
        return AnyMsg(respond(bytes(request._buff), nodes, self._parameter_client, self._prepare))

    def _prepare(self, node: ParameterNode) -> None:
        """Wait until there are clients for a node's services.

        Raises:
            ServiceRefusal: there are none in time.
        """
        keys = {key for _, key in node.services}
        with self._changed:
            self._asked.pop(node.name, None)
            while len(self._asked) >= MAX_ASKED:
                del self._asked[next(iter(self._asked))]
            self._asked[node.name] = monotonic() + _ASKED_TIME
            if self._declared.issuperset(keys):
                return
        self._wake()
        with self._changed:
            self._changed.wait_for(lambda: self._is_closing or self._declared.issuperset(keys), _DECLARE_TIME)
            if not self._declared.issuperset(keys):
                raise ServiceRefusal("the bridge has no connection to ROS 2")

    # Shutdown ---------------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """End all waits, and withdraw everything from ROS 1. The session must be closed already."""
        with self._changed:
            self._is_closing = True
            self._changed.notify_all()
        self._workers.close(_CLOSE_TIME)
        if self._node.ok():  # a node that is shutting down unregisters everything itself
            for server in (*self._gone, *self._servers.values()):
                server.close()
