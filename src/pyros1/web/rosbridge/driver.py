"""Drives each `Client` over its WebSocket: one task reads, one does what was read, one sends."""

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
from pyros1.web.server.threads import Threads
from pyros1.web.server.waiting import PATIENCE, wait_for_event, wait_until_over

_MOST_READ = 1 << 20
"""Bytes of frames that are read ahead; but one is, however large."""
_OF_A_FRAME = 1_000
"""Bytes that a frame costs besides its own."""
_LARGE = 1 << 20
"""Bytes of frames that take many times as much when they are unpacked: those of few clients are, at a time."""
_MOST_LARGE = 1
_AT_ONCE = 64
"""Frames that are made at a time."""
_PAUSE = 0.02
"""Seconds between looks whether the client has read what it was told."""
_START = 10.0
"""Seconds for which a client waits for the server's node, then it is told why there is none."""
_THREADS = 32
"""Threads for operations and messages of all clients."""


class Bridge:
    """All clients.

    Args:
        robot: what they may see and do.
        calls: runs their calls of services, which may take long.
    """

    def __init__(self, robot: Robot, calls: Threads) -> None:
        self._robot = robot
        self._threads = Threads(_THREADS, "web: clients")
        self._calls = calls
        self._large = asyncio.Semaphore(_MOST_LARGE)

    async def serve(self, socket: ServerConnection) -> None:
        """Serve a client until it goes."""
        await _Driver(socket, self._robot, self._threads.lane(), self._calls.lane(), self._large).run()

    def close(self) -> None:
        """Begin nothing more."""
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
        self._awake = asyncio.Event()
        self._waking = False
        self._gone = False
        self._read: deque[str | bytes] = deque()
        self._read_size = 0
        self._came = asyncio.Event()  # frames, or the client's end
        self._room = asyncio.Event()
        self._may_go_on = asyncio.Event()
        self._client = Client(robot, calls.submit, self._wake, self._go_on)

    async def run(self) -> None:
        """Serve the client until it goes."""
        tasks = [asyncio.create_task(part()) for part in (self._receive, self._work, self._send)]
        try:
            ended, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_EXCEPTION)
            for task in ended:
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
                self._read_size += len(frame) + _OF_A_FRAME
                self._came.set()
                while self._read_size > _MOST_READ:
                    self._room.clear()
                    await self._room.wait()
        self._gone = True
        self._came.set()
        self._wake()

    async def _work(self) -> None:
        deadline = monotonic() + _START
        while not (self._robot.wait(0.0) or self._gone) and monotonic() < deadline:
            await asyncio.sleep(_PAUSE)  # the first words of a client are not lost because the server's node begins
        while self._read or not self._gone:  # programs publish as the last thing they do
            self._came.clear()
            if not self._read:
                await self._came.wait()
            frames, self._read = self._read, deque()
            size, self._read_size = self._read_size, 0
            self._room.set()
            async with self._large if size > _LARGE else contextlib.nullcontext():
                done = await self._in_thread(self._client.handle, frames)
                del frames
            while not done:
                await wait_until_over(self._client.subscribing, self._may_go_on, PATIENCE)
                done = await self._in_thread(self._client.handle, ())
            while self._client.outbox.is_full() and not self._gone:  # it asks faster than it reads
                await asyncio.sleep(_PAUSE)

    def _go_on(self) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._may_go_on.set)

    async def _send(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while not self._gone:
                self._awake.clear()
                self._waking = False
                frames, made, again = await self._in_thread(self._take)
                while frames:
                    for frame in frames:
                        await self._socket.send(frame)  # a slow client is waited for here, and only here
                    frames = await self._in_thread(_some, made) if len(frames) == _AT_ONCE else []
                wait = None if again is None else max(0.0, again - monotonic())
                await wait_for_event(self._awake, wait)

    def _take(self) -> tuple[list[Frame], Iterator[Frame], float | None]:
        made, again = self._client.take(monotonic())
        return _some(made), made, again

    async def _in_thread(self, function: Callable[..., Any], *args: Any) -> Any:
        return await self._loop.run_in_executor(self._threads, function, *args)

    def _wake(self) -> None:
        if not self._waking:  # most messages come while a look is due already
            self._waking = True
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(self._awake.set)


def _some(made: Iterator[Frame]) -> list[Frame]:
    return list(islice(made, _AT_ONCE))
