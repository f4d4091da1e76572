"""Preempts a container when the node shuts down."""

from __future__ import annotations

import threading
import time
from typing import Any

import rospy
from rospy.core import add_preshutdown_hook

MAX_SHUTDOWN_WAIT_S = 60.0
"""Seconds that the node's shutdown waits for the container."""


def set_preempt_handler(sc: Any) -> None:
    """Preempt a container when the node shuts down, and wait up to a minute until it has ended.

    Run the container in a thread of its own, and ``rospy.spin()`` in the main thread: a container in the main thread
    cannot continue while that thread handles Ctrl-C. It is then preempted without a wait: the current state finishes,
    and no other one starts.

    Args:
        sc: a `smach.StateMachine`, `smach.Concurrence` or other container.
    """
    thread_ids: list[int] = []
    sc.register_start_cb(lambda userdata, labels: thread_ids.append(threading.get_ident()))

    def preempt(reason: str) -> None:
        if not sc.is_running():
            return
        sc.request_preempt()
        if thread_ids[-1:] == [threading.get_ident()]:
            return
        rospy.loginfo("Shutdown requested: preempting the state machine, and waiting for its end.")
        end = time.monotonic() + MAX_SHUTDOWN_WAIT_S
        while sc.is_running() and time.monotonic() < end:
            time.sleep(0.02)  # rospy.sleep ends with the node

    add_preshutdown_hook(preempt)


__all__ = ["set_preempt_handler"]
