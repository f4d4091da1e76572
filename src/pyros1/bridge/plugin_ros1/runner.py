"""A running bridge in the dialect of zenoh-plugin-ros1: a node, a zenoh session, and the state between them.

A lock guards the state; no thread blocks while it holds it. These are the threads:

- the node's threads pass messages to the state, and its packets to the sender;
- the worker handles beacons, publishes messages from elsewhere, and sends beacons;
- the master thread queries the master and carries out the plan, which may block;
- the sender has two threads, which may block on the network; service calls have their own threads.
"""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable
from functools import partial

from pyros1.bridge.bridge_publishers import BRIDGE_FIELD, BridgePublishers
from pyros1.bridge.clock import steady_now
from pyros1.bridge.exchange.actions import Advertise
from pyros1.bridge.exchange.outgoing import ReceivedMessage
from pyros1.bridge.local_graph import LocalGraph
from pyros1.bridge.plugin_ros1.arrivals import Arrivals
from pyros1.bridge.plugin_ros1.local_services import LocalServices
from pyros1.bridge.plugin_ros1.plan import Plan, TakenResource
from pyros1.bridge.plugin_ros1.rules import PluginRules
from pyros1.bridge.plugin_ros1.services import PluginServices
from pyros1.bridge.plugin_ros1.session import PluginSession
from pyros1.bridge.plugin_ros1.state import PluginState
from pyros1.bridge.plugin_ros1.status import status_json
from pyros1.bridge.transport.sender import Sender
from pyros1.doctor.bridge_status import STATUS_SERVICE
from pyros1.graph import Graph
from pyros1.ground.errors import Error, MessageError
from pyros1.ground.names import FullName
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import AnyMsg, DefinitionCache
from pyros1.node import Node
from pyros1.node.log.levels import WARN
from pyros1.node.subscribing.subscriber import Subscriber

_TICK = 0.1
"""Seconds between checks for beacons that are due or missing."""
_POLL_PERIOD = 1.0
"""Seconds between polls of the master."""
_ADJUST_PERIOD = 0.2
"""Seconds between checks of which topics have subscribers, here and elsewhere."""
_QUEUE_SIZE = 1000
_JOIN_TIME = 3.0
MakeSession = Callable[[Callable[[str], object], Callable[[str, bytes], object], Callable[..., object]], PluginSession]


