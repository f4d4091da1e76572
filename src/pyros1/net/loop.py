"""One thread that waits for many sockets and timers.

Everything that the loop calls runs on its thread, one after the other, so what lives on a loop needs no locks.
Callbacks must not block. ``call_soon``, ``call_later``, ``run``, ``start`` and ``stop`` may be called from any thread;
``register``, ``modify`` and ``unregister`` only on the loop.
"""

from __future__ import annotations

import contextlib
import heapq
import math
import os
import select
import selectors
import socket
import threading
from collections import deque
from collections.abc import Callable, Iterable
from itertools import count
from time import monotonic
from typing import TYPE_CHECKING, Any, Final, TypeVar

from pyros1.ground.errors import DeadlineError
from pyros1.net.error_reports import ErrorReports  # not at first use: perhaps no more files can be opened then

if TYPE_CHECKING:
    from pyros1.net.resolve import Resolver

_yield: Final[Callable[[], object]] = getattr(os, "sched_yield", lambda: None)

READ: Final = selectors.EVENT_READ
WRITE: Final = selectors.EVENT_WRITE

ResultT = TypeVar("ResultT")


class _Portable:
    """The selector of the loop, on any system."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()

    def register(self, fd: int, events: int) -> None:
        self._selector.register(fd, events)

    def modify(self, fd: int, events: int) -> None:
        self._selector.modify(fd, events)

    def unregister(self, fd: int) -> None:
        self._selector.unregister(fd)

    def select(self, timeout: float | None) -> list[tuple[int, int]]:
        return [(key.fd, mask) for key, mask in self._selector.select(timeout)]

    def close(self) -> None:
        self._selector.close()


class _Epoll:
    """The selector of the loop on Linux, without an object per event: this is the busiest code of the loop."""

    def __init__(self) -> None:
        self._epoll = select.epoll()
        self._in, self._out = select.EPOLLIN, select.EPOLLOUT

    def register(self, fd: int, events: int) -> None:
        self._epoll.register(fd, self._to_epoll(events))

    def modify(self, fd: int, events: int) -> None:
        self._epoll.modify(fd, self._to_epoll(events))

    def unregister(self, fd: int) -> None:
        self._epoll.unregister(fd)

    def select(self, timeout: float | None) -> list[tuple[int, int]]:
        # Rounded up to epoll's milliseconds, or the loop would spin for the last fraction before a timer.
        seconds = -1.0 if timeout is None else math.ceil(timeout * 1e3) * 1e-3
        plain_in = self._in
        return [(fd, READ if mask == plain_in else self._from_epoll(mask)) for fd, mask in self._epoll.poll(seconds)]

    def close(self) -> None:
        self._epoll.close()

    def _to_epoll(self, events: int) -> int:
        return (self._in if events & READ else 0) | (self._out if events & WRITE else 0)

    def _from_epoll(self, mask: int) -> int:
        # An error or hang-up counts as both: a read or write then raises the error.
        return (READ if mask & ~self._out else 0) | (WRITE if mask & ~self._in else 0)


class TimerHandle:
    """A call that is due later."""

    __slots__ = ("_args", "_fn", "when")

    def __init__(self, when: float, fn: Callable[..., object], args: tuple[Any, ...]) -> None:
        self.when = when
        self._fn: Callable[..., object] | None = fn
        self._args = args

    def cancel(self) -> None:
        """Cancel the call; harmless if it has already happened. From any thread."""
        self._fn = None
        self._args = ()

    @property
    def cancelled(self) -> bool:
        """Whether it was cancelled, or has run."""
        return self._fn is None

    def _run(self) -> None:
        fn, args = self._fn, self._args
        self.cancel()
        if fn is not None:
            fn(*args)


class LoopThread(threading.Thread):
    """The thread of a loop.

    Attributes:
        owner: the object that the loop works for; set by the owner, so that code can tell on whose loop it runs.
    """

    owner: object | None = None


class Loop:
    """A selector, a queue of calls, and a heap of timers on one daemon thread.

    Args:
        name: the thread's name.
        on_error: gets each exception that a callback raises, on the loop; the loop continues. None: the traceback is
            written to stderr.
        spin_time: seconds after an event in which the loop polls for the next one instead of sleeping: for a server
            whose callers ask again as soon as they have an answer, and to which waking up takes longer than the work.
    """

    def __init__(
        self, name: str, on_error: Callable[[BaseException], object] | None = None, spin_time: float = 0.0
    ) -> None:
        self.name = name
        self._spin_time = spin_time
        self._last_event = 0.0
        self._on_error = on_error or self._print
        self._reports: ErrorReports | None = None
        self._selector = _Epoll() if hasattr(select, "epoll") else _Portable()
        self._callbacks: dict[int, Callable[[int], object]] = {}
        self._calls: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()
        self._timers: list[tuple[float, int, TimerHandle]] = []
        self._tick = count()
        self._stopping = False
        self._closed = False
        self._awake = False
        self._lock = threading.Lock()
        self._resolver: Resolver | None = None
        self._wake_in, self._wake_out = socket.socketpair()
        self._wake_in.setblocking(False)
        self._wake_out.setblocking(False)
        self.register(self._wake_in, READ, self._drain_wake)
        self.thread = LoopThread(target=self._run, name=name, daemon=True)

    # ---- from any thread

    def start(self) -> None:
        """Start the thread. Earlier calls are then made."""
        self.thread.start()

    def stop(self, timeout: float = 5.0) -> None:
        """End the thread after the callback that is running, and wait for that (not when called on the loop).

        What is still queued is dropped. Sockets that are still registered are forgotten, not closed.

        Args:
            timeout: longest wait in seconds.
        """
        self._stopping = True
        if self.in_loop():
            return
        self._wake()
        if self.thread.ident is not None:
            self.thread.join(timeout)
        else:
            self._close()

    @property
    def running(self) -> bool:
        """Whether the thread has been started, has not ended, and was not asked to stop."""
        return self.thread.is_alive() and not self._stopping

    def in_loop(self) -> bool:
        """Return whether the caller runs on the loop's thread."""
        return threading.get_ident() == self.thread.ident

    def call_soon(self, fn: Callable[..., object], *args: Any) -> None:
        """Call ``fn(*args)`` on the loop, in order; nothing happens if the loop has stopped."""
        self._calls.append((fn, args))
        if not self._awake and not self.in_loop():
            self._wake()

    def call_later(self, delay_s: float, fn: Callable[..., object], *args: Any) -> TimerHandle:
        """Call ``fn(*args)`` on the loop after ``delay_s`` seconds."""
        handle = TimerHandle(monotonic() + delay_s, fn, args)
        if self.in_loop():
            self._add_timer(handle)
        else:
            self.call_soon(self._add_timer, handle)
        return handle

    def run(self, fn: Callable[..., ResultT], *args: Any, timeout: float = 5.0) -> ResultT:
        """Call ``fn(*args)`` on the loop and return its result; directly if on the loop, or if it is not running.

        Raises:
            DeadlineError: the loop did not make the call within ``timeout`` seconds.
            Exception: whatever ``fn`` raises.
        """
        if self.in_loop() or not self.running:
            return fn(*args)
        done = threading.Event()
        result: list[ResultT] = []
        failure: list[BaseException] = []

        def call() -> None:
            try:
                result.append(fn(*args))
            except BaseException as error:  # noqa: BLE001 - handed to the caller
                failure.append(error)
            done.set()

        self.call_soon(call)
        limit = monotonic() + timeout
        while not done.wait(min(0.1, max(0.0, limit - monotonic()))):
            if not self.thread.is_alive() and not done.is_set():
                return fn(*args)
            if monotonic() >= limit:
                raise DeadlineError(f"the thread {self.name!r} did not answer within {timeout:g} s")
        if failure:
            raise failure[0]
        return result[0]

    def report(self, error: BaseException) -> None:
        """Hand an unexpected error to ``on_error``; an exception from that does not end the loop."""
        try:
            self._on_error(error)
        except Exception as other:  # noqa: BLE001 - the loop must continue
            with contextlib.suppress(Exception):
                self._reporter.log(f"{self.name}: {error!r}; reporting this also failed: {other!r}")

    def warn(self, text: str) -> None:
        """Write a text to stderr, without waiting for it. Repeated texts are counted. On the loop."""
        self._reporter.log(text)

    def _print(self, error: BaseException) -> None:
        from traceback import format_exception  # noqa: PLC0415 - rarely needed

        self._reporter.log("".join(format_exception(type(error), error, error.__traceback__)).rstrip())

    @property
    def _reporter(self) -> ErrorReports:
        if self._reports is None:
            self._reports = ErrorReports(self)
        return self._reports

    # ---- on the loop

    @property
    def resolver(self) -> Resolver:
        """The resolver of host names for this loop, made at first use."""
        if self._resolver is None:
            from pyros1.net.resolve import Resolver  # noqa: PLC0415 - most loops never need one

            self._resolver = Resolver(self)
        return self._resolver

    def register(self, sock: socket.socket | int, events: int, callback: Callable[[int], object]) -> None:
        """Call ``callback(ready_events)`` whenever the socket is ready.

        Args:
            sock: a non-blocking socket (or a file descriptor).
            events: READ, WRITE or both. A callback may be called although the socket is not ready: it must accept
                EAGAIN.
        """
        fd = sock if isinstance(sock, int) else sock.fileno()
        self._selector.register(fd, events)
        self._callbacks[fd] = callback

    def modify(self, sock: socket.socket | int, events: int, callback: Callable[[int], object]) -> None:
        """Change the events or the callback of a registered socket."""
        fd = sock if isinstance(sock, int) else sock.fileno()
        self._selector.modify(fd, events)
        self._callbacks[fd] = callback

    def unregister(self, sock: socket.socket | int) -> None:
        """Stop waiting for a socket; call this before closing it. Harmless if it is not registered."""
        fd = sock if isinstance(sock, int) else sock.fileno()
        if self._callbacks.pop(fd, None) is not None:
            self._selector.unregister(fd)

    # ---- inside

    def _add_timer(self, handle: TimerHandle) -> None:
        heapq.heappush(self._timers, (handle.when, next(self._tick), handle))

    def _wake(self) -> None:
        self._awake = True
        try:
            self._wake_out.send(b"\0")
        except BlockingIOError:
            pass  # the pipe is full: the loop will wake
        except OSError:
            pass  # the loop has stopped

    def _drain_wake(self, mask: int) -> None:
        try:
            while len(self._wake_in.recv(4096)) == 4096:
                pass
        except BlockingIOError:
            pass
        # After the pipe is emptied, or a byte written in between would be lost while the flag says that one is there;
        # before this round's calls leave the queue, so that a caller that saw the flag set is served by this round.
        self._awake = False

    def _run(self) -> None:
        try:
            while not self._stopping:
                self._run_once()
        finally:
            self._close()

    def _run_once(self) -> None:
        timers = self._timers
        while timers and timers[0][2].cancelled:
            heapq.heappop(timers)
        if self._calls:
            timeout: float | None = 0.0
        elif timers:
            timeout = max(0.0, timers[0][0] - monotonic())
        else:
            timeout = None
        callbacks = self._callbacks
        for fd, callback, mask in [(fd, callbacks.get(fd), mask) for fd, mask in self._wait(timeout)]:
            # An earlier callback of this round may have unregistered this one, and even reused its descriptor.
            if callback is not None and callbacks.get(fd) is callback:
                try:
                    callback(mask)
                except Exception as error:  # noqa: BLE001 - one socket's failure must not end the others
                    self.report(error)
        if timers and timers[0][0] <= monotonic():
            self._run_timers()
        # Only those queued by now: a call that queues itself must not starve the sockets.
        for _ in range(len(self._calls)):
            fn, args = self._calls.popleft()
            try:
                fn(*args)
            except Exception as error:  # noqa: BLE001 - as above
                self.report(error)

    def _wait(self, timeout: float | None) -> Iterable[tuple[int, int]]:
        select = self._selector.select
        if not self._spin_time:
            return select(timeout)
        events: Iterable[tuple[int, int]] = ()
        if timeout != 0.0:
            end = self._last_event + self._spin_time
            while not events and monotonic() < end:
                events = select(0.0)
                _yield()  # let other threads run first, perhaps the caller
        events = events or select(timeout)
        self._last_event = monotonic()
        return events

    def _run_timers(self) -> None:
        now = monotonic()
        timers = self._timers
        while timers and timers[0][0] <= now:
            handle = heapq.heappop(timers)[2]
            try:
                handle._run()
            except Exception as error:  # noqa: BLE001 - as above
                self.report(error)

    def _close(self) -> None:
        with self._lock:
            if self._closed:
                return
            self._closed = True
        self._calls.clear()
        self._timers.clear()
        if self._resolver is not None:
            self._resolver.close()
        if self._reports is not None:
            self._reports.close()
        self._selector.close()
        self._wake_in.close()
        self._wake_out.close()
