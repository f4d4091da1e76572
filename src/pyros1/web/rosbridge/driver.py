"""Drives each `Client` over its WebSocket, with three tasks: one reads frames, one handles them, and one sends."""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from functools import partial
from time import monotonic
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from pyros1.web.robot import Robot
from pyros1.web.rosbridge.client import Client, DueFrames
from pyros1.web.rosbridge.shared_encodings import SharedEncodings
from pyros1.web.server.sending import (
    Frame,
    frame_size,
    keeps_up,
    send_frames,
    send_now,
    shared_transport,
    write_frames,
)
from pyros1.web.server.threads import ThreadPool
from pyros1.web.server.waiting import MAX_PENDING_SECONDS, wait_for_event, wait_until_done

_MAX_READ_AHEAD = 1 << 20
"""Maximum total size in bytes of the frames that are read ahead; at least one frame is read, whatever its size."""
_FRAME_OVERHEAD = 1_000
"""Memory overhead of a frame in bytes."""
_LARGE_INPUT_BYTES = 1 << 20
"""Size in bytes above which only one client's frames are decoded at a time, since decoding needs much more memory than
the frames.
"""
_MAX_LARGE_INPUTS = 1
_MAX_BATCH_FRAMES = 64
_BATCH_BYTES = 256 << 10
"""Size in bytes at which a batch of frames is complete. The frames of a batch are created and sent together."""
_POLL_PERIOD = 0.02
"""Seconds between checks of whether the client has read its responses."""
_START_TIMEOUT = 10.0
"""Seconds for which a client's first frames wait for the server's node before they cause an error."""
_MAX_THREADS = 32
"""Maximum number of threads that handle the operations and messages of all clients."""


class Bridge:
    """Serves all rosbridge clients.

    Args:
        robot: the robot, with the access rules for clients.
        call_threads: run the clients' service calls, which may take a long time.
        on_refusal: called, from any thread, with the text of each error sent to a client.
    """

    def __init__(
        self, robot: Robot, call_threads: ThreadPool, on_refusal: Callable[[str], object] = lambda text: None
    ) -> None:
        self._robot = robot
        self._on_refusal = on_refusal
        self._threads = ThreadPool(_MAX_THREADS, "web: clients")
        self._call_threads = call_threads
        self._large_input_slots = asyncio.Semaphore(_MAX_LARGE_INPUTS)
        self._shared_encodings = SharedEncodings()

    async def serve(self, connection: ServerConnection) -> None:
        """Serve a client until it disconnects."""
        self._shared_encodings.add_client()
        try:
            await _Driver(
                connection,
                self._robot,
                self._threads.queue(),
                self._call_threads.queue(),
                self._large_input_slots,
                self._shared_encodings,
                self._on_refusal,
            ).run()
        finally:
            self._shared_encodings.remove_client()

    def close(self) -> None:
        """Cancel tasks that have not started, and accept no more."""
        self._threads.shutdown(wait=False, cancel_futures=True)


