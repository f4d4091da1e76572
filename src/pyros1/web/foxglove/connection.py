"""Drives a `StateMachine` over a WebSocket.

This module reads requests, and runs tasks that send messages and the time, and look for new topics and services.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import Callable, Coroutine, Iterable
from concurrent.futures import Executor
from functools import partial
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from pyros1 import __version__
from pyros1.ground.errors import Error
from pyros1.web.foxglove import frames, requests, state_machine, viewer_actions
from pyros1.web.foxglove.frames import Frame, Level
from pyros1.web.foxglove.offers import Channel
from pyros1.web.foxglove.outbox import Outbox, QueuedMessage
from pyros1.web.foxglove.state_machine import Action, StateMachine
from pyros1.web.foxglove.viewer_context import ViewerContext
from pyros1.web.hub import Arrival
from pyros1.web.server.sending import LargeFrame, keeps_up, send_frames, send_now, shared_transport
from pyros1.web.server.waiting import MAX_PENDING_SECONDS, PendingOperations, wait_for_event, wait_until_done
from pyros1.web.service_calls import ServiceCalls

_POLL_PERIOD = 1.0
"""Seconds between checks for new topics and services."""
_TIME_PERIOD = 0.02
"""Seconds between frames with simulated time."""
_BATCH_BYTES = 64 << 10
"""Size in bytes after which no more messages are taken from the outbox at a time."""
_MAX_JOBS = 100
"""Maximum number of pending jobs (service calls and file requests) per viewer."""
_MAX_CONCURRENT_JOBS = 4
"""Maximum number of jobs per viewer that run concurrently."""
_MAX_UNSENT_BYTES = 1 << 20
"""Maximum number of bytes that the operating system buffers for a slow connection. Buffered messages become stale, as
they can no longer be replaced by newer messages."""
_MAX_MISMATCHED_PUBLISHERS = 1_000
REPORT_PERIOD = 2.0
"""Seconds after which a publisher whose definition differs from its channel's is reported to the catalogue again."""


