"""The server's handle of a received goal."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.actions.errors import ActionError
from pyros1.actions.states import Status, Transition

if TYPE_CHECKING:
    from pyros1.actions.goal_table import Tracked
    from pyros1.actions.server import Server


class ServerGoal:
    """A goal that a client has sent.

    Attributes:
        name: the goal's name, unique in the ROS system.
        goal: the action's goal message sent by the client, such as FibonacciGoal.
    """

    def __init__(self, server: Server, tracked: Tracked) -> None:
        self.name: str = tracked.status.goal_id.id
        self.goal: Any = tracked.goal.goal
        self._server = server
        self._tracked = tracked
        self._listeners: list[Callable[[], object]] = []

    @property
    def status(self) -> Status:
        """The goal's status."""
        return Status(self._tracked.status.status)

    @property
    def cancel_requested(self) -> bool:
        """Whether a client or a newer goal has asked this goal to stop; it should end soon, for example by `cancel`."""
        return self.status in (Status.RECALLING, Status.PREEMPTING)

    @property
    def ended(self) -> bool:
        """Whether the goal has ended."""
        return self.status.ended

    def accept(self, text: str = "") -> None:
        """Accept the goal.

        Raises:
            ActionError: the goal's state does not allow it; `reject`, `succeed`, `abort` and `cancel` also raise this
                error.
        """
        self._transition(Transition.ACCEPT, text)

    def reject(self, result: Any = None, text: str = "") -> None:
        """Reject the goal; not possible after `accept`."""
        self._end(Transition.REJECT, result, text)

    def succeed(self, result: Any = None, text: str = "") -> None:
        """End the goal because it was achieved.

        Args:
            result: the action's result message, such as FibonacciResult; None for one with default values.
            text: a description for users.

        Raises:
            ActionError: the goal's state does not allow it.
            TypeError: ``result`` is a message of another type.
        """
        self._end(Transition.SUCCEED, result, text)

    def abort(self, result: Any = None, text: str = "") -> None:
        """End the goal because it could not be achieved."""
        self._end(Transition.ABORT, result, text)

    def cancel(self, result: Any = None, text: str = "") -> None:
        """End the goal because it was cancelled."""
        self._end(Transition.CANCEL, result, text)

    def feedback(self, feedback: Any) -> None:
        """Send the action's feedback message, such as FibonacciFeedback.

        Raises:
            TypeError: ``feedback`` is a message of another type.
        """
        if not isinstance(feedback, self._server.types.feedback):
            raise TypeError(f"feedback must be a {self._server.types.feedback.__name__}, not {feedback!r:.80}")
        self._server.publish_feedback(self._tracked.status, feedback)

    def ask_to_cancel(self) -> None:
        """Ask the goal to stop, as a client would."""
        with self._server.lock:
            if not self._tracked.apply(Transition.ASK_TO_CANCEL):
                return
            self._server.publish_status()
        self.hear_cancel()

    def on_cancel(self, listener: Callable[[], object]) -> None:
        """Call a function, in any thread, when the goal is asked to stop; immediately if that has already happened."""
        with self._server.lock:
            self._listeners.append(listener)
            already_requested = self.cancel_requested
        if already_requested:
            listener()

    def hear_cancel(self) -> None:
        """Call the listeners added by `on_cancel`."""
        for listener in list(self._listeners):
            listener()

    def _transition(self, transition: Transition, text: str) -> None:
        with self._server.lock:
            if not self._tracked.apply(transition, text):
                raise ActionError(f"cannot {transition.value} goal {self.name}: it is {self.status.name}")
            self._server.publish_status()

    def _end(self, transition: Transition, result: Any, text: str) -> None:
        result_class = self._server.types.result
        if result is not None and not isinstance(result, result_class):
            raise TypeError(f"a result of {self._server.name} must be a {result_class.__name__}, not {result!r:.80}")
        with self._server.lock:
            if not self._tracked.apply(transition, text):
                raise ActionError(f"cannot {transition.value} goal {self.name}: it is {self.status.name}")
            self._tracked.ended_at = self._server.node.now()
            self._server.publish_result(self._tracked.status, result)