class _Driver:
    def __init__(
        self,
        connection: ServerConnection,
        robot: Robot,
        threads: Executor,
        call_threads: Executor,
        large_input_slots: asyncio.Semaphore,
        shared_encodings: SharedEncodings,
        on_refusal: Callable[[str], object],
    ) -> None:
        self._connection = connection
        self._robot = robot
        self._threads = threads
        self._large_input_slots = large_input_slots
        self._loop = asyncio.get_running_loop()
        self._wake_event = asyncio.Event()
        self._wake_scheduled = False
        self._due_frames: DueFrames | None = None  # taken by _on_wake, but not sent
        self._send_error: Exception | None = None  # raised in _on_wake
        self._is_send_idle = False  # the sending task waits for _wake_event
        self._disconnected = False
        self._input: deque[str | bytes] = deque()
        self._input_size = 0
        self._input_ready = asyncio.Event()  # frames were received, or the connection has ended
        self._input_drained = asyncio.Event()
        self._may_resume = asyncio.Event()
        transport = shared_transport(connection)
        self._client = Client(
            robot,
            call_threads.submit,
            self._wake,
            self._resume,
            shared_encodings,
            None if transport is None else partial(send_now, transport),
            self._on_fault,
            on_refusal,
        )

    async def run(self) -> None:
        """Serve the client until it disconnects."""
        tasks = [asyncio.create_task(work()) for work in (self._receive, self._handle, self._send)]
        try:
            finished, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_EXCEPTION)
            for task in finished:
                task.result()  # raises the error if the task failed; the connection ends in any case
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
        # A client's first frames must not be lost while the server's node starts.
        while not (self._robot.wait_for_node(0.0) or self._disconnected) and monotonic() < deadline:
            await asyncio.sleep(_POLL_PERIOD)
        # Frames are handled even after the client has disconnected: programs may publish just before they exit.
        while self._input or not self._disconnected:
            self._input_ready.clear()
            if not self._input:
                await self._input_ready.wait()
            frames, self._input = self._input, deque()
            size, self._input_size = self._input_size, 0
            self._input_drained.set()
            async with self._large_input_slots if size > _LARGE_INPUT_BYTES else contextlib.nullcontext():
                is_done = await self._run_in_thread(self._client.handle, frames)
                del frames
            while not is_done:
                await wait_until_done(self._client.pending_subscriptions, self._may_resume, MAX_PENDING_SECONDS)
                is_done = await self._run_in_thread(self._client.handle, ())
            # Wait while the client sends requests faster than it reads responses.
            while self._client.outbox.is_full() and not self._disconnected:
                await asyncio.sleep(_POLL_PERIOD)

    def _resume(self) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(self._may_resume.set)

    async def _send(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while not self._disconnected:
                if self._send_error is not None:
                    raise self._send_error
                if self._due_frames is not None:
                    due, self._due_frames = self._due_frames, None
                    await self._send_due(due)
                    continue  # check for a disconnection before clearing the event, which would hide it
                self._wake_event.clear()
                self._wake_scheduled = False
                due = self._client.take(monotonic())
                await self._send_due(due)
                if due.next_time is None:
                    self._release()
                    self._is_send_idle = True
                    await self._wake_event.wait()
                    self._is_send_idle = False
                else:
                    await wait_for_event(self._wake_event, max(0.0, due.next_time - monotonic()))

    async def _send_due(self, due: DueFrames) -> None:
        while batch := (
            # Using another thread would take longer than creating frames that are created quickly.
            _next_batch(due.frames) if due.is_quick else await self._run_in_thread(_next_batch, due.frames)
        ):
            await send_frames(self._connection, batch)  # the only wait for a slow client

    def _on_wake(self) -> None:
        """Send due frames; called in the loop's thread.

        As long as the client keeps up, frames are sent here, since waking the sending task would double the time.
        """
        is_idle = self._is_send_idle and not self._wake_event.is_set() and not self._disconnected
        if is_idle and keeps_up(self._connection):
            self._wake_scheduled = False
            try:
                due = self._client.take(monotonic())
                if due.is_quick:
                    write_frames(self._connection, due.frames)
                    if due.next_time is None:
                        self._release()
                        return
                else:
                    self._due_frames = due
            except Exception as error:  # noqa: BLE001 - a bug, for which the sending task ends the connection
                self._send_error = error
        self._wake_event.set()

    def _release(self) -> None:
        """Let messages be sent from the threads in which they arrive, if the client has received everything."""
        if keeps_up(self._connection):
            self._client.outbox.release()

    def _on_fault(self, error: Exception) -> None:
        self._send_error = error
        with contextlib.suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(self._wake_event.set)

    async def _run_in_thread(self, function: Callable[..., Any], *args: Any) -> Any:
        return await self._loop.run_in_executor(self._threads, function, *args)

    def _wake(self) -> None:
        if not self._wake_scheduled:  # most messages arrive while a check is already scheduled
            self._wake_scheduled = True
            with contextlib.suppress(RuntimeError):  # the loop is closed
                self._loop.call_soon_threadsafe(self._on_wake)


def _next_batch(frames: Iterator[Frame]) -> list[Frame]:
    """Return the next frames, limited in number and size; an empty list if there are none."""
    batch: list[Frame] = []
    size = 0
    for frame in frames:
        batch.append(frame)
        size += frame_size(frame)
        if len(batch) == _MAX_BATCH_FRAMES or size >= _BATCH_BYTES:
            break
    return batch
