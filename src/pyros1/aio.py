"""The asyncio face: the same verbs as :class:`pyros1.Node`, awaitable.

::

    import asyncio
    import pyros1.aio
    from pyros1.msgs.std_msgs.msg import Float64

    async def main():
        async with pyros1.aio.Node("listener") as node:
            async for message in node.messages("topic1", Float64):
                print(message.data)

    asyncio.run(main())

Messages are received by the node's own threads and handed to the asyncio loop in batches, so that a flood of messages
costs one wake-up, not one each; whoever takes them slowly holds the publishers back. Nothing here blocks the asyncio
loop: what must talk to the master or to another node runs in a worker thread.

SIGINT and SIGTERM end the node: its hooks run, iterations and waits end, and with them the body of ``async with``, so
that the program comes to its end with exit code 0. Other tasks of the program are its own affair. A second signal ends
the program at once.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Iterator
from types import TracebackType
from typing import Any, Generic, TypeVar
from weakref import WeakSet

from pyros1.errors import Error, NodeShutdownError, WaitTimeoutError
from pyros1.msgs import Service
from pyros1.net.bell import STEP, Bell
from pyros1.node import Node as SyncNode
from pyros1.node.checks import check_callback, check_name, check_queue_size, check_timeout
from pyros1.node.publishing.publisher import Publisher
from pyros1.node.services.client import ServiceClient
from pyros1.node.services.server import ServiceServer
from pyros1.node.signals import SignalHandlers
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.timing import Time

_M = TypeVar("_M")
_R = TypeVar("_R")


MOST_WAITING = 100
"""Messages that wait for an iteration without ``queue_size``; then the connections to the publishers fill up."""
GRACE = 0.5
"""Seconds that the body of ``async with`` has for ending by itself, when a signal has ended the node."""
_INTERRUPTED = 130


class Messages(Generic[_M]):
    """The messages of one topic, for ``async for``; made by ``Node.messages``. Ends when the node shuts down.

    Has no lock: a signal handler that comes in the middle of an iteration may wait for the thread that receives.

    Args:
        loop: the asyncio loop that iterates.
        limit: most messages that wait; older ones are dropped. None drops nothing: publishers are held back.
        wanted: tells whether somebody else in the node waits for a message of the topic; nothing is held back then.
    """

    def __init__(
        self, loop: asyncio.AbstractEventLoop, limit: int | None, wanted: Callable[[], bool] = lambda: False
    ) -> None:
        self._loop = loop
        self._holds_back = limit is None
        self._wanted = wanted
        self._waiting: deque[_M] = deque(maxlen=limit)
        self._ready = asyncio.Event()
        self._told = False  # the loop will look
        self._ended = False
        self._room = Bell()
        self._subscriber: Subscriber[_M] | None = None

    def _push(self, message: _M) -> None:
        """Take a message, in the reader thread, which waits while there are too many."""
        while self._holds_back and not self._takes_more():
            self._room.wait(self._takes_more, 0.5)
        self._waiting.append(message)
        if not self._told:
            self._told = True
            self._tell()

    def _takes_more(self) -> bool:
        return len(self._waiting) < MOST_WAITING or self._ended or self._wanted()

    def _look_again(self) -> None:
        self._room.ring()

    def _tell(self) -> None:
        try:
            self._loop.call_soon_threadsafe(self._ready.set)
        except RuntimeError:  # the asyncio loop is closed: nobody listens any more
            self._ended = True

    @property
    def waiting(self) -> int:
        """Messages that wait for the iteration."""
        return len(self._waiting)

    def end(self) -> None:
        """End the iteration. Any thread."""
        self._ended = True
        self._room.ring()
        self._tell()

    def __aiter__(self) -> AsyncIterator[_M]:
        return self

    async def __anext__(self) -> _M:
        while True:
            if self._waiting:
                message = self._waiting.popleft()
                if len(self._waiting) == MOST_WAITING // 2:
                    self._room.ring()
                return message
            self._told = False
            self._ready.clear()
            if self._waiting:  # put there by somebody who still believed that the loop looks
                continue
            if self._ended:
                raise StopAsyncIteration
            await self._ready.wait()

    async def aclose(self) -> None:
        """Unsubscribe."""
        self.end()
        subscriber, self._subscriber = self._subscriber, None
        if subscriber is not None:
            await asyncio.to_thread(subscriber.unregister)

    async def __aenter__(self) -> Messages[_M]:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.aclose()


class _Signals(SignalHandlers):
    """Handlers in the place of those of asyncio, which cancel the main task and show a KeyboardInterrupt.

    A second signal ends the program from its loop, so that tasks are cancelled in order; a third, wherever it is.
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


