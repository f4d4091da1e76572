"""Client of an action for asyncio programs."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from pyros1.actions.client import Client
from pyros1.actions.states import Stage, Status
from pyros1.ground.errors import WaitTimeoutError
from pyros1.node.checks import check_timeout

if TYPE_CHECKING:
    from pyros1.actions.client_goal import ClientGoal
    from pyros1.aio import Node

_POLL_INTERVAL = 0.5
"""Maximum number of seconds until a shutdown of the node or the server is noticed."""


class AsyncGoal:
    """A goal that an `AsyncClient` has sent; see `ClientGoal`."""

    def __init__(self, goal: ClientGoal, client: Client) -> None:
        self._goal = goal
        self._client = client
        self._changed = asyncio.Event()
        loop = asyncio.get_running_loop()

        def wake() -> None:
            with suppress(RuntimeError):  # the asyncio loop is closed
                loop.call_soon_threadsafe(self._changed.set)

        goal.on_change(wake)

    @property
    def name(self) -> str:
        """The goal's name, unique in the ROS system."""
        return self._goal.name

    @property
    def stage(self) -> Stage:
        """The goal's stage as known to this client."""
        return self._goal.stage

    @property
    def status(self) -> Status:
        """The server's latest status."""
        return self._goal.status

    @property
    def text(self) -> str:
        """The message that the server sent with its latest status."""
        return self._goal.text

    @property
    def done(self) -> bool:
        """Whether the goal has ended."""
        return self._goal.done

    async def wait(self, timeout: float | None = None) -> bool:
        """Wait until the goal has ended; return whether it has. See `ClientGoal.wait`."""
        check_timeout(timeout)
        return await self._wait_until(lambda: self._goal.done, timeout)

    async def result(self, timeout: float | None = None) -> Any:
        """Wait for the result and return it; raises the same errors as `ClientGoal.result`."""
        if not await self.wait(timeout):
            raise WaitTimeoutError(f"goal {self.name} did not finish within {timeout} s ({self.stage.name})")
        return self._goal.outcome()

    async def feedback(self, timeout: float | None = None) -> AsyncIterator[Any]:
        """Iterate over the feedback messages until the goal ends; see `ClientGoal.feedback`."""
        check_timeout(timeout)
        goal = self._goal
        while True:
            if not await self._wait_until(lambda: goal.has_feedback or goal.done, timeout):
                raise WaitTimeoutError(f"no feedback for goal {self.name} within {timeout} s")
            if not goal.has_feedback:
                return
            yield goal.next_feedback()

    def cancel(self) -> None:
        """Ask the server to cancel the goal; does not wait."""
        self._goal.cancel()

    def forget(self) -> None:
        """Stop following the goal; see `ClientGoal.forget`."""
        self._goal.forget()

    async def _wait_until(self, predicate: Callable[[], object], timeout: float | None) -> bool:
        loop = asyncio.get_running_loop()
        deadline = None if timeout is None else loop.time() + timeout
        while True:
            self._changed.clear()  # before the check, or a change in between would be missed
            if predicate():
                return True
            self._client.watch()
            remaining = _POLL_INTERVAL if deadline is None else min(_POLL_INTERVAL, deadline - loop.time())
            if remaining <= 0:
                return False
            with suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._changed.wait(), remaining)


class AsyncClient:
    """Client of an action for asyncio programs. Use it with ``async with``.

    ::

        async with actions.AsyncClient(node, "fibonacci", FibonacciAction) as client:
            goal = await client.send(FibonacciGoal(order=5))
            async for feedback in goal.feedback():
                print(feedback.sequence)
            print((await goal.result()).sequence)

    Args:
        node: a :class:`pyros1.aio.Node`.
        name: name of the action.
        action: the action's class, or the name of its type.
    """

    def __init__(self, node: Node, name: str, action: Any) -> None:
        self._create_client = lambda: Client(node.sync, name, action)
        self._client: Client | None = None

    async def __aenter__(self) -> AsyncClient:
        self._client = await asyncio.to_thread(self._create_client)
        return self

    async def __aexit__(self, *_: object) -> None:
        if self._client is not None:
            await asyncio.to_thread(self._client.close)

    @property
    def sync(self) -> Client:
        """The underlying client.

        Raises:
            RuntimeError: ``async with`` was not entered.
        """
        if self._client is None:
            raise RuntimeError("use the client with: async with AsyncClient(...) as client")
        return self._client

    async def wait_for_server(self, timeout: float | None = None) -> bool:
        """Wait until a server is connected; return whether one is. See `Client.wait_for_server`."""
        client = self.sync
        return client.is_connected or await asyncio.to_thread(client.wait_for_server, timeout)

    async def send(self, goal: Any, *, timeout: float | None = 5.0) -> AsyncGoal:
        """Send a goal and return its handle; see `Client.send`."""
        client = self.sync
        if not client.is_connected:
            await asyncio.to_thread(client.wait_for_server, timeout)
        return AsyncGoal(client.send(goal, timeout=0.0), client)

    def cancel_all(self) -> None:
        """Ask the server to cancel all its goals, including those of other clients; does not wait."""
        self.sync.cancel_all()
