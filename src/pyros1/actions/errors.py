"""Errors of actions."""

from __future__ import annotations

from typing import Any

from pyros1.actions.states import Status
from pyros1.ground.errors import Error


class ActionError(Error):
    """An argument is not an action, or a goal cannot change as requested. Also the base class of all action errors."""


class GoalError(ActionError):
    """A goal did not succeed.

    Attributes:
        status: the goal's final status.
        text: the server's message.
        result: the action's result message; None if none was received.
    """

    def __init__(self, name: str, status: Status, text: str, result: Any) -> None:
        super().__init__(f"goal {name} did not succeed: {status.name}" + (f" ({text})" if text else ""))
        self.status = status
        self.text = text
        self.result = result
