"""Client of an action (https://wiki.ros.org/actionlib)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.actions.callback_thread import CallbackThread
from pyros1.actions.client_goal import ClientGoal
from pyros1.actions.errors import ActionError
from pyros1.actions.goal_id import GoalNames
from pyros1.actions.messages import ActionTypes, links_of_node, subscribe_direct
from pyros1.actions.progress import LOST_AFTER
from pyros1.actions.states import Stage
from pyros1.ground.errors import NodeShutdownError, WaitTimeoutError
from pyros1.ground.timing import Time
from pyros1.msgs import load_message
from pyros1.net.signal_safe import Condition
from pyros1.node.checks import check_timeout

if TYPE_CHECKING:
    from pyros1.node import Node

_QUEUE_SIZE = 10
_INBOX_SIZE = 1000


class Client:
    """Sends goals to an action's server, and follows them. Thread-safe.

    As a context manager, the client closes itself on exit.

    The callbacks of goals run one after the other, in a separate thread, even in a node with ``callbacks="spin"``. They
    may send goals and wait for them.

    Args:
        node: the node used for communication and time.
        name: name of the action.
        action: the action's class, such as FibonacciAction, or the name of its type, "actionlib_tutorials/Fibonacci".

    Raises:
        ActionError: ``action`` is not an action.
    """

    def __init__(self, node: Node, name: str, action: Any) -> None:
        self.name = node.resolve(name)
        self.types = ActionTypes.of(action)
        self.node = node
        self.lock = threading.RLock()
        self._goal_id: Any = load_message("actionlib_msgs/GoalID")
        self._names = GoalNames(node.name)
        self._open_goals: dict[str, ClientGoal] = {}
        self._condition = Condition()
        self._callbacks = CallbackThread(f"pyros1-action {self.name}", node.log, self._check_server)
        self._has_status = False  # whether a status was received, which only a running server sends
        self._server_name = ""  # name of the node that sent the status
        self._disconnected_since: float | None = None
        self._closed = False
        self._goal_publisher = node.advertise(f"{self.name}/goal", self.types.action_goal, queue_size=_QUEUE_SIZE)
        self._cancel_publisher = node.advertise(f"{self.name}/cancel", self._goal_id, queue_size=_QUEUE_SIZE)
        self._result_subscriber = subscribe_direct(
            node, f"{self.name}/result", self.types.action_result, self._on_result, _INBOX_SIZE
        )
        self._feedback_subscriber = subscribe_direct(
            node, f"{self.name}/feedback", self.types.action_feedback, self._on_feedback, _INBOX_SIZE
        )
        status_array = load_message("actionlib_msgs/GoalStatusArray")
        self._status_subscriber = subscribe_direct(
            node, f"{self.name}/status", status_array, self._on_statuses, _INBOX_SIZE
        )
        node.on_shutdown(self._wake)

    @property
    def is_connected(self) -> bool:
        """Whether a server is connected on all topics."""
        endpoints = (
            self._goal_publisher,
            self._cancel_publisher,
            self._result_subscriber,
            self._feedback_subscriber,
            self._status_subscriber,
        )
        return self._has_status and all(endpoint.num_connections for endpoint in endpoints)

    def wait_for_server(self, timeout: float | None = None) -> bool:
        """Wait until a server is connected.

        Args:
            timeout: maximum number of seconds of wall time; None waits until the node shuts down.

        Returns:
            Whether a server is connected.

        Raises:
            NodeShutdownError: the node is shutting down.
        """
        check_timeout(timeout)
        return self.wait(lambda: self.is_connected, timeout, step=0.01)

    def send(
        self,
        goal: Any,
        *,
        on_feedback: Callable[[Any], object] | None = None,
        on_stage: Callable[[ClientGoal, Stage], object] | None = None,
        on_done: Callable[[ClientGoal], object] | None = None,
        timeout: float | None = 5.0,
    ) -> ClientGoal:
        """Send a goal and return its handle.

        Args:
            goal: the action's goal message, such as FibonacciGoal.
            on_feedback: called with each feedback message of the goal.
            on_stage: called with the goal and each stage that it reaches.
            on_done: called with the goal after it has ended.
            timeout: maximum number of seconds to wait until a server is connected; None waits until the node shuts
                down.

        Raises:
            WaitTimeoutError: no server is connected.
            NodeShutdownError: the node is shutting down.
            ActionError: the client is closed.
            TypeError: ``goal`` is a message of another type.
        """
        if not isinstance(goal, self.types.goal):
            raise TypeError(f"a goal of {self.name} must be a {self.types.goal.__name__}, not {goal!r:.80}")
        if self._closed:
            raise ActionError(f"the client of {self.name} is closed")
        if not self.wait_for_server(timeout):
            raise WaitTimeoutError(f"no server of action {self.name} within {timeout} s")
        now = self.node.now()
        client_goal = ClientGoal(self, self._names.next(now), on_feedback, on_stage, on_done)
        client_goal.links = self._links
        message = self.types.action_goal(goal_id=self._goal_id(now, client_goal.name), goal=goal)
        message.header.stamp = now
        with self.lock:
            self._open_goals[client_goal.name] = client_goal  # before a response can arrive
        self._goal_publisher.publish(message)
        if on_feedback or on_stage or on_done:
            self._callbacks.keep_checking()  # only `wait` and these checks notice that the server is gone
        return client_goal

    def cancel_all(self) -> None:
        """Ask the server to cancel all its goals, including those of other clients."""
        self._cancel_publisher.publish(self._goal_id())

    def cancel_until(self, time: Time) -> None:
        """Ask the server to cancel all goals sent up to a time, including those of other clients."""
        self._cancel_publisher.publish(self._goal_id(time, ""))

    def cancel(self, name: str) -> frozenset[object]:
        """Ask the server to cancel the goal called ``name``; return the links used for the request."""
        links = self._cancel_links
        self._cancel_publisher.publish(self._goal_id(Time(), name))
        return links

    def forget(self, name: str) -> None:
        """Stop following a goal."""
        with self.lock:
            self._open_goals.pop(name, None)

    def close(self) -> None:
        """Stop publishing and subscribing; open goals become LOST for this client, but are not cancelled."""
        self._closed = True
        for topic in (
            self._goal_publisher,
            self._cancel_publisher,
            self._result_subscriber,
            self._feedback_subscriber,
            self._status_subscriber,
        ):
            topic.unregister()
        self._lose_goals("the client was closed")

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # Waiting ----------------------------------------------------------------------------------------------------------

    def wait(self, ready: Callable[[], object], timeout: float | None, step: float = 0.2) -> bool:
        """Wait until a condition about this client's goals or server is met.

        Args:
            ready: returns whether the condition is met.
            timeout: maximum number of seconds of wall time; None for no limit.
            step: maximum number of seconds between two checks.

        Returns:
            Whether the condition is met.

        Raises:
            NodeShutdownError: the node is shutting down.
        """
        deadline = None if timeout is None else monotonic() + timeout
        while not ready():
            self.watch()
            remaining = step if deadline is None else min(step, deadline - monotonic())
            if remaining <= 0:
                return False
            self._condition.wait_for(ready, remaining)
        return True

    def watch(self) -> None:
        """Check whether the server still exists; if it has been gone for `LOST_AFTER` seconds, mark its goals as lost.

        Raises:
            NodeShutdownError: the node is shutting down.
        """
        if not self.node.ok():
            raise NodeShutdownError(f"the wait for action {self.name} was interrupted because the node has shut down")
        if self._result_subscriber.num_connections or not self._open_goals:
            self._disconnected_since = None
        elif self._disconnected_since is None:
            self._disconnected_since = monotonic()
        elif monotonic() - self._disconnected_since > LOST_AFTER:
            self._lose_goals("the action server is gone")

    def _check_server(self) -> bool:
        """Check whether the server still exists; return whether to check again, because goals are open."""
        with suppress(NodeShutdownError):
            self.watch()
            return bool(self._open_goals)
        return False

    def changed(self) -> None:
        """Wake up waiting threads after a goal has changed."""
        self._condition.notify_all()

    _wake = changed

    def queue_callback(self, callback: Callable[[], object]) -> None:
        """Queue a callback of the program. It runs in a separate thread, so it may wait for goals."""
        self._callbacks.add(callback)

    @property
    def _links(self) -> frozenset[object]:
        """The links that carry goals to the server and results from it; empty unless both exist."""
        goal_links = links_of_node(self._goal_publisher.links, self._server_name, lambda link: link.peer)
        result_links = links_of_node(
            self._result_subscriber.links, self._server_name, lambda link: link.header.get("callerid")
        )
        return goal_links | result_links if goal_links and result_links else frozenset()

    @property
    def _cancel_links(self) -> frozenset[object]:
        """The links that carry cancel requests to the server."""
        return links_of_node(self._cancel_publisher.links, self._server_name, lambda link: link.peer)

    # Received messages ------------------------------------------------------------------------------------------------

    def _on_statuses(self, message: Any) -> None:
        self._has_status = True
        self._server_name = (message._connection_header or {}).get("callerid", "")
        with self.lock:
            goals = list(self._open_goals.values())
        if goals:
            statuses = {status.goal_id.id: status for status in message.status_list}
            links, cancel_links, now = self._links, self._cancel_links, monotonic()
            for goal in goals:
                goal.take_statuses(statuses, links, cancel_links, now)
        self.changed()

    def _on_result(self, message: Any) -> None:
        goal = self._open_goals.get(message.status.goal_id.id)
        if goal is not None:  # otherwise, another client has sent the goal
            goal.take(lambda progress: progress.handle_result(message.status, message.result))

    def _on_feedback(self, message: Any) -> None:
        goal = self._open_goals.get(message.status.goal_id.id)
        if goal is not None:
            goal.take_feedback(message.feedback)

    def _lose_goals(self, reason: str) -> None:
        for goal in list(self._open_goals.values()):
            goal.take(lambda progress: progress.lose(reason))
