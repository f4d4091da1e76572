"""A goal as its client sees it, without communication: derives its stages from the server's messages, whatever the
order in which they arrive.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.actions.states import Stage, Status, stages_after

LOST_AFTER = 5.0
"""Seconds after which a goal is lost if its server does not report it, or is not connected."""


class Progress:
    """Stage, status and result of one goal. Not thread-safe: the caller must hold a lock.

    Attributes:
        name: the goal's name, unique in the system.
        stage: the current stage.
        status: the server's latest status.
        text: the message that the server sent with this status.
        result: the action's result message; None until it is received.

    Args:
        name: the goal's name.
        on_stage: called with each stage when it is entered.
        on_violation: called with a description of each protocol violation by the server.
    """

    def __init__(
        self, name: str, on_stage: Callable[[Stage], object], on_violation: Callable[[str], object] = lambda _: None
    ) -> None:
        self.name = name
        self.stage = Stage.WAITING_FOR_GOAL_ACK
        self.status = Status.PENDING
        self.text = ""
        self.result: Any = None
        self._is_known_to_server = False  # whether the server has reported the goal
        self._silent_since: float | None = None
        self._on_stage = on_stage
        self._on_violation = on_violation

    @property
    def done(self) -> bool:
        """Whether the goal has ended for this client."""
        return self.stage is Stage.DONE

    def handle_statuses(self, statuses: dict[str, Any], link_lost: bool = False, now: float = 0.0) -> None:
        """Handle a list of statuses.

        A server that no longer knows a goal has been restarted: the goal is lost. It is also lost if links have broken,
        perhaps with the goal or its result in transit, and the server does not report it for `LOST_AFTER` seconds.

        Args:
            statuses: the actionlib_msgs/GoalStatus of each goal, by the goal's name.
            link_lost: whether a link for goals or results has been lost since the goal was sent.
            now: monotonic time in seconds.
        """
        if self.done:
            return
        status = statuses.get(self.name)
        if status is not None:
            self._silent_since = None
            self._apply_status(status.status, status.text)
        elif self._is_known_to_server and self.stage is not Stage.WAITING_FOR_RESULT:
            self.lose("the action server no longer knows the goal")
        elif link_lost:
            if self._silent_since is None:
                self._silent_since = now
            elif now - self._silent_since > LOST_AFTER:
                self.lose("a connection broke, and the action server does not know the goal")

    def handle_result(self, status: Any, result: Any) -> None:
        """Handle the goal's result and the actionlib_msgs/GoalStatus sent with it; ignore all results but the first."""
        if self.done:
            return
        self.result = result
        self._apply_status(status.status, status.text)
        if not self.status.ended:
            self._on_violation(f"goal {self.name} got a result while its status was {self.status.name}")
            self.status = Status.LOST
        self._enter(Stage.DONE)

    def ask_to_cancel(self) -> bool:
        """Record that the client requests to cancel the goal; return whether this can still have an effect."""
        if self.stage in (Stage.DONE, Stage.WAITING_FOR_RESULT):
            return False
        if self.stage not in (Stage.RECALLING, Stage.PREEMPTING):
            self._enter(Stage.WAITING_FOR_CANCEL_ACK)
        return True

    def lose(self, reason: str) -> None:
        """Mark the goal as lost, without a message from the server."""
        if not self.done:
            self.status, self.text = Status.LOST, reason
            self._enter(Stage.DONE)

    def _apply_status(self, status: int, text: str) -> None:
        self._is_known_to_server = True
        stages = stages_after(self.stage, status)
        if stages is None:
            self._on_violation(f"goal {self.name} was {self.stage.name}, but its server now reports status {status}")
            return
        self.status, self.text = Status(status), text
        for stage in stages:
            self._enter(stage)

    def _enter(self, stage: Stage) -> None:
        self.stage = stage
        self._on_stage(stage)
