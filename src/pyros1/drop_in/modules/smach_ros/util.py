"""Preemption of a container when the node ends."""

from __future__ import annotations

import time
from typing import Any

import rospy
from rospy.core import add_preshutdown_hook

PATIENCE = 60.0
"""Seconds that the end of the node waits for the container."""


def set_preempt_handler(sc: Any) -> None:
    """Preempt a container when the node ends, and wait until it has ended, at most a minute.

    Run the container in a thread of its own, and ``rospy.spin()`` in the main thread: a container that runs in the main
    thread cannot go on while the main thread handles Ctrl-C.

    Args:
        sc: a `smach.StateMachine`, `smach.Concurrence` or other container.
    """

    def preempt(reason: str) -> None:
        if not sc.is_running():
            return
        sc.request_preempt()
        rospy.loginfo("Shutdown requested: preempting the state machine, and waiting for its end.")
        end = time.monotonic() + PATIENCE
        while sc.is_running() and time.monotonic() < end:
            time.sleep(0.02)  # rospy.sleep ends with the node

    add_preshutdown_hook(preempt)


__all__ = ["set_preempt_handler"]
