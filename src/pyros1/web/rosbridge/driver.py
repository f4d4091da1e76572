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
"""Maximum bytes of frames that are read ahead; one frame always is, however large."""
_FRAME_OVERHEAD = 1_000
"""Memory overhead of a frame in bytes."""
_LARGE_BYTES = 1 << 20
"""Bytes above which frames are unpacked for only a few clients at a time, as that takes much more memory."""
_MAX_LARGE = 1
_BATCH_FRAMES = 64
"""Number of frames created at a time."""
_POLL_PERIOD = 0.02
"""Seconds between checks whether the client has read what it was sent."""
_START_TIMEOUT = 10.0
"""Seconds for which a client waits for the server's node before it gets an error."""
_THREADS = 32
"""Maximum number of threads for operations and messages of all clients."""


class Bridge:
    """All clients.

    Args:
        robot: the robot, with what clients may see and do.
        calls: runs their service calls, which may take long.
    """

    def __init__(self, robot: Robot, calls: ThreadPool) -> None:
        self._robot = robot
        self._threads = ThreadPool(_THREADS, "web: clients")
        self._calls = calls
        self._large = asyncio.Semaphore(_MAX_LARGE)

    async def serve(self, socket: ServerConnection) -> None:
        """Serve a client until it disconnects."""
        await _Driver(socket, self._robot, self._threads.queue(), self._calls.queue(), self._large).run()

    def close(self) -> None:
        """Start no more work."""
        self._threads.shutdown(wait=False, cancel_futures=True)


class _Driver:
    def __init__(
        self, socket: ServerConnection, robot: Robot, threads: Executor, calls: Executor, large: asyncio.Semaphore
    ) -> None:
        self._socket = socket
        self._robot = robot
        self._threads = threads
        self._large = large
        self._loop = asyncio.get_running_loop()
        self._wake_event = asyncio.Event()
        self._wake_scheduled = False
        self._disconnected = False
        self._read: deque[str | bytes] = deque()
        self._read_size = 0
        self._input_ready = asyncio.Event()  # frames, or the end of the connection
        self._input_drained = asyncio.Event()
        self._may_resume = asyncio.Event()
        self._client = Client(robot, calls.submit, self._wake, self._resume)

    async def run(self) -> None:
        """Serve the client until it disconnects."""
        tasks = [asyncio.create_task(part()) for part in (self._receive, self._work, self._send)]
        try:
            finished, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_EXCEPTION)
            for task in finished:
                task.result()  # raises if it failed; the connection ends in any case
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._in_thread(self._client.close)

    async def _receive(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            async for frame in self._socket:
                self._read.append(frame)
                self._read_size += len(frame) + _FRAME_OVERHEAD
                self._input_ready.set()
                while self._read_size > _MAX_READ_AHEAD:
                    self._input_drained.clear()
                    await self._input_drained.wait()
        self._disconnected = True
        self._input_ready.set()
        self._wake()

    async def _work(self) -> None:
        deadline = monotonic() + _START_TIMEOUT
        while not (self._robot.wait(0.0) or self._disconnected) and monotonic() < deadline:
            await asyncio.sleep(
                _POLL_PERIOD
            )  # so that a client's first frames are not lost while the server's node starts
        while self._read or not self._disconnected:  # programs may publish just before they exit
            self._input_ready.clear()
            if not self._read:
                await self._input_ready.wait()
            frames, self._read = self._read, deque()
            size, self._read_size = self._read_size, 0
            self._input_drained.set()
            async with self._large if size > _LARGE_BYTES else contextlib.nullcontext():
                done = await self._in_thread(self._client.handle, frames)
                del frames
            while not done:
                await wait_until_done(self._client.subscribing, self._may_resume, MAX_PENDING_SECONDS)
                done = await self._in_thread(self._client.handle, ())
            while self._client.outbox.is_full() and not self._disconnected:  # it requests faster than it reads
                await asyncio.sleep(_POLL_PERIOD)

    def _resume(self) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._may_resume.set)

    async def _send(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while not self._disconnected:
                self._wake_event.clear()
                self._wake_scheduled = False
                frames, frame_iterator, next_time = await self._in_thread(self._next_frames)
                while frames:
                    for frame in frames:
                        await self._socket.send(frame)  # waits here for a slow client, and only here
                    frames = await self._in_thread(_next_batch, frame_iterator) if len(frames) == _BATCH_FRAMES else []
                wait = None if next_time is None else max(0.0, next_time - monotonic())
                await wait_for_event(self._wake_event, wait)

    def _next_frames(self) -> tuple[list[Frame], Iterator[Frame], float | None]:
        frame_iterator, next_time = self._client.take(monotonic())
        return _next_batch(frame_iterator), frame_iterator, next_time

    async def _in_thread(self, function: Callable[..., Any], *args: Any) -> Any:
        return await self._loop.run_in_executor(self._threads, function, *args)

    def _wake(self) -> None:
        if not self._wake_scheduled:  # most messages arrive while a check is already scheduled
            self._wake_scheduled = True
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(self._wake_event.set)


def _next_batch(frame_iterator: Iterator[Frame]) -> list[Frame]:
    return list(islice(frame_iterator, _BATCH_FRAMES))
