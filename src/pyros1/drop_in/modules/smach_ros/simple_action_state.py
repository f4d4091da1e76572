"""A state that calls an action (https://wiki.ros.org/smach/Tutorials/Calling%20Actions)."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import rospy

from smach_ros.call_state import CallState, UserCallback

PREEMPT_TIMEOUT = SERVER_WAIT_TIMEOUT = rospy.Duration(60.0)


class SimpleActionState(CallState):
    """A state that sends a goal to an action server; outcomes "succeeded", "aborted" and "preempted".

    Args:
        action_name: name of the action.
        action_spec: class of the action.
        goal: the goal, if nothing else provides one; None for an empty one.
        goal_key: userdata key of a whole goal.
        goal_slots: userdata keys that are fields of the goal.
        goal_cb: called with the userdata and the goal, then ``goal_cb_args`` and ``goal_cb_kwargs``; it changes the
            goal, or returns another one.
        result_key, result_slots: userdata keys in which the whole result, or fields of it, are stored.
        result_cb: called with the userdata, the status (of actionlib_msgs/GoalStatus) and the result, then its own
            arguments; it may return an outcome.
        input_keys, output_keys, outcomes: additional ones, which the callbacks use.
        exec_timeout: rospy.Duration after which the goal is canceled, and the outcome is "aborted"; None for no limit.
        preempt_timeout: rospy.Duration within which the server has to end a canceled goal.
        server_wait_timeout: rospy.Duration to wait for the server.
    """

    # Values of `_status`.
    WAITING_FOR_SERVER = 0
    INACTIVE = 1
    ACTIVE = 2
    PREEMPTING = 3
    COMPLETED = 4

    def __init__(
        self,
        action_name: str,
        action_spec: Any,
        goal: Any = None,
        goal_key: str | None = None,
        goal_slots: Iterable[str] = (),
        goal_cb: Callable[..., Any] | None = None,
        goal_cb_args: Sequence[Any] = (),
        goal_cb_kwargs: Mapping[str, Any] | None = None,
        result_key: str | None = None,
        result_slots: Iterable[str] = (),
        result_cb: Callable[..., Any] | None = None,
        result_cb_args: Sequence[Any] = (),
        result_cb_kwargs: Mapping[str, Any] | None = None,
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        outcomes: Iterable[str] = (),
        exec_timeout: rospy.Duration | None = None,
        preempt_timeout: rospy.Duration = PREEMPT_TIMEOUT,
        server_wait_timeout: rospy.Duration = SERVER_WAIT_TIMEOUT,
    ) -> None:
        from actionlib.simple_action_client import SimpleActionClient

        super().__init__(
            ("goal", "result"),
            action_spec().action_goal.goal if goal is None else goal,
            (goal_key, goal_slots, UserCallback(goal_cb, goal_cb_args, goal_cb_kwargs)),
            (result_key, result_slots, UserCallback(result_cb, result_cb_args, result_cb_kwargs)),
            (input_keys, output_keys, outcomes),
        )
        self._action_name = action_name
        self._exec_timeout = exec_timeout
        self._preempt_timeout = preempt_timeout
        self._server_wait_timeout = server_wait_timeout
        self._action_client = SimpleActionClient(action_name, action_spec)
        self._status = self.WAITING_FOR_SERVER
        self._done = threading.Event()

    def execute(self, ud: Any) -> Any:
        """Send the goal, wait for the result, and return the outcome."""
        if not self._wait_for_server():
            if self.preempt_requested() or rospy.is_shutdown():
                return self._finish_preempted()
            rospy.logerr("Action server '%s' is not available.", self._action_name)
            return "aborted"
        self._status = self.INACTIVE
        goal = self._make_message(ud)
        if self.preempt_requested():
            return self._finish_preempted()
        self._done.clear()
        self._status = self.ACTIVE
        self._action_client.send_goal(goal, done_cb=lambda state, result: self._done.set())
        self._wait_for_result()
        self._status = self.COMPLETED
        if rospy.is_shutdown() and not self._done.is_set():
            return self._finish_preempted()
        return self._determine_outcome(ud)

    def _wait_for_server(self) -> bool:
        self._status = self.WAITING_FOR_SERVER
        end = rospy.Time.now() + self._server_wait_timeout
        while not self.preempt_requested() and not rospy.is_shutdown():
            if self._action_client.wait_for_server(rospy.Duration(1.0)):
                return True
            if rospy.Time.now() >= end:
                return False
            rospy.logwarn("Still waiting for action server '%s' to start... is it running?", self._action_name)
        return False

    def _wait_for_result(self) -> None:
        """Wait for the end of the goal, and cancel it if it takes too long."""
        begin = rospy.Time.now()
        canceled_at: float | None = None
        while not self._done.wait(0.02) and not rospy.is_shutdown():
            if canceled_at is None:
                begin = min(begin, rospy.Time.now())  # simulated time may jump back
                timed_out = self._exec_timeout is not None and rospy.Time.now() - begin > self._exec_timeout
                if timed_out or self.preempt_requested():
                    if timed_out:
                        rospy.logwarn("Action '%s' timed out: canceling its goal.", self._action_name)
                    self._status = self.PREEMPTING
                    self._action_client.cancel_goal()
                    canceled_at = time.monotonic()
            elif time.monotonic() - canceled_at > self._preempt_timeout.to_sec():
                rospy.logerr("Action server '%s' did not end a canceled goal in time.", self._action_name)
                self._action_client.stop_tracking_goal()
                break

    def _determine_outcome(self, ud: Any) -> Any:
        from pyros1.msgs.actionlib_msgs.msg import GoalStatus

        if not self._done.is_set():
            return "aborted"
        status, result = self._action_client.get_state(), self._action_client.get_result()
        if result is not None:
            self._store(ud, result)
        callback_outcome = self._received_callback(ud, status, result)
        preempted = status in (GoalStatus.PREEMPTED, GoalStatus.RECALLED) and self.preempt_requested()
        if preempted:
            self.service_preempt()
        if callback_outcome is not None:
            return callback_outcome
        if status == GoalStatus.SUCCEEDED:
            return "succeeded"
        # "preempted" means that this state was preempted; preemption by another client or after a timeout is a failure.
        return "preempted" if preempted else "aborted"

    def _finish_preempted(self) -> str:
        self.service_preempt()
        return "preempted"


__all__ = ["SimpleActionState"]