class _Node(SyncNode):
    """The node underneath, which is known before it has found its master.

    Args:
        begins: called with it when it can be ended.
        options: as for :class:`pyros1.Node`.
    """

    def __init__(self, begins: Callable[[SyncNode], None], name: str, **options: Any) -> None:
        self._begins = begins
        super().__init__(name, **options)

    def _open(self, *args: Any) -> None:
        self._begins(self)
        super()._open(*args)


class Node:
    """A ROS node for asyncio programs. Use it with ``async with``.

    Args:
        name: as for :class:`pyros1.Node`.
        handle_signals: end the node on SIGINT and SIGTERM, and then the body of ``async with``, which is cancelled if
            it does not end by itself soon. Possible in the main thread only.
        options: all other keyword arguments of :class:`pyros1.Node` but ``callbacks``.
    """

    def __init__(self, name: str, *, handle_signals: bool = True, **options: Any) -> None:
        if "callbacks" in options:
            raise TypeError("pyros1.aio.Node has no callbacks=: messages are for async for")
        self._make: Callable[[], SyncNode] = lambda: _Node(self._begins, name, handle_signals=False, **options)
        self._signals = _Signals(self._on_signal) if handle_signals else None
        self._ends: asyncio.TimerHandle | None = None  # cancels the body
        self._looks: asyncio.TimerHandle | None = None
        self._cancelled = False
        self._making: SyncNode | None = None
        self._node: SyncNode | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._streams: WeakSet[Messages[Any]] = WeakSet()
        self._waits: deque[tuple[str, Messages[Any]]] = deque()  # topics of which somebody waits for one message

    async def __aenter__(self) -> Node:
        self._loop = asyncio.get_running_loop()
        self._task = asyncio.current_task()
        if self._signals is not None:
            self._signals.loop = self._loop
            self._signals.install()
            self._look()
        try:
            self._node = await asyncio.to_thread(self._make)
        except BaseException as error:
            if self._making is not None:
                self._end_soon("the program does not wait for it")  # the thread goes on after a cancellation
            if self._signals is not None:
                self._look_no_more()
                self._signals.restore()
                if self._signals.count and isinstance(error, Error):
                    raise SystemExit(_INTERRUPTED) from None  # Ctrl-C while waiting for the master's answer, or for it
            raise
        self._node.on_shutdown(self._end_streams)
        if self._signals is not None and self._signals.count:  # a signal came just before
            self._set_limit()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        self._look_no_more()
        if self._ends is not None:
            self._ends.cancel()
        if self._node is not None:
            await asyncio.to_thread(self._node.shutdown)
        if self._signals is not None and not self._signals.count:  # else a second signal still ends the program
            self._signals.restore()
        if kind is None:
            return False
        if issubclass(kind, asyncio.CancelledError) and self._cancelled:
            uncancel = getattr(self._task, "uncancel", None)  # there since Python 3.11
            return uncancel is None or uncancel() == 0
        return issubclass(kind, NodeShutdownError)  # a wait ended because the node was told to stop

    def _begins(self, node: SyncNode) -> None:
        self._making = node
        if self._signals is not None and self._signals.count:
            self._end_soon("a signal")

    def _end_soon(self, reason: str) -> None:
        if self._making is not None:
            self._making._context.loop.call_soon(self._making._life.request, reason)

    def _on_signal(self, number: int) -> None:
        """Begin the end; in the signal handler, so no lock may be taken."""
        self._end_soon(f"signal {number}")
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):  # the asyncio loop is closed already
                self._loop.call_soon_threadsafe(self._set_limit)

    def _look(self) -> None:
        """Let Python run signal handlers: one that comes just before the loop begins to wait does not end that wait."""
        assert self._loop is not None
        self._looks = self._loop.call_later(STEP, self._look)

    def _look_no_more(self) -> None:
        if self._looks is not None:
            self._looks.cancel()

    def _set_limit(self) -> None:
        assert self._loop is not None
        if self._node is not None:
            self._ends = self._loop.call_later(GRACE, self._cancel)

    def _cancel(self) -> None:
        if self._task is not None:
            self._cancelled = True
            self._task.cancel()

    def _end_streams(self) -> None:
        for stream in list(self._streams):
            stream.end()

    @property
    def sync(self) -> SyncNode:
        """The node underneath: its log, names and everything that does not wait.

        Raises:
            NodeShutdownError: before ``async with``.
        """
        if self._node is None:
            raise NodeShutdownError("use the node with: async with pyros1.aio.Node(...) as node")
        return self._node

    @property
    def name(self) -> str:
        """The node's full name."""
        return self.sync.name

    def ok(self) -> bool:
        """Tell whether the node runs."""
        return self._node is not None and self._node.ok()

    def now(self) -> Time:
        """Return the node's time."""
        return self.sync.now()

    async def advertise(self, topic: str, type: type[_M] | str, **options: Any) -> Publisher[_M]:
        """Publish on a topic, see :meth:`pyros1.Node.advertise`. The publisher's ``publish`` does not wait.

        Raises:
            ValueError: ``queue_size=None``, which would make ``publish`` wait.
        """
        if options.get("queue_size", 1) is None:
            raise ValueError("queue_size=None makes publish() wait for subscribers: not in an asyncio program")
        return await asyncio.to_thread(lambda: self.sync.advertise(topic, type, **options))

    async def subscribe(
        self, topic: str, type: type[_M] | str, *, queue_size: int | None = None, tcp_nodelay: bool = True
    ) -> Messages[_M]:
        """Subscribe to a topic; returns when the master knows it.

        Args:
            queue_size: messages that may wait for the iteration; older ones are dropped. None drops nothing: publishers
                are held back while some wait, and so are other subscriptions of the topic in this node, but for
                `wait_for_message`.
        """
        check_name(topic, "subscribe(topic, type)")
        check_queue_size(queue_size, 1)
        name = self.sync.resolve(topic)
        assert self._loop is not None
        stream: Messages[_M] = Messages(self._loop, queue_size, lambda: self._waited_for(name))
        self._streams.add(stream)
        stream._subscriber = await asyncio.to_thread(
            lambda: self.sync.subscribe(topic, type, stream._push, queue_size=queue_size, tcp_nodelay=tcp_nodelay)
        )
        return stream

    async def messages(self, topic: str, type: type[_M] | str, *, queue_size: int | None = None) -> AsyncIterator[_M]:
        """Iterate over a topic's messages: ``async for message in node.messages("topic1", Float64)``."""
        async with await self.subscribe(topic, type, queue_size=queue_size) as stream:
            async for message in stream:
                yield message

    async def wait_for_message(self, topic: str, type: type[_M] | str, timeout: float | None = None) -> _M:
        """Wait for one message that comes from now on.

        An iteration over the same topic, which may wait for this call, goes on to receive meanwhile, so that more than
        usual may wait for it.

        Raises:
            WaitTimeoutError: none came within ``timeout`` seconds.
            NodeShutdownError: the node is shutting down.
        """
        check_name(topic, "wait_for_message(topic, type)")
        check_timeout(timeout)
        name = self.sync.resolve(topic)

        async def first() -> _M:
            async with await self.subscribe(topic, type, queue_size=1) as stream:
                with self._waiting_for(name, stream):
                    async for message in stream:
                        return message
            raise NodeShutdownError(f"{self.name} is shutting down")

        return await _within(first(), timeout, f"timeout exceeded while waiting for message on topic {topic}")

    @contextlib.contextmanager
    def _waiting_for(self, topic: str, stream: Messages[Any]) -> Iterator[None]:
        """Let no iteration hold messages of a topic back until this stream has one."""
        wait = (topic, stream)
        self._waits.append(wait)
        for other in self._streams:
            other._look_again()
        try:
            yield
        finally:
            self._waits.remove(wait)

    def _waited_for(self, topic: str) -> bool:
        return any(topic == name and not stream.waiting for name, stream in list(self._waits))

    async def wait_for_service(self, name: str, timeout: float | None = None) -> None:
        """Wait until a service is provided; see :meth:`pyros1.Node.wait_for_service`."""
        await asyncio.to_thread(self.sync.wait_for_service, name, timeout)

    async def call(self, client: ServiceClient, *args: Any, **fields: Any) -> Any:
        """Call a service with a client that `service` returned, in a worker thread."""
        if not isinstance(client, ServiceClient):
            raise TypeError(f"call: the client must be what service(name, type) returns, not {client!r:.80}")
        return await asyncio.to_thread(lambda: client(*args, **fields))

    def service(self, name: str, type: type[Service] | str, *, persistent: bool = False) -> ServiceClient:
        """Return a client for `call`; see :meth:`pyros1.Node.service`."""
        return self.sync.service(name, type, persistent=persistent)

    async def advertise_service(
        self, name: str, type: type[Service] | str, handler: Callable[[Any], Awaitable[Any] | Any]
    ) -> ServiceServer:
        """Provide a service.

        Args:
            handler: a coroutine function, run on the asyncio loop, or a function, run there too; returns what a handler
                of :meth:`pyros1.Node.advertise_service` returns.
        """
        check_callback(handler, "advertise_service(name, type, handler)", "handler", type)
        loop = self._loop
        assert loop is not None

        async def run(request: Any) -> Any:
            answer = handler(request)
            return await answer if isinstance(answer, Awaitable) else answer

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


async def _within(work: Coroutine[Any, Any, _R], timeout: float | None, text: str) -> _R:
    try:
        return await asyncio.wait_for(work, timeout)
    except (TimeoutError, asyncio.TimeoutError):  # not the same class before Python 3.11
        raise WaitTimeoutError(text) from None