class PluginBridge:
    """A running bridge. It ends when its node shuts down, or by `close`.

    Args:
        node: the bridge's node; it must run callbacks inline.
        rules: what it exchanges.
        make_session: returns its session, given the functions that handle beacons, messages and calls.

    Raises:
        LinkError: the session cannot start.
        NodeError: the node cannot provide the bridge's service.
    """

    def __init__(self, node: Node, rules: PluginRules, make_session: MakeSession) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._state = PluginState(rules, random.random)
        self._bridge_publishers = BridgePublishers(node, rules.namespace)
        graph = Graph(node.master)
        self._graph = LocalGraph(graph, lambda topic: bool(rules.sent_names(topic, self._namespaces())))
        self._local_services = LocalServices(graph, lambda name: bool(rules.served_names(name, self._namespaces())))
        self._definitions = DefinitionCache(prefer_installed=True)
        self._advertised: dict[str, tuple[str, str]] = {}  # local topic -> type and md5 sum
        self._subscribers: dict[str, Subscriber[AnyMsg]] = {}
        self._arrivals = Arrivals()
        self._arrived = threading.Condition()
        self._next_poll = 0.0
        self._problems: dict[str, str] = {}
        self._trouble: dict[str, int] = {}
        self._is_closing = False
        self._is_closed = False
        self._close_lock = threading.Lock()
        self._woken = threading.Event()
        self._session = make_session(self._on_beacon, self._on_sample, self._on_call)
        self._services = PluginServices(node, self._session, self._state.key)
        self._sender = Sender(self._session, steady_now, self._on_send_error)
        self._worker = threading.Thread(target=self._work, name="bridge: messages", daemon=True)
        self._master_thread = threading.Thread(target=self._run_master_thread, name="bridge: master", daemon=True)
        self._worker.start()
        self._master_thread.start()
        node.on_shutdown(self.close)  # may call it at once, so the threads must exist
        try:
            node.advertise_service(f"~{STATUS_SERVICE}", "std_srvs/Trigger", lambda _: (True, self.status()))
        except BaseException:
            self.close()
            raise

    def _namespaces(self) -> list[str]:
        with self._lock:
            return [resource.namespace for resource in self._state.heard.used]

    # Messages from elsewhere ------------------------------------------------------------------------------------------

    def _on_beacon(self, key: str) -> None:
        """Handle a beacon. Called on zenoh's threads."""
        with self._arrived:
            self._arrivals.put_beacon(key)
            self._arrived.notify()

    def _on_sample(self, key: str, body: bytes) -> None:
        """Handle a message. Called on zenoh's threads."""
        with self._arrived:
            self._arrivals.put_message(key, body)
            self._arrived.notify()

    def _on_call(self, key: str, query: object) -> None:
        """Pass on a call. Called on zenoh's threads."""
        self._services.on_call(key, query)

    def _work(self) -> None:
        next_tick = steady_now()
        while not self._is_closing:
            with self._arrived:
                arrival = self._arrivals.pop()
                if arrival is None:
                    self._arrived.wait(max(0.0, next_tick - steady_now()))
                    arrival = self._arrivals.pop()
            now = steady_now()
            try:
                if arrival is not None:
                    self._take(*arrival, now)
                if now >= next_tick:
                    next_tick = now + _TICK
                    with self._lock:
                        due = self._state.tick(now)
                    for packet in due:
                        self._sender.put(packet)
            except Error as error:
                self._warn("cannot publish a message: %s", error)
            except Exception as error:  # noqa: BLE001 - zenoh's, or a bug: neither may end the bridge
                if not self._is_closing:
                    self._node.log.internal_error(error)

    def _take(self, key: str, body: bytes | None, now: float) -> None:
        with self._lock:
            if body is None:
                self._state.on_beacon(key, now)
                return
            action = self._state.on_sample(key, body, now)
        if action is not None and not self._bridge_publishers.publish(action):
            self._count("messages that came before their topic was advertised")

    def _count(self, problem: str) -> None:
        self._trouble[problem] = self._trouble.get(problem, 0) + 1

    def _warn(self, text: str, error: Exception) -> None:
        if self._node.ok() and not self._is_closing:
            self._node.log.peer_event(WARN, text, one_line(error, 300))

    def _on_send_error(self, error: Exception) -> None:
        self._count("messages that could not be sent")
        self._warn("cannot send to other bridges: %s", error)

    # Messages from this master ----------------------------------------------------------------------------------------

    def _on_message(self, local: str, message: AnyMsg) -> None:
        """Send a message. Called in the node's threads."""
        header = message._connection_header or {}
        publisher, md5sum = header.get("callerid", ""), header.get("md5sum", "")
        self._graph.check_type(publisher, local, md5sum)
        received = ReceivedMessage(publisher, md5sum, header.get("latching") == "1", bytes(message._buff))
        with self._lock:
            packets = self._state.on_message(local, received, BRIDGE_FIELD in header, steady_now())
            for packet in packets:
                self._sender.put(packet)

    # The master thread ------------------------------------------------------------------------------------------------

    def _run_master_thread(self) -> None:
        while not self._is_closing:
            try:
                self._adjust()
            except Error as error:
                self._warn("cannot bridge: %s", error)
            except Exception as error:  # noqa: BLE001 - zenoh's, or a bug: neither may end the bridge
                if not self._is_closing:
                    self._node.log.internal_error(error)
            self._woken.wait(_POLL_PERIOD if self._problems else _ADJUST_PERIOD)

    def _adjust(self) -> None:
        """Carry out the parts of the plan that are not done yet."""
        if time.monotonic() >= self._next_poll:
            self._next_poll = time.monotonic() + _POLL_PERIOD
            self._poll()
        with self._lock:
            plan = self._state.plan
        problems: dict[str, str] = {}
        self._adjust_publishing(plan, problems)
        subscribed = self._bridge_publishers.subscribed_topics(self._graph.bridges)
        key = self._state.key
        self._session.declare(
            {key(resource): sent.settings.priority for resource, sent in plan.sends.items()},
            {key(source) for source in plan.topics_to_receive(subscribed)},
            {key(resource) for resource in plan.serves},
        )
        wanted_keys = self._session.keys_with_receivers()
        wanted = frozenset(resource for resource in plan.sends if key(resource) in wanted_keys)
        with self._lock:
            self._state.wanted = wanted
            if subscribed != self._state.subscribed:
                self._state.set_subscribed(subscribed, steady_now())
        self._adjust_subscribers({plan.sends[resource].local.name for resource in wanted}, problems)
        for local, error in self._services.adjust(plan.serves, plan.calls).items():
            problems[local] = one_line(error)
        for local in problems.keys() - self._problems.keys():
            self._warn(f"cannot bridge {one_line(local)}: %s", Error(problems[local]))
        self._problems = problems

    def _poll(self) -> None:
        try:
            topics, services = self._graph.topics(), self._local_services.services()
        except Error as error:
            self._warn("cannot ask the master: %s", error)
            return
        if self._graph.is_behind:
            self._next_poll = 0.0
        with self._lock:
            self._state.set_local(topics, services, steady_now())

    def _adjust_publishing(self, plan: Plan, problems: dict[str, str]) -> None:
        for local, type_ in [*self._advertised.items()]:
            taken = plan.takes.get(local)
            if taken is None or (taken.type, taken.md5sum) != type_:
                self._bridge_publishers.withdraw(local)
                del self._advertised[local]
        for local, taken in plan.takes.items():
            if local not in self._advertised:
                definition = self._definition(taken)
                try:
                    self._bridge_publishers.advertise(Advertise(local, taken.type, taken.md5sum, definition, False))
                    self._advertised[local] = (taken.type, taken.md5sum)
                except Error as error:
                    problems[local] = one_line(error)

    def _definition(self, taken: TakenResource) -> str:
        """Return the type's definition if it is installed, otherwise ``*``, as the plugin does, which sends none."""
        try:
            message_class = self._definitions.get(taken.type, taken.md5sum, "")
        except MessageError:
            return "*"
        return message_class._full_text if message_class._md5sum == taken.md5sum else "*"

    def _adjust_subscribers(self, wanted: set[str], problems: dict[str, str]) -> None:
        for local in self._subscribers.keys() - wanted:
            self._subscribers.pop(local).unregister()
        for local in wanted - self._subscribers.keys():
            try:
                self._subscribers[local] = self._node.subscribe(
                    FullName(local), AnyMsg, partial(self._on_message, local), queue_size=_QUEUE_SIZE
                )
            except Error as error:
                problems[local] = one_line(error)

    # Shutdown ---------------------------------------------------------------------------------------------------------

    def status(self) -> str:
        """Return the bridge's status as JSON, see `pyros1.bridge.plugin_ros1.status`."""
        problems = {**self._graph.problems, **self._local_services.problems, **self._problems}
        with self._lock:
            return status_json(
                self._state,
                self._session,
                self._sender,
                self._services,
                problems,
                self._trouble,
                self._arrivals.dropped,
            )

    def close(self) -> None:
        """End all threads. May be called repeatedly."""
        with self._close_lock:
            if self._is_closed:
                return
            self._is_closed = True
        self._is_closing = True
        self._woken.set()
        with self._arrived:
            self._arrived.notify_all()
        for thread in (self._worker, self._master_thread):
            thread.join(_JOIN_TIME)
        self._sender.close()
        self._session.close()
        self._services.close()
        if self._node.ok():  # a node that is shutting down unregisters everything itself
            for subscriber in self._subscribers.values():
                subscriber.unregister()
            self._bridge_publishers.close()
