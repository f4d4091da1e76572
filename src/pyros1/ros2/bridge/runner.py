"""A running bridge to ROS 2: a ROS 1 node, a session that is a ROS 2 node, and the plan between them.

A lock guards the ROS 2 graph and the plan; no thread waits while it holds the lock. The threads are:

- the node's threads convert messages and hand them to the sender (`outgoing`);
- the worker handles tokens from ROS 2, and publishes ROS 2's messages (`incoming`);
- the master thread queries the master and carries out the plan, both of which may block;
- the sender has two threads, which may block on the network;
- service calls have their own threads, see `pyros1.ros2.bridge.services`.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable

from pyros1.bridge.bridge_publishers import BridgePublishers
from pyros1.bridge.clock import steady_now
from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.link_report import LinkReport
from pyros1.bridge.local_graph import LocalGraph
from pyros1.bridge.transport.sender import Sender
from pyros1.doctor.bridge_status import STATUS_SERVICE
from pyros1.graph import Graph
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.node import Node
from pyros1.node.log.levels import INFO, WARN
from pyros1.ros2.bridge.actions.exchange import Ros2Actions
from pyros1.ros2.bridge.counts import Counts
from pyros1.ros2.bridge.incoming import IncomingMessages
from pyros1.ros2.bridge.outgoing import OutgoingMessages
from pyros1.ros2.bridge.parameters.exchange import Ros2Parameters
from pyros1.ros2.bridge.plan import Plan, make_plan
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.bridge.services import CALL_TIME, SITE, Ros2Services
from pyros1.ros2.bridge.side import Call, MakeSide
from pyros1.ros2.bridge.sources import Tokens
from pyros1.ros2.bridge.status import status_json
from pyros1.ros2.bridge.worker import Worker
from pyros1.ros2.pairs.differences import Differences
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2.zenoh.graph import Changes, Ros2Graph, Service, Topic
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.session import make_zid
from pyros1.ros2.zenoh.tokens import Entity

POLL_PERIOD = 1.0
"""Default number of seconds between polls of the master."""
ADJUST_PERIOD = 0.2
"""Seconds between checks for subscribers on either side."""
_JOIN_TIME = 3.0
_PLAN_PERIOD = 5.0
_PLAN_FACTOR = 100
"""Seconds after which the plan is recomputed even if nothing has changed: the minimum, and the multiple of the CPU time
that the last planning took, whichever is longer.
"""
_SHORTEST_PAUSE = 0.02
_LONGEST_PAUSE = 5.0
_PAUSE_FACTOR = 4
"""Seconds between plans: the minimum, the maximum, and the multiple of the CPU time that planning took, which is used
within these limits: other nodes may change the graph as often as they like.
"""
_POLL_FACTOR = 20
"""Minimum seconds between polls of the master per second of CPU time that a poll takes."""


class Ros2Bridge:
    """A running bridge. It ends when its node shuts down, or with `close`.

    Args:
        node: the bridge's node in ROS 1; it must run callbacks inline.
        ros2_name: the name of its node in ROS 2; bridges of the same master share it.
        domain: the ROS 2 domain ID.
        rules: what may be exchanged.
        types: knows the types of both sides.
        make_session: creates its session, see `pyros1.ros2.bridge.side.MakeSide`.
        call_time: maximum number of seconds for the response of a service.
        poll_period: seconds between requests to the master.
        find_name: returns the current name of its node in ROS 2, which changes if another master takes the same
            address; None if the name stays the same.

    Raises:
        LinkError: the session cannot start.
        NodeError: the node cannot provide the bridge's service.
    """

    def __init__(
        self,
        node: Node,
        ros2_name: str,
        domain: int,
        rules: Ros2Rules,
        types: TypePairs,
        make_session: MakeSide,
        call_time: float = CALL_TIME,
        poll_period: float = POLL_PERIOD,
        find_name: Callable[[], str] | None = None,
    ) -> None:
        self._node = node
        self._ros2_name = ros2_name
        self._domain = domain
        self._rules = rules
        self._types = types
        self._lock = threading.Lock()
        zid = make_zid()
        self._ros2 = Ros2Graph(domain, zid)
        self._topics: list[LocalTopic] = []
        self._plan = Plan()
        self._bridge_publishers = BridgePublishers(node, SITE)
        self._graph = LocalGraph(Graph(node.master), rules.needs_type)
        self._counts = Counts()
        self._differences = Differences()
        self._incoming = IncomingMessages(self._bridge_publishers, self._counts, self._warn)
        self._poll_period = poll_period
        self._find_name = find_name
        self._next_poll = self._next_plan = 0.0
        self._planned_from: object = None  # the state of ROS 1 when the plan was made
        self._declared: object = None  # what the session was last asked to declare
        self._refused: dict[str, str] = {}  # what it refused of `_declared` -> why
        self._problems: dict[str, str] = {}
        self._trouble: dict[str, int] = {}
        self._is_closing = False
        self._is_closed = False
        self._close_lock = threading.Lock()
        self._woken = threading.Event()
        self._ended = threading.Event()
        self._worker = Worker(
            self._take_token,
            self._take,
            self._forget_gone,
            lambda error: self._warn("cannot publish a ROS 2 message: %s", error),
            node.log.internal_error,
        )
        self._session = make_session(zid, self._worker.put_token, self._worker.put_message, self._on_call)
        self._link_report = LinkReport(self._session, (), "ROS 2")
        self._services = Ros2Services(node, self._session, domain, rules, types, self._warn, call_time)
        self._parameters = Ros2Parameters(node, domain, rules, self._session.call, self._woken.set)
        self._sender = Sender(self._session, steady_now, self._on_send_error)
        self._actions = Ros2Actions(
            node,
            domain,
            rules,
            types.actions,
            self._sender.put,
            self._session.start_call,
            call_time,
            self._warn,
            node.log.internal_error,
        )
        self._outgoing = OutgoingMessages(node, self._graph, self._sender, self._counts, self._warn)
        self._master_thread = threading.Thread(target=self._run_master_thread, name="bridge: master", daemon=True)
        self._worker.start()
        self._master_thread.start()
        node.on_shutdown(self.close)  # may call it at once, so the threads must exist
        try:
            node.advertise_service(f"~{STATUS_SERVICE}", "std_srvs/Trigger", lambda _: (True, self.status()))
            self._parameters.start()
        except BaseException:
            self.close()
            raise

    # Messages from ROS 2 ----------------------------------------------------------------------------------------------

    def _on_call(self, call: Call) -> None:
        """Pass on a call; none come before `declare`. Called on the session's threads."""
        if not self._actions.on_call(call):
            self._services.on_call(call)

    def _take_token(self, key: str, is_there: bool) -> None:
        with self._lock:
            is_changed = self._ros2.add(key) if is_there else self._ros2.remove(key)
        if is_changed:
            self._woken.set()

    def _take(self, key: DataKey, body: bytes, attachment: bytes, session: str) -> None:
        if self._actions.on_message(key, body) or self._parameters.on_message(key, body):
            return
        with self._lock:
            plan = self._plan
        self._incoming.take(plan, key, body, attachment, session)

    def _forget_gone(self, has_changed: bool) -> None:
        self._incoming.forget_gone(self._publishers_of, has_changed)

    def _publishers_of(self, topic: str) -> Tokens:
        with self._lock:
            return self._ros2.publishers(topic)

    def _warn(self, text: str, error: Exception) -> None:
        if self._node.ok() and not self._is_closing:
            self._node.log.peer_event(WARN, text, one_line(" ".join(str(error).splitlines()), 300))

    def _on_send_error(self, error: Exception) -> None:
        self._trouble["messages that could not be sent"] = self._trouble.get("messages that could not be sent", 0) + 1
        self._warn("cannot send to ROS 2: %s", error)

    # The master thread ------------------------------------------------------------------------------------------------

    def _run_master_thread(self) -> None:
        while not self._is_closing:
            self._woken.clear()
            start = time.thread_time()
            try:
                self._adjust()
            except Error as error:
                self._warn("cannot bridge: %s", error)
            except Exception as error:  # noqa: BLE001 - the session's, or a mistake of ours: neither may end the bridge
                if not self._is_closing:
                    self._node.log.internal_error(error)
            # No pause while many new ROS 1 publishers wait to be looked up.
            took = 0.0 if self._graph.is_behind else time.thread_time() - start
            self._ended.wait(min(_LONGEST_PAUSE, max(_SHORTEST_PAUSE, _PAUSE_FACTOR * took)))
            self._woken.wait(self._poll_period if self._problems else ADJUST_PERIOD)

    def _adjust(self) -> None:
        """Update the plan if necessary, and carry out what is not done yet."""
        self._counts.sample(steady_now())
        if time.monotonic() >= self._next_poll:
            self._session.look_for_routers()
            for log in self._link_report.update(steady_now()):
                self._node.log.peer_event(WARN if log.is_warning else INFO, "%s", log.text)
            self._poll()
        if self._must_plan():
            # This comes before advertising, so that no message of a topic's old type is published with its new type.
            start = time.thread_time()
            plan = self._make_plan()
            took = time.thread_time() - start
            if plan != self._plan:  # keep an equal old object: comparing identical objects is fast
                with self._lock:
                    self._plan = plan
                self._outgoing.topics = plan.subscribed_topics()
            for line in self._differences.new(plan, self._services.plan):
                self._node.log.peer_event(INFO, "%s", one_line(line, 1000))
            self._planned_from = self._ros1_state()
            self._next_plan = time.monotonic() + max(_PLAN_PERIOD, _PLAN_FACTOR * took)
        plan = self._plan
        problems = {**plan.problems, **self._services.plan.problems}
        self._incoming.adjust(plan, problems)
        self._declare(plan)
        problems.update(self._refused)
        self._outgoing.send_early()
        problems.update(self._services.adjust())
        problems.update(self._actions.adjust())
        problems.update(self._parameters.adjust())
        self._outgoing.adjust(problems)
        for topic in problems.keys() - self._problems.keys():
            self._warn(f"{one_line(topic)}: %s", Error(problems[topic]))
        self._problems = problems

    def _poll(self) -> None:
        start = time.thread_time()
        self._next_poll = time.monotonic() + self._poll_period
        try:
            if self._find_name is not None:
                self._rename(self._find_name())
            self._topics = self._graph.topics()
            self._services.poll(self._graph.state)
            self._actions.poll(self._topics, self._graph.state, self._graph.bridges)
        except Error as error:
            self._warn("cannot ask the master: %s", error)
            return
        took = time.thread_time() - start
        pause = 0.0 if self._graph.is_behind else max(self._poll_period, _POLL_FACTOR * took)
        self._next_poll = time.monotonic() + pause

    def _rename(self, name: str) -> None:
        """If the master was restarted, rename the node in ROS 2, and declare everything again under the new name."""
        if name != self._ros2_name:
            self._planned_from = self._declared = None
            # Publishers that re-register send their latched messages again only to a new subscriber.
            self._outgoing.close()
            self._session.rename(name)
            self._ros2_name = name  # set last: if anything fails, renaming is tried again

    def _must_plan(self) -> bool:
        """Return whether the plan may be out of date."""
        with self._lock:
            has_changed = self._ros2.take_changes() != Changes()
        if has_changed or self._planned_from != self._ros1_state():
            self._planned_from = None  # outdated until the plan has been made
        return self._planned_from is None or time.monotonic() >= self._next_plan

    def _ros1_state(self) -> object:
        """Return the state of ROS 1; equal states give equal plans."""
        return self._topics, self._services.ros1_state, self._actions.ros1_state

    def _declare(self, plan: Plan) -> None:
        """Tell the session what to declare, unless it has done so already."""
        subscribed = self._bridge_publishers.subscribed_topics(self._graph.bridges)
        of_actions = self._actions.publishers(), self._actions.subscribers()
        of_parameters = self._parameters.required_endpoints()
        wanted = plan, self._services.plan, subscribed, of_actions, of_parameters
        if wanted == self._declared:  # usually the same objects
            return
        self._declared = None
        is_open = self._session.session is not None
        publishers = plan.publishers()
        provided = (each.key for each in self._services.plan.provides.values())
        self._refused = self._session.declare(
            publishers | of_actions[0],
            plan.keys_to_subscribe(subscribed) | of_actions[1] | of_parameters[0],
            [*self._services.plan.offers, *self._actions.services()],
            [*provided, *self._actions.clients(), *of_parameters[1]],
        )
        if is_open:
            self._outgoing.set_publishers(publishers.keys())
            self._actions.on_declared()
            self._parameters.on_declared()
            self._declared = wanted

    def _make_plan(self) -> Plan:
        with self._lock:
            topics, services, nodes = self._ros2.topics(), self._ros2.services(), self._ros2.nodes()
        of_services = {
            name: Service(tuple(self._of_others(each.servers)), tuple(self._of_others(each.clients)))
            for name, each in services.items()
        }
        self._services.make_plan(of_services)
        publishers = {name: self._of_others(topic.publishers) for name, topic in topics.items()}
        subscribers = {name: self._of_others(topic.subscribers) for name, topic in topics.items()}
        self._actions.make_plan(
            of_services, {name: Topic(tuple(each), tuple(subscribers[name])) for name, each in publishers.items()}
        )
        self._parameters.make_plan(of_services)
        plan = make_plan(
            self._domain,
            self._rules,
            [topic for topic in self._topics if not self._actions.includes(topic.name)],
            {name: each for name, each in publishers.items() if not self._actions.includes(name)},
            subscribers,
            self._types,
        )
        plan.add_duplicates(self._graph.state.publishers, self._graph.bridges - {self._node.name})
        if others := [node.full_node_name for node in nodes if node.node_name == self._ros2_name]:
            plan.problems[others[0]] = "it is another bridge of this master, so messages arrive twice"
        return plan

    def _of_others(self, entities: Iterable[Entity]) -> list[Entity]:
        """Return the entities except those of other bridges of the same master, which would cause loops."""
        return [entity for entity in entities if entity.node_name != self._ros2_name]

    # Shutdown ---------------------------------------------------------------------------------------------------------

    def status(self) -> str:
        """Return the bridge's status as JSON, see `pyros1.ros2.bridge.status`."""
        problems = {**self._graph.problems, **self._services.problems, **self._problems}
        with self._lock:
            plan, nodes = self._plan, [node.full_node_name for node in self._ros2.nodes()]
            refused = self._ros2.refused
        subscribed = self._bridge_publishers.subscribed_topics(self._graph.bridges)
        trouble = self._trouble | ({"ROS 2 nodes and endpoints beyond the limit": refused} if refused else {})
        link_problem = self._session.problem
        if self._session.session is None:
            link_problem = link_problem or "there is none yet"
        return status_json(
            self._session.way,
            self._domain,
            plan,
            nodes,
            subscribed,
            link_problem,
            self._sender,
            problems,
            self._counts,
            self._services,
            self._actions.status(),
            trouble,
            self._worker.dropped,
        )

    def close(self) -> None:
        """End all threads. May be called repeatedly."""
        with self._close_lock:
            if self._is_closed:
                return
            self._is_closed = True
        self._is_closing = True
        self._ended.set()
        self._woken.set()
        self._worker.close()
        self._master_thread.join(_JOIN_TIME)
        self._actions.close()
        self._sender.close()
        self._session.close()
        self._services.close()
        self._parameters.close()
        if self._node.ok():  # a node that is shutting down unregisters everything itself
            self._outgoing.close()
            self._bridge_publishers.close()
