"""Runs a container as an action server (https://wiki.ros.org/smach/Tutorials/Wrapping%20a%20SMACH%20Container%20With%20actionlib)."""

from __future__ import annotations

import copy
import traceback
from collections.abc import Iterable, Mapping
from typing import Any

import rospy
from smach.exceptions import InvalidStateError


class ActionServerWrapper:
    """An action server that runs a container for each goal.

    Args:
        server_name: name of the action.
        action_spec: class of the action.
        wrapped_container: the container, whose userdata has goal, feedback and result.
        succeeded_outcomes, aborted_outcomes, preempted_outcomes: the outcomes of the container for which the action
            reports success, failure and preemption; each outcome has to be in one of these lists.
        goal_key, feedback_key, result_key: userdata keys of the messages.
        goal_slots_map, feedback_slots_map, result_slots_map: field of the message -> userdata key.
        expand_goal_slots: whether to put each field of the goal into the userdata under its own name.
        pack_result_slots: whether to take each field of the result from the userdata under its own name.

    Raises:
        InvalidStateError: an outcome is in none of the lists, or in several.
    """

    def __init__(
        self,
        server_name: str,
        action_spec: Any,
        wrapped_container: Any,
        succeeded_outcomes: Iterable[str] = (),
        aborted_outcomes: Iterable[str] = (),
        preempted_outcomes: Iterable[str] = (),
        goal_key: str = "action_goal",
        feedback_key: str = "action_feedback",
        result_key: str = "action_result",
        goal_slots_map: Mapping[str, str] | None = None,
        feedback_slots_map: Mapping[str, str] | None = None,
        result_slots_map: Mapping[str, str] | None = None,
        expand_goal_slots: bool = False,
        pack_result_slots: bool = False,
    ) -> None:
        self.wrapped_container = wrapped_container
        self._server_name = server_name
        self._action_spec = action_spec
        self._outcomes_by_goal_result = {
            "succeeded": tuple(succeeded_outcomes),
            "aborted": tuple(aborted_outcomes),
            "preempted": tuple(preempted_outcomes),
        }
        self._goal_key, self._feedback_key, self._result_key = goal_key, feedback_key, result_key
        action = action_spec()
        self._feedback, self._result = action.action_feedback.feedback, action.action_result.result
        self._goal_slots = dict(goal_slots_map or {})
        self._feedback_slots = dict(feedback_slots_map or {})
        self._result_slots = dict(result_slots_map or {})
        if expand_goal_slots:
            self._goal_slots = {**{name: name for name in action.action_goal.goal.__slots__}, **self._goal_slots}
        if pack_result_slots:
            self._result_slots = {**{name: name for name in self._result.__slots__}, **self._result_slots}
        self._check_outcomes()
        self._server: Any = None

    def _check_outcomes(self) -> None:
        listed_outcomes = [outcome for outcomes in self._outcomes_by_goal_result.values() for outcome in outcomes]
        container_outcomes = self.wrapped_container.get_registered_outcomes()
        repeated_outcomes = sorted({outcome for outcome in listed_outcomes if listed_outcomes.count(outcome) > 1})
        unlisted_outcomes = [outcome for outcome in container_outcomes if outcome not in listed_outcomes]
        unknown_outcomes = [outcome for outcome in listed_outcomes if outcome not in container_outcomes]
        if repeated_outcomes or unlisted_outcomes or unknown_outcomes:
            raise InvalidStateError(
                "Each outcome of a wrapped container has to be in one of succeeded_outcomes, aborted_outcomes and "
                f"preempted_outcomes. In several: {repeated_outcomes}; in none: {unlisted_outcomes}; "
                f"not an outcome: {unknown_outcomes}."
            )

    def run_server(self) -> None:
        """Start the action server; it runs in threads of its own."""
        from actionlib.simple_action_server import SimpleActionServer

        self._server = SimpleActionServer(
            self._server_name, self._action_spec, execute_cb=self.execute_cb, auto_start=False
        )
        self._server.register_preempt_callback(self.preempt_cb)
        self.wrapped_container.register_transition_cb(self.transition_cb)
        self.wrapped_container.register_termination_cb(self.termination_cb)
        self._server.start()

    def transition_cb(self, userdata: Any, active_states: list[str]) -> None:
        """Send feedback; the container calls this when its active states change."""
        self.publish_feedback(userdata)

    def termination_cb(self, userdata: Any, terminal_states: list[str], container_outcome: str) -> None:
        """Send feedback; the container calls this when it ends."""
        self.publish_feedback(userdata)

    def publish_feedback(self, userdata: Any) -> None:
        """Send the feedback that is in the userdata, if there is any."""
        feedback = self._pack(self._feedback, userdata, self._feedback_key, self._feedback_slots)
        if feedback is not None and self._server is not None and self._server.is_active():
            self._server.publish_feedback(feedback)

    def _pack(self, default: Any, userdata: Any, key: str, slots: Mapping[str, str]) -> Any:
        """Return the message from the userdata; None if the userdata contains no part of it."""
        filled_slots = {slot: userdata[name] for slot, name in slots.items() if name in userdata}
        whole_message = userdata[key] if key in userdata else None  # noqa: SIM401  userdata is not a mapping
        if whole_message is None and not filled_slots:
            return None
        message = copy.deepcopy(default if whole_message is None else whole_message)
        for slot, value in filled_slots.items():
            setattr(message, slot, value)
        return message

    def execute_cb(self, goal: Any) -> None:
        """Run the container for a goal, and report its outcome; the action server calls this."""
        container = self.wrapped_container
        container.userdata[self._goal_key] = copy.deepcopy(goal)
        for slot, key in self._goal_slots.items():
            container.userdata[key] = copy.deepcopy(getattr(goal, slot))
        container.userdata[self._feedback_key] = copy.deepcopy(self._feedback)
        container.userdata[self._result_key] = copy.deepcopy(self._result)
        container.recall_preempt()
        if self._server.is_preempt_requested():
            container.request_preempt()
        try:
            outcome = container.execute()
        except Exception:  # noqa: BLE001  the client must be informed that the goal has ended
            rospy.logerr("The container of action server '%s' failed: %s", self._server_name, traceback.format_exc())
            outcome = None
        result = self._pack(self._result, container.userdata, self._result_key, self._result_slots)
        if outcome in self._outcomes_by_goal_result["succeeded"]:
            self._server.set_succeeded(result)
        elif outcome in self._outcomes_by_goal_result["preempted"]:
            self._server.set_preempted(result)
        else:
            self._server.set_aborted(result)

    def preempt_cb(self) -> None:
        """Preempt the container; the action server calls this when a client cancels the goal, or sends another one."""
        self.wrapped_container.request_preempt()  # even if the container is just about to run


__all__ = ["ActionServerWrapper"]
