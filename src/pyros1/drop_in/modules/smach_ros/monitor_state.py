"""A state that watches a topic (https://wiki.ros.org/smach/Tutorials/MonitorState)."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Iterable
from typing import Any

import rospy
from smach.state import State


class MonitorState(State):
    """A state that runs until a function returns false for a message; outcomes "valid", "invalid" and "preempted".

    Args:
        topic: name of the topic.
        msg_type: message class.
        cond_cb: called with the userdata and each message; false ends the state with "invalid". It may be declared with
            `smach.cb_interface`.
        max_checks: number of messages after which the outcome is "valid"; -1 for no limit.
        input_keys, output_keys: userdata that it reads and writes.
    """

    def __init__(
        self,
        topic: str,
        msg_type: Any,
        cond_cb: Callable[[Any, Any], bool],
        max_checks: int = -1,
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
    ) -> None:
        super().__init__(["valid", "invalid", "preempted"], input_keys, output_keys)
        self._topic = topic
        self._msg_type = msg_type
        self._cond_cb = cond_cb
        self._max_checks = max_checks
        self._n_checks = 0
        self._outcome = ""
        self._trigger_event = threading.Event()
        self._register_interface(cond_cb)

    def execute(self, ud: Any) -> str:
        """Watch the topic until there is an outcome."""
        if self.preempt_requested():
            self.service_preempt()
            return "preempted"
        self._n_checks = 0
        self._outcome = ""
        self._trigger_event.clear()
        subscriber = rospy.Subscriber(self._topic, self._msg_type, self._cb, callback_args=ud)
        try:
            while not (self._trigger_event.wait(0.1) or rospy.is_shutdown() or self.preempt_requested()):
                pass
        finally:
            subscriber.unregister()
        if self.preempt_requested():
            self.service_preempt()
            return "preempted"
        return self._outcome or "preempted"

    def _cb(self, msg: Any, ud: Any) -> None:
        if self._trigger_event.is_set():
            return
        self._n_checks += 1
        try:
            is_valid = self._cond_cb(ud, msg)
        except Exception:  # noqa: BLE001  the program's code: as if it returned False
            rospy.logerr(
                "Error thrown while executing condition callback %s: %s", self._cond_cb, traceback.format_exc()
            )
            is_valid = False
        if not is_valid:
            self._outcome = "invalid"
        elif 0 < self._max_checks <= self._n_checks:
            self._outcome = "valid"
        else:
            return
        self._trigger_event.set()

    def request_preempt(self) -> None:
        """End the state with "preempted"."""
        super().request_preempt()
        self._trigger_event.set()


__all__ = ["MonitorState"]
