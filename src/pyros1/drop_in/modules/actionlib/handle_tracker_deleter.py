"""Handles the deletion of the last handle of a goal."""

from __future__ import annotations

from typing import Any

import rospy


class HandleTrackerDeleter:
    """Called when the last handle of a goal is deleted; the goal then stays in the status list only for a while.

    Args:
        action_server: the ActionServer.
        status_tracker: the goal's StatusTracker.
    """

    def __init__(self, action_server: Any, status_tracker: Any) -> None:
        self.action_server = action_server
        self.status_tracker = status_tracker

    def __call__(self, ptr: Any) -> None:
        """Record the time at which the last handle was deleted."""
        if self.action_server:
            with self.action_server.lock:
                self.status_tracker.handle_destruction_time = rospy.Time.now()
