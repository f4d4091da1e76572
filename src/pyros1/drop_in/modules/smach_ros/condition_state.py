"""A state that waits for a condition."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable
from typing import Any

import rospy
from smach.exceptions import InvalidUserCodeError
from smach.state import State

POLL_RATE = rospy.Duration(0.05)


class ConditionState(State):
    """A state that calls a function until it returns true; outcomes "true", "false" and "preempted".

    Args:
        cond_cb: called with the userdata; true ends the state with "true". It may be declared with
            `smach.cb_interface`.
        input_keys: userdata that it reads.
        poll_rate: rospy.Duration between two calls.
        timeout: rospy.Duration after which the outcome is "false"; None for no limit.
        max_checks: number of calls after which the outcome is "false"; -1 for no limit.
    """

    def __init__(
        self,
        cond_cb: Callable[[Any], bool],
        input_keys: Iterable[str] = (),
        poll_rate: rospy.Duration = POLL_RATE,
        timeout: rospy.Duration | None = None,
        max_checks: int = 1,
    ) -> None:
        super().__init__(["true", "false", "preempted"], input_keys)
        self._cond_cb = cond_cb
        self._poll_rate = poll_rate
        self._timeout = timeout
        self._max_checks = max_checks
        self._register_interface(cond_cb)

    def execute(self, ud: Any) -> str:
        """Call the function until there is an outcome; raises InvalidUserCodeError if the function fails."""
        begin = rospy.Time.now()
        checks = 0
        while self._max_checks == -1 or checks < self._max_checks:
            if self._timeout is not None and rospy.Time.now() - begin > self._timeout:
                break
            if self.preempt_requested():
                self.service_preempt()
                return "preempted"
            try:
                if self._cond_cb(ud):
                    return "true"
            except Exception as error:
                raise InvalidUserCodeError(f"The condition callback failed: {traceback.format_exc()}") from error
            checks += 1
            if checks == self._max_checks:
                break
            try:
                rospy.sleep(self._poll_rate)
            except rospy.ROSTimeMovedBackwardsException:
                begin = min(begin, rospy.Time.now())
            except rospy.ROSInterruptException:
                return "preempted"
        return "false"


__all__ = ["ConditionState"]
