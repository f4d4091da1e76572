"""The actions of a bridge to ROS 2: starts and stops them as planned, and runs the thread that handles goals."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from functools import partial

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.rules.rules import Priority
from pyros1.graph import SystemState
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.node import Node
from pyros1.ros2.bridge.actions.inbox import Inbox
from pyros1.ros2.bridge.actions.offered import FEEDBACK_QOS, STATUS_QOS, OfferedAction, Warn
from pyros1.ros2.bridge.actions.plan import (
    HIDDEN,
    ActionPlan,
    ActionTypes,
    LocalAction,
    find_local_actions,
    plan_actions,
)
from pyros1.ros2.bridge.actions.provided import ProvidedAction, StartCall
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.bridge.side import Call
from pyros1.ros2.zenoh.graph import Service, Topic
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.qos import Qos

TICK = 0.1
"""Seconds between checks for steps that are due."""
LINGER = 5.0
"""Seconds for which an action stays in ROS 1 after its server in ROS 2 is gone, so that clients get the last
statuses, and keep their connections if the server starts again.
"""
_CLOSE_TIME = 1.0


class Ros2Actions:
    """The actions of a bridge.

    Args:
        node: the bridge's node in ROS 1.
        domain: the ROS domain.
        rules: what may be exchanged.
        types: knows the types of both sides.
        send: sends a message to ROS 2.
        start_call: calls a ROS 2 service.
        call_time: maximum number of seconds for the response to a goal, or to a cancel request.
        warn: logs a warning, given its text and an error, for which ``%s`` stands in the text.
        on_error: called with an exception that a bug in pyros1 raised.

    Attributes:
        plan: the actions to exchange.
    """

    def __init__(
        self,
        node: Node,
        domain: int,
        rules: Ros2Rules,
        types: ActionTypes,
        send: Callable[[Send], object],
        start_call: StartCall,
        call_time: float,
        warn: Warn,
        on_error: Callable[[Exception], object],
    ) -> None:
        self.plan = ActionPlan()
        self._node = node
        self._domain = domain
        self._rules = rules
        self._types = types
        self._send = send
        self._start_call = start_call
        self._call_time = call_time
        self._warn = warn
        self._on_error = on_error
        self._local: list[LocalAction] = []
        self._taken: dict[str, str] = {}
        self._offered: dict[str, OfferedAction] = {}
        self._provided: dict[str, ProvidedAction] = {}
        self._by_key: dict[DataKey, OfferedAction | ProvidedAction] = {}
        self._inbox = Inbox()
        self._thread = threading.Thread(target=self._run, name="bridge: actions", daemon=True)
        self._is_closing = False
        self._thread.start()

    # Current state ----------------------------------------------------------------------------------------------------

    @property
    def ros1_state(self) -> object:
        """The state of ROS 1 at the last check; equal states give equal plans."""
        return self._local, self._taken

    def poll(self, topics: list[LocalTopic], state: SystemState, bridges: frozenset[str]) -> None:
        """Find the action servers in ROS 1.

        Args:
            topics: what nodes other than bridges publish.
            state: the state of the master.
            bridges: the nodes that are bridges.
        """
        self._local = [*find_local_actions(topics, state, bridges)]
        self._taken = {
            topic.removesuffix("/status"): others[0]
            for topic, nodes in state.publishers.items()
            if topic.endswith("/status") and (others := [each for each in nodes if each != self._node.name])
        }

    def make_plan(self, services: Mapping[str, Service], topics: Mapping[str, Topic]) -> None:
        """Recompute the plan from the state of ROS 2, which excludes bridges of the same master."""
        offered = {name: each.plan.pair for name, each in self._offered.items()}
        self.plan = plan_actions(
            self._domain, self._rules, self._local, self._taken, services, topics, offered, self._types
        )

    def includes(self, topic: str) -> bool:
        """Return whether a topic on either side belongs to an action, and so is not exchanged as a topic."""
        return HIDDEN in topic or self.plan.has(topic, self._provided)

    def adjust(self) -> dict[str, str]:
        """Start the planned actions in ROS 1, and stop the others. This waits for the master.

        Returns:
            Action -> why it cannot be exchanged.
        """
        problems = dict(self.plan.problems)
        for name, offered in [*self._offered.items()]:
            wanted = self.plan.offers.get(name)
            if wanted is None or (wanted.local.node, wanted.keys) != (offered.plan.local.node, offered.plan.keys):
                del self._offered[name]
                self._inbox.put(offered.on_lost, 0, is_due=True)
                offered.close()
        for name, provided in [*self._provided.items()]:
            self._adjust_provided(name, provided)
        for name, to_offer in self.plan.offers.items():
            if name not in self._offered:
                try:
                    self._offered[name] = OfferedAction(self._node, to_offer, self._send, self._inbox, self._warn)
                except Error as error:
                    problems[name] = one_line(error)
        for name, to_provide in self.plan.provides.items():
            if name not in self._provided:
                try:
                    self._provided[name] = ProvidedAction(
                        self._node, to_provide, self._start_call, self._call_time, self._inbox, self._warn
                    )
                except Error as error:
                    problems[name] = one_line(error)
        self._by_key = {key: each for each in self._offered.values() for key in each.plan.keys.services} | {
            key: each for each in self._provided.values() for key in each.subscribers
        }
        return problems

    def _adjust_provided(self, name: str, provided: ProvidedAction) -> None:
        wanted = self.plan.provides.get(name)
        now = time.monotonic()
        if wanted is not None and wanted.keys == provided.plan.keys:
            if provided.gone_since is not None:
                provided.gone_since = None
                self._inbox.put(provided.on_found, 0, is_due=True)
            return
        if provided.gone_since is None:
            provided.gone_since = now
            self._inbox.put(provided.on_lost, 0, is_due=True)
        if wanted is not None or name in self._taken or now - provided.gone_since > LINGER:
            del self._provided[name]
            provided.close()

    # Declarations -----------------------------------------------------------------------------------------------------

    def publishers(self) -> dict[str, tuple[DataKey, Qos, Priority]]:
        """Return the publishers in ROS 2."""
        return {route: how for each in self._ready() for route, how in each.publishers.items()}

    def subscribers(self) -> dict[DataKey, Qos]:
        """Return the subscribers in ROS 2."""
        return {
            key: qos
            for each in self.plan.provides.values()
            for key, qos in ((each.keys.feedback, FEEDBACK_QOS), (each.keys.status, STATUS_QOS))
        }

    def services(self) -> list[DataKey]:
        """Return the services to offer."""
        return [key for each in self._ready() for key in each.plan.keys.services]

    def clients(self) -> list[DataKey]:
        """Return the services to call."""
        return [key for each in self.plan.provides.values() for key in each.keys.services]

    def _ready(self) -> list[OfferedAction]:
        """Return the ROS 1 actions whose servers can receive goals."""
        return [each for each in self._offered.values() if each.is_connected]

    def on_declared(self) -> None:
        """Send the state of all actions again: the session has declared their endpoints."""
        for each in self._offered.values():
            self._inbox.put(each.repeat, 0, is_due=True)

    # Messages from ROS 2 ----------------------------------------------------------------------------------------------

    def on_call(self, call: Call) -> bool:
        """Handle a call if it belongs to an action, and return whether it does. Called on any thread."""
        if HIDDEN not in call.key.name:
            return False
        action = self._by_key.get(call.key)
        if call.origin is None or not isinstance(action, OfferedAction):
            call.drop()
        elif not self._inbox.put(partial(action.on_call, call), len(call.body)):
            call.fail("the bridge to ROS 1 has too many calls at once")
        return True

    def on_message(self, key: DataKey, body: bytes) -> bool:
        """Handle a message if it belongs to an action, and return whether it does. Called on any thread."""
        action = self._by_key.get(key)
        if isinstance(action, ProvidedAction):
            self._inbox.put(partial(action.on_ros2, key, body), len(body))
        return HIDDEN in key.name

    # The thread -------------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        next_tick = 0.0
        while not self._is_closing:
            has_actions = bool(self._offered or self._provided)
            task = self._inbox.get(max(0.0, next_tick - time.monotonic()) if has_actions else TICK * 10)
            try:
                if task is not None:
                    task()
                if time.monotonic() >= next_tick:
                    next_tick = time.monotonic() + TICK
                    for action in self._all():
                        action.tick()
            except Exception as error:  # noqa: BLE001 - a bug must not end the bridge silently
                if not self._is_closing:
                    self._on_error(error)

    def _all(self) -> list[OfferedAction | ProvidedAction]:
        return [*[*self._offered.values()], *[*self._provided.values()]]

    def status(self) -> list[dict[str, str]]:
        """Return the entries of the bridge's status, one for each action."""
        rows: list[dict[str, str]] = [
            {"action": name, "server": "ROS 1", "node": each.local.node, "type": each.pair.ros2}
            for name, each in self.plan.offers.items()
        ]
        rows += [
            {"action": name, "server": "ROS 2", "node": each.node, "type": each.pair.ros1}
            for name, each in self.plan.provides.items()
        ]
        return rows

    def close(self) -> None:
        """End all goals and the thread. The session must still be open."""
        self._is_closing = True
        self._inbox.close()
        self._thread.join(_CLOSE_TIME)
        for action in self._all():
            action.end()
            if self._node.ok():  # a node that is shutting down unregisters everything itself
                action.close()
