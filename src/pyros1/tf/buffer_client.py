"""Looks up transforms in the buffer of another node: the client of the action tf2_msgs/LookupTransform."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import NodeShutdownError
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import load_message
from pyros1.tf.buffer_server import DEFAULT_ACTION_NAME, EXCEPTIONS_BY_CODE
from pyros1.tf.errors import TimeoutException, TransformException

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.node.subscribing.subscriber import Subscriber
    from pyros1.tf.buffer import Span, When

_QUEUE_SIZE = 10
_SUCCEEDED = 3
_FINAL_STATUSES = frozenset({2, 3, 4, 5, 8})
"""Values of actionlib_msgs/GoalStatus for goals that have ended."""
_POLL_INTERVAL = 0.1
"""Seconds between checks of simulated time."""


@dataclass
class _PendingGoal:
    """A lookup that waits for its result.

    Attributes:
        result: the server's result.
        num_ended_statuses: number of status messages that show the lookup as ended; after two of these without a
            result, the result is considered lost.
    """

    result: Any = None
    num_ended_statuses: int = 0


class BufferClient:
    """Looks up transforms in the buffer of a `BufferServer`, or of stock's server.

    It has the same lookup methods as `Buffer`, and is thread-safe.

    Args:
        node: the node whose topics and time are used.
        name: name of the server's action, resolved like the names of the node's topics.
        timeout_padding: seconds to wait for a result, in addition to the lookup's own timeout.
        remap: whether remappings of ``name`` apply, in addition to remappings of its topics.
    """

    def __init__(
        self, node: Node, name: str = DEFAULT_ACTION_NAME, timeout_padding: Span = 2.0, *, remap: bool = True
    ) -> None:
        self.name = node.resolve(name, remap=remap)
        self._node = node
        self._timeout_padding = _to_seconds(timeout_padding)
        self._goal_numbers = itertools.count(1)
        self._changed = threading.Condition()
        self._pending_goals: dict[str, _PendingGoal] = {}
        self._action_goal_class: Any = load_message("tf2_msgs/LookupTransformActionGoal")
        self._goal_class: Any = load_message("tf2_msgs/LookupTransformGoal")
        self._goal_id_class: Any = load_message("actionlib_msgs/GoalID")
        self._goal_publisher = node.advertise(f"{self.name}/goal", self._action_goal_class, queue_size=_QUEUE_SIZE)
        self._cancel_publisher = node.advertise(f"{self.name}/cancel", self._goal_id_class, queue_size=_QUEUE_SIZE)
        result_type = "tf2_msgs/LookupTransformActionResult"
        self._result_subscriber = self._subscribe(f"{self.name}/result", result_type, self._on_result)
        self._status_subscriber = self._subscribe(
            f"{self.name}/status", "actionlib_msgs/GoalStatusArray", self._on_status
        )
        node.on_shutdown(self._wake)

    def _subscribe(self, topic: str, type_name: str, callback: Callable[[Any], None]) -> Subscriber[Any]:
        # Called directly, not through the queue of a node that spins, since that thread may be blocked in a lookup.
        node = self._node
        return node._topics.subscribe(node.resolve(topic), load_message(type_name), callback, _QUEUE_SIZE, direct=True)

    def wait_for_server(self, timeout: Span = None) -> bool:
        """Wait until the server is connected.

        Args:
            timeout: seconds of wall time; None waits until the node shuts down.

        Returns:
            Whether the server is connected.
        """
        deadline = None if timeout is None else monotonic() + _to_seconds(timeout)
        if not self._goal_publisher.wait_for_subscribers(timeout=_remaining_time(deadline)):
            return False
        return self._result_subscriber.wait_for_publishers(timeout=_remaining_time(deadline))

    def lookup_transform(self, target_frame: str, source_frame: str, time: When = None, timeout: Span = None) -> Any:
        """Return the pose of ``source_frame`` in ``target_frame``, like `Buffer.lookup_transform`.

        Raises:
            TimeoutException: no server is running, or it does not respond.
            TransformException: the server's buffer has no such transform; a subclass, as in `Buffer.lookup_transform`.
            NodeShutdownError: the node shut down during the wait.
        """
        goal = self._goal_class(target_frame=target_frame, source_frame=source_frame, source_time=_to_time(time))
        return self._request_transform(goal, _to_seconds(timeout))

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: When,
        source_frame: str,
        source_time: When,
        fixed_frame: str,
        timeout: Span = None,
    ) -> Any:
        """Return the pose of ``source_frame`` at ``source_time`` in ``target_frame`` at ``target_time``.

        See `Buffer.lookup_transform_full`. Raises the same errors as `lookup_transform`."""
        goal = self._goal_class(
            target_frame=target_frame,
            source_frame=source_frame,
            source_time=_to_time(source_time),
            target_time=_to_time(target_time),
            fixed_frame=fixed_frame,
            advanced=True,
        )
        return self._request_transform(goal, _to_seconds(timeout))

    def can_transform(self, target_frame: str, source_frame: str, time: When = None, timeout: Span = None) -> bool:
        """Return whether `lookup_transform` would succeed, now or within ``timeout`` seconds.

        Raises:
            NodeShutdownError: the node shut down during the wait.
        """
        try:
            self.lookup_transform(target_frame, source_frame, time, timeout)
        except TransformException:
            return False
        return True

    def can_transform_full(
        self,
        target_frame: str,
        target_time: When,
        source_frame: str,
        source_time: When,
        fixed_frame: str,
        timeout: Span = None,
    ) -> bool:
        """Return whether `lookup_transform_full` would succeed, now or within ``timeout`` seconds."""
        try:
            self.lookup_transform_full(target_frame, target_time, source_frame, source_time, fixed_frame, timeout)
        except TransformException:
            return False
        return True

    def close(self) -> None:
        """Stop publishing and subscribing."""
        self._goal_publisher.unregister()
        self._cancel_publisher.unregister()
        self._result_subscriber.unregister()
        self._status_subscriber.unregister()

    def _request_transform(self, goal: Any, timeout: float) -> Any:
        goal.timeout = Duration.from_sec(timeout)
        total_timeout = timeout + self._timeout_padding
        if not self.wait_for_server(total_timeout):
            self._raise_if_shut_down()
            raise TimeoutException(f"there is no buffer server at {self.name}")
        deadline = self._node.now() + Duration.from_sec(total_timeout)
        result = None
        while result is None:  # if the server noticed this client too late, the result was lost: try again
            result = self._request_once(goal, deadline)
        if result.status.status != _SUCCEEDED:
            raise TransformException(f"the server has cancelled the lookup (status {result.status.status})")
        error = result.result.error
        if error.error:
            raise EXCEPTIONS_BY_CODE.get(error.error, TransformException)(error.error_string)
        return result.result.transform

    def _request_once(self, goal: Any, deadline: Time) -> Any:
        """Send a goal and wait for the result; return None if the result was lost.

        Raises:
            TimeoutException: the server did not respond before the deadline.
            NodeShutdownError: the node shut down during the wait.
        """
        now = self._node.now()
        goal_id = self._goal_id_class(now, f"{self._node.name}-{next(self._goal_numbers)}-{now.to_sec():.9f}")
        message = self._action_goal_class(goal_id=goal_id, goal=goal)
        message.header.stamp = now
        pending_goal = self._pending_goals[goal_id.id] = _PendingGoal()
        try:
            self._goal_publisher.publish(message)
            with self._changed:
                while pending_goal.result is None and pending_goal.num_ended_statuses < 2:
                    self._raise_if_shut_down()
                    remaining = (deadline - self._node.now()).to_sec()
                    if remaining <= 0:
                        self._cancel_publisher.publish(goal_id)
                        raise TimeoutException(f"the buffer server at {self.name} did not respond")
                    self._changed.wait(min(remaining, _POLL_INTERVAL))
        finally:
            del self._pending_goals[goal_id.id]
        return pending_goal.result

    def _on_result(self, message: Any) -> None:
        with self._changed:
            pending_goal = self._pending_goals.get(message.status.goal_id.id)
            if pending_goal is not None:  # otherwise the result is for another client
                pending_goal.result = message
                self._changed.notify_all()

    def _on_status(self, message: Any) -> None:
        with self._changed:
            for status in message.status_list:
                pending_goal = self._pending_goals.get(status.goal_id.id)
                if pending_goal is not None and status.status in _FINAL_STATUSES:
                    pending_goal.num_ended_statuses += 1
                    self._changed.notify_all()

    def _wake(self) -> None:
        with self._changed:
            self._changed.notify_all()

    def _raise_if_shut_down(self) -> None:
        if not self._node.ok():
            raise NodeShutdownError("the wait for a transform was interrupted because the node has shut down")


def _remaining_time(deadline: float | None) -> float | None:
    return None if deadline is None else max(0.0, deadline - monotonic())


def _to_time(when: When) -> Time:
    if not when:
        return Time()
    return Time.from_sec(when) if isinstance(when, (int, float)) else Time(when.secs, when.nsecs)


def _to_seconds(span: Span) -> float:
    if not span:
        return 0.0
    return float(span if isinstance(span, (int, float)) else span.to_sec())