class Viewer:
    """A viewer's connection.

    Args:
        connection: the viewer's WebSocket.
        context: the state shared by all viewers.
        short_task_threads: run short tasks, such as publishing.
        long_task_threads: run tasks that wait for the master.
        service_threads: run service calls.
    """

    def __init__(
        self,
        connection: ServerConnection,
        context: ViewerContext,
        short_task_threads: Executor,
        long_task_threads: Executor,
        service_threads: Executor,
    ) -> None:
        self._connection = connection
        self._context = context
        self._robot = context.robot
        self._short_task_threads = short_task_threads
        self._long_task_threads = long_task_threads
        self._service_threads = service_threads
        self._service_calls = ServiceCalls()
        self._loop = asyncio.get_running_loop()
        self._machine = StateMachine(self._robot.access.read_only)
        self._machine_lock = asyncio.Lock()  # guards the machine and its actions
        self._outbox = Outbox(wake=self._wake)
        self._transport = shared_transport(connection)
        self._subscriptions: dict[int, int] = {}  # the outbox's ticket -> the viewer's id of the subscription
        self._unsubscribers: dict[int, Callable[[], None]] = {}  # by subscription
        self._publishers = viewer_actions.Publishers(context)
        self._jobs: set[asyncio.Task[None]] = set()
        self._job_slots = asyncio.Semaphore(_MAX_CONCURRENT_JOBS)
        self._subscriptions_settled = asyncio.Event()
        self._pending_subscriptions = PendingOperations(lambda: self._call_soon(self._subscriptions_settled.set))
        self._messages_available = asyncio.Event()
        self._wake_scheduled = False
        self._offers_may_have_changed = asyncio.Event()
        self._mismatched_publishers: dict[tuple[int, str, str], float] = {}  # values: when they were last reported
        self._announced_simulated_time = False

    async def run(self) -> None:
        """Serve the viewer until it disconnects."""
        self._limit_send_buffer()
        tasks: list[asyncio.Task[None]] = []
        try:
            await self._run_long_task(self._robot.wait_for_node, _POLL_PERIOD)
            await self._send_hello()
            tasks = [
                asyncio.create_task(each) for each in (self._push_offers(), self._send_messages(), self._send_time())
            ]
            for task in tasks:
                task.add_done_callback(self._end_if_failed)
            async for frame in self._connection:
                async with self._machine_lock:
                    await self._perform_all(*self._machine.handle(frame))
        except ConnectionClosed:
            pass
        finally:
            self._service_calls.close()
            for task in (*tasks, *self._jobs):
                task.cancel()
            await asyncio.gather(*tasks, *self._jobs, return_exceptions=True)
            async with self._machine_lock:
                await self._run_short_task(self._clean_up)

    def _end_if_failed(self, task: asyncio.Task[None]) -> None:
        """End the connection if a task has failed, which is a bug: the viewer must not wait for messages in vain."""
        if not task.cancelled() and task.exception() is not None:
            self._start_job(self._connection.close(1011))

    def _limit_send_buffer(self) -> None:
        option = getattr(socket, "TCP_NOTSENT_LOWAT", None)
        if option is not None:
            with contextlib.suppress(OSError, AttributeError):
                self._connection.transport.get_extra_info("socket").setsockopt(
                    socket.IPPROTO_TCP, option, _MAX_UNSENT_BYTES
                )

    def _uses_simulated_time(self) -> bool:
        try:
            return self._robot.node.simulated_time
        except Error:
            return False

    async def _send_hello(self) -> None:
        self._announced_simulated_time = self._uses_simulated_time()
        name = f"pyros1 {__version__}, {self._robot.master_uri}"
        await self._send(self._machine.hello(name, self._context.session, self._announced_simulated_time))

    def _clean_up(self) -> None:
        for unsubscribe in list(self._unsubscribers.values()):
            unsubscribe()
        self._publishers.close()

    # Outgoing ---------------------------------------------------------------------------------------------------------

    async def _send(self, outgoing: list[Frame]) -> None:
        await send_frames(self._connection, outgoing)

    async def _send_messages(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while True:
                self._messages_available.clear()
                self._wake_scheduled = False
                while messages := self._outbox.take(_BATCH_BYTES):
                    await send_frames(
                        self._connection, self._message_frames(messages)
                    )  # waits while the viewer is slow
                    await asyncio.sleep(0)  # lets other tasks run
                if keeps_up(self._connection):
                    self._outbox.release()
                await self._messages_available.wait()

    def _message_frames(self, messages: Iterable[QueuedMessage]) -> list[bytes | LargeFrame]:
        return [
            frames.message(subscription, each.time, each.payload)
            for each in messages
            # the subscription may have ended meanwhile
            if (subscription := self._subscriptions.get(each.ticket)) is not None
        ]

    def _put(self, message: QueuedMessage) -> None:
        """Send a message immediately, in the thread in which it has arrived, if nothing else is to be sent."""
        transport = self._transport
        if not self._outbox.put(message, transport is not None and self._outbox.is_free) or transport is None:
            return
        is_sent = False
        try:
            is_sent = send_now(transport, self._message_frames((message,)))
        except Exception:  # noqa: BLE001 - must not end the topic's thread; the loop tries again, and ends the connection
            pass
        finally:
            self._outbox.end_sending(None if is_sent else message)

    async def _send_time(self) -> None:
        last_time = -1
        with contextlib.suppress(ConnectionClosed):
            while True:
                if self._announced_simulated_time:
                    now = self._robot.node.now()
                    nanoseconds = now.secs * 1_000_000_000 + now.nsecs
                    if nanoseconds != last_time:
                        last_time = nanoseconds
                        await self._connection.send(frames.time(nanoseconds))
                await asyncio.sleep(_TIME_PERIOD if self._announced_simulated_time else _POLL_PERIOD)

    async def _push_offers(self) -> None:
        """Keep the viewer informed about the available topics and services."""
        with contextlib.suppress(ConnectionClosed):
            while True:
                self._offers_may_have_changed.clear()
                try:
                    if await self._push_offers_once():
                        continue
                except Error as error:
                    await self._send(self._machine.update_problems({"master": str(error)}))
                await wait_for_event(self._offers_may_have_changed, _POLL_PERIOD)

    async def _push_offers_once(self) -> bool:
        """Tell the viewer what has changed; return whether to check again immediately."""
        _ = self._robot.node
        if self._uses_simulated_time() != self._announced_simulated_time:
            await self._send_hello()  # the master was started after the viewer had connected
        catalogue = self._context.catalogue
        offers = await self._run_long_task(catalogue.current_offers, _POLL_PERIOD * 0.8)
        async with self._machine_lock:
            await self._perform_all(*self._machine.update_offers(offers))
        if offers.has_pending_queries:
            await self._run_long_task(catalogue.query_nodes)
            return True
        if self._machine.watches_parameters:
            values = await self._run_long_task(self._context.parameters, _POLL_PERIOD * 0.8)
            await self._send(self._machine.update_parameters(values))
        return False

    # Incoming ---------------------------------------------------------------------------------------------------------

    async def _perform_all(self, actions: list[Action], response: list[Frame]) -> None:
        for action in actions:
            if self._pending_subscriptions and not isinstance(action, state_machine.Listen):
                await wait_until_done(self._pending_subscriptions, self._subscriptions_settled, MAX_PENDING_SECONDS)
            try:
                await self._send(await self._perform(action))
            except Error as error:
                await self._send([frames.status(Level.ERROR, str(error), _status_id(action))])
        await self._send(response)

    async def _perform(self, action: Action) -> list[Frame]:
        """Perform an action that the machine requests; return the response's frames."""
        match action:
            case state_machine.Listen(subscription, channel):
                await self._listen(subscription, channel)
            case state_machine.StopListening(subscription):
                await self._run_short_task(self._unsubscribers[subscription])
                del self._unsubscribers[subscription]
            case state_machine.Advertise(channel):
                await self._run_short_task(self._publishers.advertise, channel)
            case state_machine.Publish(channel, payload):
                await self._run_short_task(self._publishers.publish, channel, payload)
            case state_machine.Unadvertise(channel):
                await self._run_short_task(self._publishers.unadvertise, channel)
            case state_machine.Call():
                if len(self._jobs) >= _MAX_JOBS:
                    return [frames.service_failure(action.service.id, action.call, "too many calls at once")]
                self._start_job(
                    self._run_job(
                        self._service_threads, partial(viewer_actions.call_service, self._service_calls), action
                    )
                )
            case requests.FetchAsset():
                if len(self._jobs) >= _MAX_JOBS:
                    return [frames.asset_failure(action.id, "too many files at once")]
                self._start_job(self._run_job(self._long_task_threads, viewer_actions.fetch, action))
            case requests.GetParameters():
                return list(await self._run_long_task(viewer_actions.get_parameters, self._context, action))
            case requests.SetParameters():
                return list(await self._run_long_task(viewer_actions.set_parameters, self._context, action))
            case requests.WatchParameters(names):
                return self._machine.watch(names, await self._run_long_task(self._context.parameters, 0.0))
        return []

    async def _listen(self, subscription: int, channel: Channel) -> None:
        # The last accepted header. Each connection has its own header object, so comparing with `is` suffices.
        accepted_header: dict[str, str] | None = None
        latched_by: str | None = None

        def on_arrival(arrival: Arrival) -> None:
            nonlocal accepted_header, latched_by
            header = arrival.raw._connection_header or {}
            if header is not accepted_header:
                if not channel.carries(header):
                    self._report_mismatch(channel, header, arrival.arrived_at)
                    return
                accepted_header = header
                latched_by = header.get("callerid", "") if header.get("latching") == "1" else None
            self._put(
                QueuedMessage(
                    ticket, frames.nanoseconds(arrival.time), arrival.raw._buff, latched_by, arrival.arrived_at
                )
            )

        def unsubscribe() -> None:
            self._subscriptions.pop(ticket, None)
            self._outbox.close(ticket)
            stop_listening()

        ticket = self._outbox.open()
        self._subscriptions[ticket] = subscription
        done = self._pending_subscriptions.begin()
        try:
            stop_listening = await self._run_short_task(self._robot.listen, channel.topic, on_arrival, done)
        except Error:
            done()
            self._outbox.close(ticket)
            self._machine.remove_subscription(subscription)
            raise
        self._unsubscribers[subscription] = unsubscribe

    def _report_mismatch(self, channel: Channel, header: dict[str, str], now: float) -> None:
        """Tell the catalogue about a publisher whose header does not match the channel.

        Called for each message with such a header; reports each publisher and MD5 sum once per REPORT_PERIOD.
        """
        mismatch = (channel.id, header.get("callerid", ""), header.get("md5sum", ""))
        last_time = self._mismatched_publishers.get(mismatch, now - REPORT_PERIOD)
        if now >= last_time + REPORT_PERIOD and (
            mismatch in self._mismatched_publishers or len(self._mismatched_publishers) < _MAX_MISMATCHED_PUBLISHERS
        ):
            self._mismatched_publishers[mismatch] = now
            self._context.catalogue.add_header(channel, header)
            self._call_soon(self._offers_may_have_changed.set)

    def _start_job(self, job: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(job)
        self._jobs.add(task)
        task.add_done_callback(self._jobs.discard)

    async def _run_job(self, threads: Executor, function: Callable[[ViewerContext, Any], Frame], action: Any) -> None:
        with contextlib.suppress(ConnectionClosed):
            async with self._job_slots:  # until the frame, which may be large, has been sent
                frame = await self._loop.run_in_executor(threads, function, self._context, action)
                await self._connection.send(frame)

    async def _run_short_task(self, function: Callable[..., Any], *args: Any) -> Any:
        return await self._loop.run_in_executor(self._short_task_threads, function, *args)

    async def _run_long_task(self, function: Callable[..., Any], *args: Any) -> Any:
        return await self._loop.run_in_executor(self._long_task_threads, function, *args)

    def _wake(self) -> None:
        if not self._wake_scheduled:
            self._wake_scheduled = True
            self._call_soon(self._messages_available.set)

    def _call_soon(self, function: Callable[[], object]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(function)


def _status_id(action: Action) -> str | None:
    """Return the id for the status that reports an action's problem; None for no id.

    When a viewer publishes often, a new status with the same id replaces the last one.
    """
    match action:
        case state_machine.Advertise(channel) | state_machine.Publish(channel):
            return f"publish {channel.id}"
    return None
