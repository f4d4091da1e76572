"""Looks up transforms for other nodes: the server of the action tf2_msgs/LookupTransform.

The protocol is actionlib's (https://wiki.ros.org/actionlib/DetailedDescription).
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pyros1.ground.timing import Duration, Time
from pyros1.msgs import load_message
from pyros1.tf import errors

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.tf.buffer import Buffer

DEFAULT_ACTION_NAME = "tf2_buffer_server"
"""Default name of the action."""
_CHECK_INTERVAL = 0.01
_STATUS_INTERVAL = 0.2
STATUS_RETENTION = Duration(5)
"""Time for which the status of a goal is published after it has ended."""
_QUEUE_SIZE = 50

EXCEPTIONS_BY_CODE: dict[int, type[errors.TransformException]] = {
    1: errors.LookupException,
    2: errors.ConnectivityException,
    3: errors.ExtrapolationException,
    4: errors.InvalidArgumentException,
    5: errors.TimeoutException,
    6: errors.TransformException,
}
"""Exception for each code of tf2_msgs/TF2Error; 0 means no error."""


@dataclass
class _Goal:
    """A requested lookup.

    Attributes:
        status: the goal's actionlib_msgs/GoalStatus.
        lookup: returns the transform, or raises a TransformException if it is not available yet.
        deadline: time at which the lookup stops waiting.
        ended_at: time at which the goal ended; None while the lookup waits.
    """

    status: Any
    lookup: Callable[[], Any]
    deadline: Time
    ended_at: Time | None = None


class BufferServer:
    """Performs lookups for other nodes; responds when the transform is available or the timeout has expired.

    Programs use it through a `BufferClient` instead of receiving all transforms themselves. In a node with
    ``callbacks="spin"``, it only responds while `spin` or `spin_once` runs.

    Args:
        node: the node whose topics and time are used.
        buffer: the buffer of transforms, filled by a `TransformListener`.
        name: name of the action: its topics are ``NAME/goal``, ``NAME/cancel``, ``NAME/status``, ``NAME/feedback`` and
            ``NAME/result``.
    """

    def __init__(self, node: Node, buffer: Buffer, name: str = DEFAULT_ACTION_NAME) -> None:
        name = node.resolve(name)
        self._node = node
        self._buffer = buffer
        self._lock = threading.Lock()
        self._goals: dict[str, _Goal] = {}
        self._goal_numbers = itertools.count(1)
        self._cancelled_up_to = Time()  # goals with stamps up to this are cancelled, even if they arrive later
        self._last_check_time = Time()
        self._closed = False
        self._header_class: Any = load_message("std_msgs/Header")
        self._status_class: Any = load_message("actionlib_msgs/GoalStatus")
        self._status_array_class: Any = load_message("actionlib_msgs/GoalStatusArray")
        self._action_result_class: Any = load_message("tf2_msgs/LookupTransformActionResult")
        self._result_class: Any = load_message("tf2_msgs/LookupTransformResult")
        feedback_class: Any = load_message("tf2_msgs/LookupTransformActionFeedback")
        # The protocol requires this topic, although nothing is published on it.
        self._feedback_publisher = node.advertise(f"{name}/feedback", feedback_class, queue_size=_QUEUE_SIZE)
        self._result_publisher = node.advertise(f"{name}/result", self._action_result_class, queue_size=_QUEUE_SIZE)
        self._status_publisher = node.advertise(
            f"{name}/status", self._status_array_class, queue_size=_QUEUE_SIZE, latch=True
        )
        self._subscribers = [
            node.subscribe(f"{name}/goal", "tf2_msgs/LookupTransformActionGoal", self._on_goal_message),
            node.subscribe(f"{name}/cancel", "actionlib_msgs/GoalID", self._on_cancel_message),
        ]
        self._timers = [
            node.timer(_CHECK_INTERVAL, lambda _: self._check_goals()),
            node.timer(_STATUS_INTERVAL, lambda _: self._publish_status()),
        ]
        node.on_shutdown(self._stop)

    def close(self) -> None:
        """Stop the server; waiting lookups get no response."""
        self._stop()
        for subscriber in self._subscribers:
            subscriber.unregister()
        for publisher in (self._feedback_publisher, self._result_publisher, self._status_publisher):
            publisher.unregister()

    def _stop(self) -> None:
        """Stop the timers, and ignore messages from now on."""
        for timer in self._timers:
            timer.shutdown()
        with self._lock:
            self._closed = True

    def _on_goal_message(self, message: Any) -> None:
        goal_id, now = message.goal_id, self._node.now()
        if not goal_id.id:
            goal_id.id = f"{self._node.name}-{next(self._goal_numbers)}-{now.to_sec():.9f}"
        goal_id.stamp = goal_id.stamp or now
        with self._lock:
            existing_goal = self._goals.get(goal_id.id)
            if self._closed:
                return
            # Lets the next check notice if simulated time has jumped back since this goal arrived.
            self._last_check_time = max(self._last_check_time, now)
            if existing_goal is None:
                status = self._status_class(goal_id, self._status_class.ACTIVE, "")
                goal = _Goal(status, self._make_lookup(message.goal), now + message.goal.timeout)
                self._goals[goal_id.id] = goal
                if goal_id.stamp <= self._cancelled_up_to:
                    self._finish(goal, self._status_class.RECALLED)
                elif not self._try_lookup(goal):
                    self._publish_status_locked()
            elif existing_goal.status.status == self._status_class.RECALLING:
                self._finish(existing_goal, self._status_class.RECALLED)

    def _make_lookup(self, goal: Any) -> Callable[[], Any]:
        if not goal.advanced:
            return lambda: self._buffer.lookup_transform(goal.target_frame, goal.source_frame, goal.source_time)
        return lambda: self._buffer.lookup_transform_full(
            goal.target_frame, goal.target_time, goal.source_frame, goal.source_time, goal.fixed_frame
        )

    def _on_cancel_message(self, goal_id: Any) -> None:
        """Cancel the goal with the message's id and all goals up to its stamp, or all goals if both are empty."""
        with self._lock:
            if self._closed:
                return
            for goal in list(self._goals.values()):
                own_id = goal.status.goal_id
                is_older = bool(goal_id.stamp) and own_id.stamp <= goal_id.stamp
                if goal.ended_at is None and (own_id.id == goal_id.id or is_older or not (goal_id.id or goal_id.stamp)):
                    self._finish(goal, self._status_class.PREEMPTED)
            if goal_id.id and goal_id.id not in self._goals:  # the message arrived before its goal
                status, now = self._status_class(goal_id, self._status_class.RECALLING, ""), self._node.now()
                self._goals[goal_id.id] = _Goal(status, lambda: None, now, now)
            self._cancelled_up_to = max(self._cancelled_up_to, goal_id.stamp)

    def _check_goals(self) -> None:
        with self._lock:
            now = self._node.now()
            jumped_back, self._last_check_time = now < self._last_check_time, now
            if jumped_back:  # simulated time has restarted: goals waiting for earlier times get a response now
                self._cancelled_up_to = Time()
            for goal in list(self._goals.values()):
                if goal.ended_at is None and not self._closed:
                    goal.deadline = min(goal.deadline, now) if jumped_back else goal.deadline
                    self._try_lookup(goal)

    def _try_lookup(self, goal: _Goal) -> bool:
        """Respond to a goal if its transform is available or its deadline has passed. The caller must hold the lock.

        Returns:
            Whether a response was sent.
        """
        result = self._result_class()
        try:
            result.transform = goal.lookup()
        except errors.TransformException as error:
            if self._node.now() < goal.deadline:
                return False
            result.error.error = next(
                code for code, exception_class in EXCEPTIONS_BY_CODE.items() if isinstance(error, exception_class)
            )
            result.error.error_string = str(error)
        self._finish(goal, self._status_class.SUCCEEDED, result)
        return True

    def _finish(self, goal: _Goal, status: int, result: Any = None) -> None:
        goal.status.status, goal.ended_at = status, self._node.now()
        result = self._result_class() if result is None else result
        self._result_publisher.publish(self._action_result_class(self._make_header(), goal.status, result))
        self._publish_status_locked()

    def _publish_status(self) -> None:
        with self._lock:
            if not self._closed:
                self._publish_status_locked()

    def _publish_status_locked(self) -> None:
        """Publish the status of all goals, and remove goals that ended long ago. The caller must hold the lock."""
        now = self._node.now()
        for goal_id, goal in list(self._goals.items()):
            # Simulated time may have jumped back to before the end of the goal.
            if goal.ended_at is not None and not goal.ended_at <= now <= goal.ended_at + STATUS_RETENTION:
                del self._goals[goal_id]
        self._status_publisher.publish(
            self._status_array_class(self._make_header(), [goal.status for goal in self._goals.values()])
        )

    def _make_header(self) -> Any:
        return self._header_class(stamp=self._node.now())
