"""Server of an action (https://wiki.ros.org/actionlib)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.actions.goal_id import GoalNames
from pyros1.actions.goal_table import TOO_OLD_TEXT, GoalTable, Tracked
from pyros1.actions.messages import ActionTypes, subscribe_direct
from pyros1.actions.server_goal import ServerGoal
from pyros1.actions.states import Transition
from pyros1.ground.timing import Duration
from pyros1.msgs import load_message
from pyros1.node.checks import check_callback, check_positive

if TYPE_CHECKING:
    from pyros1.node import Node

_QUEUE_SIZE = 50
_INBOX_SIZE = 1000


class Server:
    """Receives goals and reports their state to clients. In the usual case, `SimpleServer` is easier to use.

    As a context manager, the server closes itself on exit.

    The callbacks run in separate threads, even in a node with ``callbacks="spin"``. They should return quickly: execute
    goals in other threads.

    Args:
        node: the node used for communication and time.
        name: name of the action.
        action: the action's class, such as FibonacciAction, or the name of its type, "actionlib_tutorials/Fibonacci".
        on_goal: called with each new `ServerGoal`, which must be accepted or rejected, in this callback or later.
        on_cancel: called with each goal that a client asks to cancel; its ``cancel_requested`` is already set.
        frequency: number of status messages per second; one is also sent after every change.
        kept: seconds for which a goal's status is still published after the goal has ended.

    Raises:
        ActionError: ``action`` is not an action.
        TypeError, ValueError: ``on_goal`` or ``frequency`` is invalid.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        action: Any,
        on_goal: Callable[[ServerGoal], object],
        on_cancel: Callable[[ServerGoal], object] | None = None,
        *,
        frequency: float = 5.0,
        kept: float = 5.0,
    ) -> None:
        check_callback(on_goal, "Server(node, name, action, on_goal)", "on_goal", action)
        check_positive(frequency, "frequency", "Hz")
        self.name = node.resolve(name)
        self.types = ActionTypes.of(action)
        self.node = node
        self.lock = threading.RLock()
        self._on_goal = on_goal
        self._on_cancel = on_cancel
        self._names = GoalNames(node.name)
        self._table: GoalTable[Tracked] = GoalTable(Duration.from_sec(kept))
        self._goals_by_name: dict[str, ServerGoal] = {}
        self._status_array_class: Any = load_message("actionlib_msgs/GoalStatusArray")
        self._closed = False
        self._status_publisher = node.advertise(
            f"{self.name}/status", self._status_array_class, queue_size=_QUEUE_SIZE, latch=True
        )
        self._result_publisher = node.advertise(f"{self.name}/result", self.types.action_result, queue_size=_QUEUE_SIZE)
        self._feedback_publisher = node.advertise(
            f"{self.name}/feedback", self.types.action_feedback, queue_size=_QUEUE_SIZE
        )
        goal_id = load_message("actionlib_msgs/GoalID")
        self._cancel_subscriber = subscribe_direct(
            node, f"{self.name}/cancel", goal_id, self._on_cancel_message, _INBOX_SIZE
        )
        self._goal_subscriber = subscribe_direct(
            node, f"{self.name}/goal", self.types.action_goal, self._on_goal_message, _INBOX_SIZE
        )
        self.publish_status()
        self._timer = node.timer(1.0 / frequency, lambda _: self.publish_status())

    def close(self) -> None:
        """Stop the server; clients receive no more messages about their goals."""
        with self.lock:
            self._closed = True
        self._timer.shutdown()
        for topic in (
            self._goal_subscriber,
            self._cancel_subscriber,
            self._status_publisher,
            self._result_publisher,
            self._feedback_publisher,
        ):
            topic.unregister()

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # Called by goals --------------------------------------------------------------------------------------------------

    def publish_status(self) -> None:
        """Send the status of all goals."""
        with self.lock:
            if self._closed:
                return
            now = self.node.now()
            for expired in self._table.forget(now):
                self._goals_by_name.pop(expired.status.goal_id.id, None)
            message = self._status_array_class(status_list=[tracked.status for tracked in self._table.goals])
            message.header.stamp = now
            self._status_publisher.publish(message)

    def publish_result(self, status: Any, result: Any) -> None:
        """Send the result of a goal that has ended, and the status of all goals."""
        with self.lock:
            if self._closed:
                return
            message = self.types.action_result(status=status)
            if result is not None:
                message.result = result
            message.header.stamp = self.node.now()
            self._result_publisher.publish(message)
            self.publish_status()

    def publish_feedback(self, status: Any, feedback: Any) -> None:
        """Send a goal's feedback."""
        with self.lock:
            if self._closed:
                return
            message = self.types.action_feedback(status=status, feedback=feedback)
            message.header.stamp = self.node.now()
            self._feedback_publisher.publish(message)

    # Received from clients --------------------------------------------------------------------------------------------

    def _on_goal_message(self, message: Any) -> None:
        with self.lock:
            now = self.node.now()
            goal_id = message.goal_id
            known_goal, is_recalled = self._table.find_arrived(goal_id.id, now)
            if known_goal is not None:
                if is_recalled:
                    self.publish_result(known_goal.status, None)
                return
            goal_id.id = goal_id.id or self._names.next(now)
            if not goal_id.stamp:
                goal_id.stamp = now
            tracked = Tracked(goal_id, goal=message)
            self._table.goals.append(tracked)
            goal = self._goals_by_name[goal_id.id] = ServerGoal(self, tracked)
            if self._table.is_too_old(goal_id):
                goal.cancel(text=TOO_OLD_TEXT)
                return
            self.publish_status()
        self._on_goal(goal)

    def _on_cancel_message(self, request: Any) -> None:
        goals_to_cancel = []
        with self.lock:
            matching = self._table.match_cancel(request)
            for tracked in matching:
                if tracked.apply(Transition.ASK_TO_CANCEL):
                    goal = self._goals_by_name.get(tracked.status.goal_id.id)
                    if goal is not None:
                        goals_to_cancel.append(goal)
            if request.id and self._table.find(request.id) is None:  # the goal may still arrive
                placeholder = Tracked(request)
                placeholder.apply(Transition.ASK_TO_CANCEL)
                placeholder.ended_at = self.node.now()
                self._table.goals.append(placeholder)
            self.publish_status()
        for goal in goals_to_cancel:
            goal.hear_cancel()
            if self._on_cancel is not None:
                self._on_cancel(goal)
