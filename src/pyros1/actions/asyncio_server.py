"""Server of an action for asyncio programs."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from pyros1.actions.errors import ActionError
from pyros1.actions.server import Server
from pyros1.node.checks import check_callback

if TYPE_CHECKING:
    from pyros1.actions.server_goal import ServerGoal
    from pyros1.aio import Node


class AsyncServer:
    """Executes each goal in a separate task of the asyncio loop. Use it with ``async with``.

    ::

        async def execute(goal):
            await drive_to(goal.goal.place)
            return DriveResult()

        async with actions.AsyncServer(node, "drive", DriveAction, execute):
            ...

    Args:
        node: a :class:`pyros1.aio.Node`.
        name: name of the action.
        action: the action's class, or the name of its type.
        execute: coroutine function, called with each `ServerGoal`. If it returns a result message, the goal has
            succeeded with that result; otherwise it must end the goal itself and return None. If a client asks to
            cancel the goal, the task is cancelled; to send a result in that case, the coroutine must catch
            ``asyncio.CancelledError`` and call ``goal.cancel(result)``.
        most: maximum number of concurrent goals; further ones are rejected.
        frequency, kept: see `Server`.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        action: Any,
        execute: Callable[[ServerGoal], Awaitable[Any]],
        *,
        most: int = 16,
        frequency: float = 5.0,
        kept: float = 5.0,
    ) -> None:
        check_callback(execute, "AsyncServer(node, name, action, execute)", "execute", action)
        self._node = node
        self._execute = execute
        self._max_goals = most
        self._tasks: set[asyncio.Task[None]] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._create_server = lambda: Server(node.sync, name, action, self._on_goal, frequency=frequency, kept=kept)
        self._server: Server | None = None

    async def __aenter__(self) -> AsyncServer:
        self._loop = asyncio.get_running_loop()
        self._server = await asyncio.to_thread(self._create_server)
        return self

    async def __aexit__(self, *_: object) -> None:
        """Cancel all goals, wait until their tasks have ended, and stop the server."""
        tasks = list(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        if self._server is not None:
            await asyncio.to_thread(self._server.close)

    def _on_goal(self, goal: ServerGoal) -> None:
        assert self._loop is not None
        with suppress(RuntimeError):  # the asyncio loop is closed
            self._loop.call_soon_threadsafe(self._start_goal, goal)

    def _start_goal(self, goal: ServerGoal) -> None:
        loop = self._loop
        assert loop is not None
        try:
            if len(self._tasks) >= self._max_goals:
                goal.reject(text=f"{self._max_goals} goals are already in progress")
                return
            goal.accept()
        except ActionError:
            return  # a client has just cancelled the goal
        task = loop.create_task(self._run_goal(goal))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

        def cancel_task() -> None:
            with suppress(RuntimeError):
                loop.call_soon_threadsafe(task.cancel)

        goal.on_cancel(cancel_task)

    async def _run_goal(self, goal: ServerGoal) -> None:
        try:
            result = await self._execute(goal)
            if not goal.ended and result is None:
                goal.abort(text="execute() returned without finishing the goal")
            elif not goal.ended:
                goal.succeed(result)
        except asyncio.CancelledError:
            if not goal.ended:
                goal.cancel()
        except Exception as error:
            self._node.sync.log.exception("error in execute() of an action", error=error)
            if not goal.ended:
                goal.abort(text=f"{type(error).__name__}: {error}")
