"""The client's handle of a goal that was sent."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from pyros1.actions.errors import GoalError
from pyros1.actions.progress import Progress
from pyros1.actions.states import Stage, Status
from pyros1.ground.errors import WaitTimeoutError
from pyros1.node.checks import check_timeout

if TYPE_CHECKING:
    from pyros1.actions.client import Client

_MAX_FEEDBACK = 100
"""Maximum number of feedback messages queued for an iteration; older ones are dropped."""


class ClientGoal:
    """A goal that was sent.

    Attributes:
        name: the goal's name, unique in the ROS system.
        links: the links used to send the goal and to receive its result; empty if one of them did not exist at that
            time.
    """

    def __init__(
        self,
        client: Client,
        name: str,
        on_feedback: Callable[[Any], object] | None,
        on_stage: Callable[[ClientGoal, Stage], object] | None,
        on_done: Callable[[ClientGoal], object] | None,
    ) -> None:
        self.name = name
        self.links: frozenset[object] = frozenset()
        self._client = client
        self._cancel_requested_on: frozenset[object] | None = None  # the links used for the cancel request
        self._progress = Progress(name, self._on_stage_entered, lambda message: client.node.log.warn("%s", message))
        self._on_feedback = on_feedback
        self._on_stage = on_stage
        self._on_done = on_done
        self._feedback_queue: deque[Any] = deque(maxlen=_MAX_FEEDBACK)
        self._listeners: list[Callable[[], object]] = []

    @property
    def stage(self) -> Stage:
        """The goal's stage as known to this client."""
        return self._progress.stage

    @property
    def status(self) -> Status:
        """The server's latest status; LOST if the server no longer knows the goal, or is gone."""
        return self._progress.status

    @property
    def text(self) -> str:
        """The message that the server sent with its latest status."""
        return self._progress.text

    @property
    def done(self) -> bool:
        """Whether the goal has ended."""
        return self._progress.done

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the goal has ended.

        Args:
            timeout: maximum number of seconds of wall time; None for no limit.

        Returns:
            Whether the goal has ended.

        Raises:
            NodeShutdownError: the node is shutting down.
        """
        check_timeout(timeout)
        return self._client.wait(lambda: self._progress.done, timeout)

    def result(self, timeout: float | None = None) -> Any:
        """Wait for the result and return it.

        Args:
            timeout: maximum number of seconds of wall time; None for no limit.

        Raises:
            GoalError: the goal did not succeed; the error has its status, text and result.
            WaitTimeoutError: the goal has not ended in time. The goal continues; see `cancel`.
            NodeShutdownError: the node is shutting down.
        """
        if not self.wait(timeout):
            raise WaitTimeoutError(f"goal {self.name} did not finish within {timeout} s ({self.stage.name})")
        return self.outcome()

    def outcome(self) -> Any:
        """Return the result of a goal that has ended; raise GoalError like `result`."""
        progress = self._progress
        if progress.status is not Status.SUCCEEDED:
            raise GoalError(self.name, progress.status, progress.text, progress.result)
        return progress.result

    def feedback(self, timeout: float | None = None) -> Iterator[Any]:
        """Iterate over the feedback messages until the goal ends; if more than 100 are queued, the oldest are dropped.

        Args:
            timeout: maximum number of seconds of wall time to wait for each message; None for no limit.

        Raises:
            WaitTimeoutError: no message arrived in time, and the goal has not ended.
            NodeShutdownError: the node is shutting down.
        """
        check_timeout(timeout)
        while True:
            if not self._client.wait(lambda: self._feedback_queue or self._progress.done, timeout):
                raise WaitTimeoutError(f"no feedback for goal {self.name} within {timeout} s")
            if not self._feedback_queue:
                return
            yield self._feedback_queue.popleft()

    @property
    def has_feedback(self) -> bool:
        """Whether a feedback message is waiting for an iteration."""
        return bool(self._feedback_queue)

    def next_feedback(self) -> Any:
        """Return the oldest waiting feedback message; raises IndexError if there is none."""
        return self._feedback_queue.popleft()

    def cancel(self) -> None:
        """Ask the server to cancel the goal, which ends when the server confirms. Do nothing if the goal has ended."""
        may_have_effect = [False]

        def request_cancel(progress: Progress) -> None:
            may_have_effect[0] = progress.ask_to_cancel()

        self.take(request_cancel)
        if may_have_effect[0]:
            self._cancel_requested_on = self._client.cancel(self.name)

    def forget(self) -> None:
        """Stop following the goal: its callbacks are no longer called, and its waits end as if the goal were lost."""
        self._on_feedback = self._on_stage = self._on_done = None
        self.take(lambda progress: progress.lose("the client has forgotten the goal"))

    def on_change(self, listener: Callable[[], object]) -> None:
        """Register a function to be called, in any thread, after each change and each feedback message."""
        self._listeners.append(listener)

    # Called in any thread ---------------------------------------------------------------------------------------------

    def take(self, change: Callable[[Progress], object]) -> None:
        """Apply a function to the progress, with the client's lock held; notify listeners if the stage has changed."""
        with self._client.lock:
            previous_stage = self._progress.stage
            change(self._progress)
            has_ended = self._progress.done and previous_stage is not Stage.DONE
        if has_ended:
            self._client.forget(self.name)
        if has_ended or self._progress.stage is not previous_stage:
            self._notify_listeners()

    def take_statuses(
        self, statuses: dict[str, Any], links: frozenset[object], asking: frozenset[object], now: float
    ) -> None:
        """Handle a list of statuses; see `Progress.handle_statuses`. Send a lost cancel request again.

        Args:
            statuses, now: see `Progress.handle_statuses`.
            links: the current links for goals and results.
            asking: the current links for cancel requests.
        """
        has_all_links = bool(self.links) and self.links <= links
        self.take(lambda progress: progress.handle_statuses(statuses, not has_all_links, now))
        requested_on = self._cancel_requested_on
        awaits_cancel_ack = self.stage is Stage.WAITING_FOR_CANCEL_ACK and self.name in statuses
        if awaits_cancel_ack and requested_on is not None and asking and not requested_on & asking:
            self._cancel_requested_on = self._client.cancel(self.name)

    def take_feedback(self, feedback: Any) -> None:
        """Handle a feedback message."""
        with self._client.lock:
            if self._progress.done:
                return
            self._feedback_queue.append(feedback)
            callback = self._on_feedback
            if callback is not None:
                self._client.queue_callback(lambda: callback(feedback))
        self._notify_listeners()

    def _on_stage_entered(self, stage: Stage) -> None:
        on_stage, on_done = self._on_stage, self._on_done
        if on_stage is not None:
            self._client.queue_callback(lambda: on_stage(self, stage))
        if stage is Stage.DONE and on_done is not None:
            self._client.queue_callback(lambda: on_done(self))

    def _notify_listeners(self) -> None:
        self._client.changed()
        for listener in self._listeners:
            listener()
