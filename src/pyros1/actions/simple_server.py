"""Server for the usual case: one goal at a time, the newest one."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.actions.errors import ActionError
from pyros1.actions.server import Server
from pyros1.actions.server_goal import ServerGoal
from pyros1.net.signal_safe import Condition
from pyros1.node.checks import check_callback

if TYPE_CHECKING:
    from pyros1.node import Node

REPLACED_TEXT = "This goal was canceled because another goal was received by the simple action server"
"""Stock's text for a waiting goal that was replaced by a newer one."""
_POLL_INTERVAL = 0.5
"""Maximum number of seconds until a shutdown of the node is noticed."""


class SimpleServer:
    """Executes one goal at a time: a new goal asks the current one to stop, and replaces a waiting one.

    ::

        def execute(goal):
            result = FibonacciResult(sequence=[0, 1])
            for _ in range(1, goal.goal.order):
                if goal.cancel_requested:
                    goal.cancel(result)
                    return None
                result.sequence = [*result.sequence, sum(result.sequence[-2:])]
            return result

        pyros1.actions.SimpleServer(node, "fibonacci", FibonacciAction, execute)

    Args:
        node: the node used for communication and time.
        name: name of the action.
        action: the action's class, or the name of its type.
        execute: called with each `ServerGoal`, in a separate thread. If it returns a result message, the goal has
            succeeded with that result; otherwise it must end the goal with ``goal.abort``, ``goal.cancel`` or
            ``goal.succeed``, and return None. The goal is aborted after an exception, or if it was not ended.
        frequency, kept: see `Server`.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        action: Any,
        execute: Callable[[ServerGoal], Any],
        *,
        frequency: float = 5.0,
        kept: float = 5.0,
    ) -> None:
        check_callback(execute, "SimpleServer(node, name, action, execute)", "execute", action)
        self._node = node
        self._execute = execute
        self._lock = threading.RLock()
        self._condition = Condition()
        self._current_goal: ServerGoal | None = None
        self._next_goal: ServerGoal | None = None
        self._closed = False
        node.on_shutdown(self._condition.notify_all)
        self._server = Server(node, name, action, self._on_goal, self._on_cancel, frequency=frequency, kept=kept)
        self.name = self._server.name
        self._thread = threading.Thread(target=self._run, name=f"pyros1-action {self.name}", daemon=True)
        self._thread.start()

    def close(self, timeout: float | None = 5.0) -> None:
        """Ask the current goal to stop, wait until it has ended, and stop the server.

        Args:
            timeout: maximum number of seconds to wait for the current goal; None for no limit.
        """
        with self._lock:  # goals that have not started by now are not executed
            self._closed = True
            current_goal = self._current_goal
        if current_goal is not None:
            current_goal.ask_to_cancel()
        self._condition.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout)
        self._server.close()

    def __enter__(self) -> SimpleServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _on_goal(self, goal: ServerGoal) -> None:
        with self._lock:
            replaced_goal, self._next_goal = self._next_goal, goal
            current_goal = self._current_goal
        if replaced_goal is not None:
            self._cancel(replaced_goal, REPLACED_TEXT)
        if current_goal is not None:
            current_goal.ask_to_cancel()
        self._condition.notify_all()

    def _on_cancel(self, goal: ServerGoal) -> None:
        with self._lock:
            is_waiting = goal is self._next_goal
            if is_waiting:
                self._next_goal = None
        if is_waiting:
            self._cancel(goal, "")

    @staticmethod
    def _cancel(goal: ServerGoal, text: str) -> None:
        if not goal.ended:
            goal.cancel(text=text)

    def _run(self) -> None:
        while self._node.ok() and not self._closed:
            self._condition.wait_for(lambda: self._next_goal or self._closed or not self._node.ok(), _POLL_INTERVAL)
            with self._lock:
                if self._closed:
                    return
                self._current_goal, self._next_goal = self._next_goal, None
            if self._current_goal is not None:
                self._execute_goal(self._current_goal)
                self._current_goal = None

    def _execute_goal(self, goal: ServerGoal) -> None:
        log = self._node.log
        try:
            goal.accept()
        except ActionError:
            return  # a client has just cancelled the goal
        result, text = None, "execute() returned without finishing the goal"
        try:
            result = self._execute(goal)
        except Exception as error:
            text = f"{type(error).__name__}: {error}"
            log.exception("error in execute() of action %s", self.name, error=error)
        else:
            if result is None and not goal.ended:
                log.warn("action %s: %s; the goal is aborted", self.name, text)
        if not self._node.ok() or goal.ended:
            return
        try:
            if result is not None:
                goal.succeed(result)
            else:
                goal.abort(text=text)
        except (ActionError, TypeError) as error:
            log.error("action %s: %s", self.name, error)
            if not goal.ended:
                goal.abort(text=str(error))
