"""A node for asyncio programs."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine
from types import TracebackType
from typing import Any, TypeVar
from weakref import WeakSet

from pyros1.aio.driver import LoopDriver, can_drive
from pyros1.aio.messages import Messages
from pyros1.aio.watching import Sightings
from pyros1.ground.errors import Error, NodeShutdownError, WaitTimeoutError
from pyros1.ground.timing import Time
from pyros1.msgs import Service
from pyros1.net.signal_safe import POLL_INTERVAL
from pyros1.node import Node as SyncNode
from pyros1.node.checks import check_callback, check_name, check_queue_size, check_timeout, require_message_class
from pyros1.node.publishing.publisher import Publisher
from pyros1.node.services.client import ServiceClient
from pyros1.node.services.server import ServiceServer
from pyros1.node.signals import SignalHandlers
from pyros1.node.subscribing.hints import Hints
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.node.subscribing.threads import Driver
from pyros1.node.watching.liveness import Sighting
from pyros1.node.watching.watch import Watch

_M = TypeVar("_M")
_R = TypeVar("_R")


GRACE_PERIOD = 0.5
"""Seconds that the body of ``async with`` has to finish on its own after a signal has shut down the node."""
_INTERRUPTED_EXIT_CODE = 130


class _Signals(SignalHandlers):
    """Signal handlers that replace asyncio's, which cancel the main task and print a KeyboardInterrupt.

    A second signal ends the program from within the asyncio loop, so that tasks are cancelled properly; a third one
    ends the program immediately.
    """

    loop: asyncio.AbstractEventLoop | None = None

    def _is_default(self, handler: Any) -> bool:
        runner = getattr(getattr(handler, "func", None), "__self__", None)
        return super()._is_default(handler) or type(runner).__module__ == "asyncio.runners"

    def _interrupt(self, number: int) -> None:
        if self.count == 2 and self.loop is not None and self.loop.is_running():
            self.loop.call_soon_threadsafe(self._exit, number)
        else:
            self._exit(number)

    @staticmethod
    def _exit(number: int) -> None:
        raise SystemExit(128 + number)


def _no_callback(message: object) -> None:
    """Do nothing. This is the callback of subscribers whose messages a stream receives."""


class _UnderlyingNode(SyncNode):
    """The underlying node, which can be shut down even before it has contacted its master.

    Args:
        on_created: called with this node as soon as it can be shut down.
        options: see :class:`pyros1.Node`.
    """

    def __init__(self, on_created: Callable[[SyncNode], None], name: str, **options: Any) -> None:
        self._on_created = on_created
        super().__init__(name, **options)

    def _open(self, *args: Any) -> None:
        self._on_created(self)
        super()._open(*args)

    def subscribe_stream(
        self,
        topic: str,
        type: Any,
        stream: Messages[Any],
        queue_size: int | None,
        tcp_nodelay: bool,
        driver: Driver | None,
    ) -> Subscriber[Any]:
        """Subscribe to a topic, with a stream that receives the messages; see :meth:`Node.subscribe`."""
        cls = require_message_class(type, "subscribe")
        hints = Hints(tcp_nodelay=tcp_nodelay)
        return self._topics.subscribe(
            self.resolve(topic), cls, _no_callback, queue_size, hints, stream=stream, driver=driver
        )

    def begin_watch(self, name: str, period: float, limit: float, notify: Callable[[Sighting], None]) -> Watch:
        """Start to watch another node, and return the watch; see :meth:`Node.watch`."""
        check_name(name, "watch(name)")
        return self._watches.begin(self.resolve(name), period, limit, notify)


class Node:
    """A ROS node for asyncio programs. Use it with ``async with``.

    Args:
        name: see :class:`pyros1.Node`.
        handle_signals: whether SIGINT and SIGTERM shut the node down and end the body of ``async with``, which is
            cancelled if it does not finish on its own within half a second. Only possible in the main thread.
        options: all other keyword arguments of :class:`pyros1.Node` except ``callbacks``.
    """

    def __init__(self, name: str, *, handle_signals: bool = True, **options: Any) -> None:
        if "callbacks" in options:
            raise TypeError("pyros1.aio.Node does not accept callbacks=: receive messages with async for")
        self._create_node: Callable[[], _UnderlyingNode] = lambda: _UnderlyingNode(
            self._on_created, name, handle_signals=False, **options
        )
        self._signals = _Signals(self._on_signal) if handle_signals else None
        self._cancel_timer: asyncio.TimerHandle | None = None  # cancels the body of ``async with``
        self._signal_timer: asyncio.TimerHandle | None = None
        self._is_body_cancelled = False
        self._starting_node: SyncNode | None = None
        self._node: _UnderlyingNode | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._message_streams: WeakSet[Messages[Any]] = WeakSet()
        self._sightings: WeakSet[Sightings] = WeakSet()
        self._driver: LoopDriver | None = None

    async def __aenter__(self) -> Node:
        self._loop = asyncio.get_running_loop()
        self._task = asyncio.current_task()
        if self._signals is not None:
            self._signals.loop = self._loop
            self._signals.install()
            self._poll_signals()
        try:
            self._node = await asyncio.to_thread(self._create_node)
        except BaseException as error:
            if self._starting_node is not None:
                # A cancellation does not stop the thread that creates the node.
                self._request_shutdown("startup was cancelled")
            if self._signals is not None:
                self._stop_polling_signals()
                self._signals.restore()
                if self._signals.count and isinstance(error, Error):
                    raise SystemExit(_INTERRUPTED_EXIT_CODE) from None  # Ctrl-C while waiting for the master
            raise
        if can_drive(self._loop):
            self._driver = LoopDriver(self._loop, self._on_error)
        self._node.on_shutdown(self._end_streams)
        if self._signals is not None and self._signals.count:  # a signal arrived just before
            self._schedule_cancel()
        return self

    async def __aexit__(
        self, error_class: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        self._stop_polling_signals()
        if self._cancel_timer is not None:
            self._cancel_timer.cancel()
        if self._node is not None:
            await asyncio.to_thread(self._node.shutdown)
        if self._signals is not None and not self._signals.count:  # otherwise a second signal still ends the program
            self._signals.restore()
        if error_class is None:
            return False
        if issubclass(error_class, asyncio.CancelledError) and self._is_body_cancelled:
            uncancel = getattr(self._task, "uncancel", None)  # the method exists since Python 3.11
            return uncancel is None or uncancel() == 0
        return issubclass(error_class, NodeShutdownError)  # a wait ended because the node was shut down

    def _on_created(self, node: SyncNode) -> None:
        self._starting_node = node
        if self._signals is not None and self._signals.count:
            self._request_shutdown("a signal")

    def _request_shutdown(self, reason: str) -> None:
        if self._starting_node is not None:
            self._starting_node._context.loop.call_soon(self._starting_node._shutdown.request, reason)

    def _on_signal(self, number: int) -> None:
        """Start the shutdown. Runs in the signal handler, so no lock may be acquired."""
        self._request_shutdown(f"signal {number}")
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):  # the asyncio loop is closed already
                self._loop.call_soon_threadsafe(self._schedule_cancel)

    def _poll_signals(self) -> None:
        """Let Python run signal handlers regularly, since a signal just before the loop begins to wait does not wake
        the loop.
        """
        assert self._loop is not None
        self._signal_timer = self._loop.call_later(POLL_INTERVAL, self._poll_signals)

    def _stop_polling_signals(self) -> None:
        if self._signal_timer is not None:
            self._signal_timer.cancel()

    def _schedule_cancel(self) -> None:
        assert self._loop is not None
        if self._node is not None:
            self._cancel_timer = self._loop.call_later(GRACE_PERIOD, self._cancel_body)

    def _cancel_body(self) -> None:
        if self._task is not None:
            self._is_body_cancelled = True
            self._task.cancel()

    def _on_error(self, error: BaseException) -> None:
        self.sync.log.exception("internal error in a subscription (please report it)", error=error)

    def _end_streams(self) -> None:
        for stream in list(self._message_streams):
            stream.end()
        for sightings in list(self._sightings):
            sightings.close()

    @property
    def sync(self) -> SyncNode:
        """The underlying node, for its log, names and all methods that do not block.

        Raises:
            NodeShutdownError: ``async with`` was not entered.
        """
        if self._node is None:
            raise NodeShutdownError("use the node with: async with pyros1.aio.Node(...) as node")
        return self._node

    @property
    def name(self) -> str:
        """The node's full name."""
        return self.sync.name

    def ok(self) -> bool:
        """Return whether the node is running."""
        return self._node is not None and self._node.ok()

    def now(self) -> Time:
        """Return the node's time."""
        return self.sync.now()

    async def advertise(self, topic: str, type: type[_M] | str, **options: Any) -> Publisher[_M]:
        """Publish on a topic; see :meth:`pyros1.Node.advertise`. The publisher's ``publish`` does not wait.

        Raises:
            ValueError: ``queue_size`` is None, which would make ``publish`` block.
        """
        if options.get("queue_size", 1) is None:
            raise ValueError(
                "queue_size=None makes publish() wait for subscribers, which an asyncio program must not do"
            )
        return await asyncio.to_thread(lambda: self.sync.advertise(topic, type, **options))

    async def subscribe(
        self, topic: str, type: type[_M] | str, *, queue_size: int | None = None, tcp_nodelay: bool = True
    ) -> Messages[_M]:
        """Subscribe to a topic; return its messages once the subscription is registered with the master.

        Args:
            topic: name of the topic.
            type: message class, or a type's name.
            queue_size: maximum number of messages of each publisher queued for the iteration; older ones are dropped
                undecoded. With None, nothing is dropped: a publisher with 100 queued messages is held back, and so
                are other subscriptions of the topic in this node, except `wait_for_message`.
            tcp_nodelay: whether to ask publishers to send small messages without delay.
        """
        return await self._subscribe(topic, type, queue_size, tcp_nodelay)

    async def _subscribe(
        self, topic: str, type: type[_M] | str, queue_size: int | None, tcp_nodelay: bool = True, urgent: bool = False
    ) -> Messages[_M]:
        check_name(topic, "subscribe(topic, type)")
        check_queue_size(queue_size, 1)
        node, loop = self.sync, self._loop
        assert isinstance(node, _UnderlyingNode) and loop is not None
        stream: Messages[_M] = Messages(loop, queue_size, urgent)
        self._message_streams.add(stream)
        # Tasks may keep the loop busy, and messages not received in the meantime could not replace older ones.
        driver = None if stream.wants_newest else self._driver

        def subscribe() -> None:
            stream.attach(node.subscribe_stream(topic, type, stream, queue_size, tcp_nodelay, driver))

        try:
            await asyncio.to_thread(subscribe)
        except asyncio.CancelledError:
            stream.abandon()  # the thread keeps running
            raise
        return stream

    async def messages(self, topic: str, type: type[_M] | str, *, queue_size: int | None = None) -> AsyncIterator[_M]:
        """Iterate over a topic's messages: ``async for message in node.messages("topic1", Float64)``."""
        async with await self.subscribe(topic, type, queue_size=queue_size) as stream:
            async for message in stream:
                yield message

    async def wait_for_message(self, topic: str, type: type[_M] | str, timeout: float | None = None) -> _M:
        """Wait for one new message and return it.

        Meanwhile, an iteration over the same topic keeps receiving messages, even if the iteration is waiting for
        this call, so its queue may exceed the usual limit.

        Raises:
            WaitTimeoutError: no message arrived within ``timeout`` seconds.
            NodeShutdownError: the node is shutting down.
        """
        check_name(topic, "wait_for_message(topic, type)")
        check_timeout(timeout)

        async def receive() -> _M:
            async with await self._subscribe(topic, type, 1, urgent=True) as stream:
                async for message in stream:
                    return message
            raise NodeShutdownError(f"{self.name} is shutting down")

        return await _with_timeout(receive(), timeout, f"timeout exceeded while waiting for message on topic {topic}")

    def watch(self, name: str, *, period: float = 0.5, limit: float = 1.0) -> Sightings:
        """Watch another node: ``async for sighting in node.watch("controller")``; see :meth:`pyros1.Node.watch`."""
        node, loop = self.sync, self._loop
        assert isinstance(node, _UnderlyingNode) and loop is not None
        sightings = Sightings(loop, lambda notify: node.begin_watch(name, period, limit, notify))
        self._sightings.add(sightings)
        return sightings

    async def wait_for_service(self, name: str, timeout: float | None = None) -> None:
        """Wait until a service is provided; see :meth:`pyros1.Node.wait_for_service`."""
        await asyncio.to_thread(self.sync.wait_for_service, name, timeout)

    async def call(self, client: ServiceClient, *args: Any, **fields: Any) -> Any:
        """Call a service in a worker thread, with a client returned by `service`; return the response."""
        if not isinstance(client, ServiceClient):
            raise TypeError(f"call: the client must come from service(name, type), not {client!r:.80}")
        return await asyncio.to_thread(lambda: client(*args, **fields))

    def service(self, name: str, type: type[Service] | str, *, persistent: bool = False) -> ServiceClient:
        """Return a client for `call`; see :meth:`pyros1.Node.service`."""
        return self.sync.service(name, type, persistent=persistent)

    async def advertise_service(
        self, name: str, type: type[Service] | str, handler: Callable[[Any], Awaitable[Any] | Any]
    ) -> ServiceServer:
        """Provide a service.

        Args:
            name: name of the service.
            type: service class, or a type's name.
            handler: a coroutine function or a function, called in the asyncio loop; see
                :meth:`pyros1.Node.advertise_service` for what it returns.
        """
        check_callback(handler, "advertise_service(name, type, handler)", "handler", type)
        loop = self._loop
        assert loop is not None

        async def run(request: Any) -> Any:
            response = handler(request)
            return await response if isinstance(response, Awaitable) else response

        def handle(request: Any) -> Any:
            future = asyncio.run_coroutine_threadsafe(run(request), loop)
            while not concurrent.futures.wait([future], 0.5).done:
                if not self.ok():
                    future.cancel()
                    raise NodeShutdownError(f"{self.name} is shutting down")
            return future.result()

        return await asyncio.to_thread(lambda: self.sync.advertise_service(name, type, handle))

    async def get_param(self, name: str, default: Any = None) -> Any:
        """Return a parameter's value, or ``default`` if it is not set."""
        return await asyncio.to_thread(self.sync.params.get, name, default)

    async def set_param(self, name: str, value: Any) -> None:
        """Set a parameter."""
        await asyncio.to_thread(self.sync.params.set, name, value)


async def _with_timeout(coroutine: Coroutine[Any, Any, _R], timeout: float | None, message: str) -> _R:
    try:
        return await asyncio.wait_for(coroutine, timeout)
    except (TimeoutError, asyncio.TimeoutError):  # not the same class before Python 3.11
        raise WaitTimeoutError(message) from None
