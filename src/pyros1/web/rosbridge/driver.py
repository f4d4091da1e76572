"""Drives each `Client` over its WebSocket: one task reads, one handles what was read, one sends."""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from itertools import islice
from time import monotonic
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from pyros1.web.robot import Robot
from pyros1.web.rosbridge.client import Client
from pyros1.web.rosbridge.outbox import Frame
from pyros1.web.server.threads import ThreadPool
from pyros1.web.server.waiting import MAX_PENDING_SECONDS, wait_for_event, wait_until_done

_MAX_READ_AHEAD = 1 << 20
"""Maximum number of bytes of frames that are read ahead; one frame of any size is always read."""
_FRAME_OVERHEAD = 1_000
"""Memory overhead of a frame in bytes."""
_LARGE_INPUT_BYTES = 1 << 20
"""Size in bytes above which frames are decoded for one client at a time, since decoding them needs much more memory."""
_MAX_LARGE_INPUTS = 1
_BATCH_FRAMES = 64
"""Number of frames created at a time."""
_POLL_PERIOD = 0.02
"""Seconds between checks for whether the client has read its responses."""
_START_TIMEOUT = 10.0
"""Seconds for which a client waits for the server's node before it receives an error."""
_MAX_THREADS = 32
"""Maximum number of threads for operations and messages of all clients."""


class Bridge:
    """Serves all clients.

    Args:
        robot: the robot, with the access rules for clients.
        calls: runs the clients' service calls, which may take long.
    """

    def __init__(self, robot: Robot, calls: ThreadPool) -> None:
        self._robot = robot
        self._threads = ThreadPool(_MAX_THREADS, "web: clients")
        self._calls = calls
        self._large_input_slots = asyncio.Semaphore(_MAX_LARGE_INPUTS)

    async def serve(self, connection: ServerConnection) -> None:
        """Serve a client until it disconnects."""
        await _Driver(
            connection, self._robot, self._threads.queue(), self._calls.queue(), self._large_input_slots
        ).run()

    def close(self) -> None:
        """Stop starting new tasks."""
        self._threads.shutdown(wait=False, cancel_futures=True)


class _Driver:
    def __init__(
        self,
        connection: ServerConnection,
        robot: Robot,
        threads: Executor,
        calls: Executor,
        large_input_slots: asyncio.Semaphore,
    ) -> None:
        self._connection = connection
        self._robot = robot
        self._threads = threads
        self._large_input_slots = large_input_slots
        self._loop = asyncio.get_running_loop()
        self._wake_event = asyncio.Event()
        self._wake_scheduled = False
        self._disconnected = False
        self._input: deque[str | bytes] = deque()
        self._input_size = 0
        self._input_ready = asyncio.Event()  # frames were received, or the connection has ended
        self._input_drained = asyncio.Event()
        self._may_resume = asyncio.Event()
        self._client = Client(robot, calls.submit, self._wake, self._resume)

    async def run(self) -> None:
        """Serve the client until it disconnects."""
        tasks = [asyncio.create_task(work()) for work in (self._receive, self._handle, self._send)]
        try:
            finished, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_EXCEPTION)
            for task in finished:
                task.result()  # raises if the task failed; the connection ends in any case
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._run_in_thread(self._client.close)

    async def _receive(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            async for frame in self._connection:
                self._input.append(frame)
                self._input_size += len(frame) + _FRAME_OVERHEAD
                self._input_ready.set()
                while self._input_size > _MAX_READ_AHEAD:
                    self._input_drained.clear()
                    await self._input_drained.wait()
        self._disconnected = True
        self._input_ready.set()
        self._wake()

    async def _handle(self) -> None:
        deadline = monotonic() + _START_TIMEOUT
        while not (self._robot.wait(0.0) or self._disconnected) and monotonic() < deadline:
            await asyncio.sleep(
                _POLL_PERIOD
            )  # so that a client's first frames are not lost while the server's node starts
        while self._input or not self._disconnected:  # programs may publish just before they exit
            self._input_ready.clear()
            if not self._input:
                await self._input_ready.wait()
            frames, self._input = self._input, deque()
            size, self._input_size = self._input_size, 0
            self._input_drained.set()
            async with self._large_input_slots if size > _LARGE_INPUT_BYTES else contextlib.nullcontext():
                done = await self._run_in_thread(self._client.handle, frames)
                del frames
            while not done:
                await wait_until_done(self._client.subscribing, self._may_resume, MAX_PENDING_SECONDS)
                done = await self._run_in_thread(self._client.handle, ())
            while (
                self._client.outbox.is_full() and not self._disconnected
            ):  # the client sends requests faster than it reads responses
                await asyncio.sleep(_POLL_PERIOD)

    def _resume(self) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(self._may_resume.set)

    async def _send(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while not self._disconnected:
                self._wake_event.clear()
                self._wake_scheduled = False
                frames, frame_iterator, next_time = await self._run_in_thread(self._next_frames)
                while frames:
                    for frame in frames:
                        await self._connection.send(frame)  # the only wait for a slow client
                    frames = (
                        await self._run_in_thread(_next_batch, frame_iterator) if len(frames) == _BATCH_FRAMES else []
                    )
                timeout = None if next_time is None else max(0.0, next_time - monotonic())
                await wait_for_event(self._wake_event, timeout)

    def _next_frames(self) -> tuple[list[Frame], Iterator[Frame], float | None]:
        frame_iterator, next_time = self._client.take(monotonic())
        return _next_batch(frame_iterator), frame_iterator, next_time

    async def _run_in_thread(self, function: Callable[..., Any], *args: Any) -> Any:
        return await self._loop.run_in_executor(self._threads, function, *args)

    def _wake(self) -> None:
        if not self._wake_scheduled:  # most messages arrive while a check is already scheduled
            self._wake_scheduled = True
            with contextlib.suppress(RuntimeError):  # the loop is closed
                self._loop.call_soon_threadsafe(self._wake_event.set)


def _next_batch(frame_iterator: Iterator[Frame]) -> list[Frame]:
    return list(islice(frame_iterator, _BATCH_FRAMES))
