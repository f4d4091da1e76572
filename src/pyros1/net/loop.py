"""An event loop: one thread that waits for many sockets and timers.

All callbacks run on the loop's thread, one after the other, so objects that are only used on the loop need no locks.
Callbacks must not block. ``call_soon``, ``call_later``, ``run``, ``start`` and ``stop`` are thread-safe; ``register``,
``modify`` and ``unregister`` may be called only on the loop.
"""

from __future__ import annotations

import contextlib
import heapq
import math
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
from pyros1.net.error_reports import ErrorReports  # not at first use: there may be too many open files then
from pyros1.net.spin_wait import PollGuard, yield_processor

if TYPE_CHECKING:
    from pyros1.net.resolve import Resolver


READ: Final = selectors.EVENT_READ
WRITE: Final = selectors.EVENT_WRITE

ResultT = TypeVar("ResultT")


class _PortableSelector:
    """A selector for any operating system."""

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


class _EpollSelector:
    """A selector for Linux. Unlike Python's, it creates no object per event, since this is the loop's busiest code."""

    def __init__(self) -> None:
        self._epoll = select.epoll()
        self._in_mask, self._out_mask = select.EPOLLIN, select.EPOLLOUT

    def register(self, fd: int, events: int) -> None:
        self._epoll.register(fd, self._to_epoll(events))

    def modify(self, fd: int, events: int) -> None:
        self._epoll.modify(fd, self._to_epoll(events))

    def unregister(self, fd: int) -> None:
        self._epoll.unregister(fd)

    def select(self, timeout: float | None) -> list[tuple[int, int]]:
        # Rounded up to epoll's milliseconds; otherwise the loop would spin for the last part of a millisecond before
        # a timer is due.
        seconds = -1.0 if timeout is None else math.ceil(timeout * 1e3) * 1e-3
        in_mask = self._in_mask
        return [(fd, READ if mask == in_mask else self._from_epoll(mask)) for fd, mask in self._epoll.poll(seconds)]

    def close(self) -> None:
        self._epoll.close()

    def _to_epoll(self, events: int) -> int:
        return (self._in_mask if events & READ else 0) | (self._out_mask if events & WRITE else 0)

    def _from_epoll(self, mask: int) -> int:
        # An error or hang-up is reported as both READ and WRITE: reading or writing then raises the error.
        return (READ if mask & ~self._out_mask else 0) | (WRITE if mask & ~self._in_mask else 0)


class TimerHandle:
    """A call that is scheduled for later."""

    __slots__ = ("_args", "_function", "when")

    def __init__(self, when: float, function: Callable[..., object], args: tuple[Any, ...]) -> None:
        self.when = when
        self._function: Callable[..., object] | None = function
        self._args = args

    def cancel(self) -> None:
        """Cancel the call; no effect if it has already been made. Thread-safe."""
        self._function = None
        self._args = ()

    @property
    def cancelled(self) -> bool:
        """Whether the call was cancelled, or has been made."""
        return self._function is None

    def _run(self) -> None:
        function, args = self._function, self._args
        self.cancel()
        if function is not None:
            function(*args)


class LoopThread(threading.Thread):
    """The thread of a loop.

    Attributes:
        owner: the object that uses the loop; set by that object, so that code can determine on whose loop it runs.
    """

    owner: object | None = None


class Loop:
    """A selector, a queue of calls, and a heap of timers on one daemon thread.

    Args:
        name: the thread's name.
        on_error: called on the loop with each exception that a callback raises; the loop continues. None to write
            the traceback to stderr.
        spin_time: seconds after an event during which the loop polls for the next one instead of sleeping, if events
            have been following each other quickly. Useful for a server whose clients send the next request right after
            a response, if waking up takes longer than the work.
    """

    def __init__(
        self, name: str, on_error: Callable[[BaseException], object] | None = None, spin_time: float = 0.0
    ) -> None:
        self.name = name
        self._spin_time = spin_time
        self._poll_guard = PollGuard(assume_idle=True)  # a pause would be longer than many series of calls
        self._was_gap_short = False
        self._last_event_at = 0.0
        self._on_error = on_error or self._log_traceback
        self._error_reports: ErrorReports | None = None
        self._selector = _EpollSelector() if hasattr(select, "epoll") else _PortableSelector()
        self._callbacks: dict[int, Callable[[int], object]] = {}
        self._calls: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()
        self._timers: list[tuple[float, int, TimerHandle]] = []
        self._timer_counter = count()
        self._stopping = False
        self._closed = False
        self._is_wake_pending = False
        self._lock = threading.Lock()
        self._resolver: Resolver | None = None
        self._wake_receiver, self._wake_sender = socket.socketpair()
        self._wake_receiver.setblocking(False)
        self._wake_sender.setblocking(False)
        self.register(self._wake_receiver, READ, self._drain_wake)
        self.thread = LoopThread(target=self._run, name=name, daemon=True)

    # ---- from any thread

    def start(self) -> None:
        """Start the loop's thread; calls that were queued before are made then."""
        self.thread.start()

    def stop(self, timeout: float = 5.0) -> None:
        """Stop the thread after the current callback, and wait until it has exited (except when called on the loop).

        Queued calls are dropped. Sockets that are still registered are not closed.

        Args:
            timeout: maximum number of seconds to wait.
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
        """Whether the thread is running and has not been told to stop."""
        return self.thread.is_alive() and not self._stopping

    def in_loop(self) -> bool:
        """Return whether the caller runs on the loop's thread."""
        return threading.get_ident() == self.thread.ident

    def call_soon(self, function: Callable[..., object], *args: Any) -> None:
        """Queue the call ``function(*args)`` on the loop; the call is not made if the loop has stopped."""
        self._calls.append((function, args))
        if not self._is_wake_pending and not self.in_loop():
            self._wake()

    def call_later(self, delay_s: float, function: Callable[..., object], *args: Any) -> TimerHandle:
        """Call ``function(*args)`` on the loop after ``delay_s`` seconds; return a handle that can cancel the call."""
        handle = TimerHandle(monotonic() + delay_s, function, args)
        if self.in_loop():
            self._add_timer(handle)
        else:
            self.call_soon(self._add_timer, handle)
        return handle

    def run(self, function: Callable[..., ResultT], *args: Any, timeout: float = 5.0) -> ResultT:
        """Call ``function(*args)`` on the loop, wait for it and return its result. The call is made in the calling
        thread instead if that is the loop's own, or if the loop is not running.

        Raises:
            DeadlineError: the loop did not make the call within ``timeout`` seconds.
            Exception: whatever ``function`` raises.
        """
        if self.in_loop() or not self.running:
            return function(*args)
        done = threading.Event()
        result: list[ResultT] = []
        failure: list[BaseException] = []

        def call() -> None:
            try:
                result.append(function(*args))
            except BaseException as error:  # noqa: BLE001 - raised again in the caller's thread
                failure.append(error)
            done.set()

        self.call_soon(call)
        deadline = monotonic() + timeout
        while not done.wait(min(0.1, max(0.0, deadline - monotonic()))):
            if not self.thread.is_alive() and not done.is_set():
                return function(*args)
            if monotonic() >= deadline:
                raise DeadlineError(f"the thread {self.name!r} did not answer within {timeout:g} s")
        if failure:
            raise failure[0]
        return result[0]

    def report(self, error: BaseException) -> None:
        """Pass an unexpected error to ``on_error``; if that raises an exception, the loop still continues."""
        try:
            self._on_error(error)
        except Exception as report_error:  # noqa: BLE001 - the loop must continue
            with contextlib.suppress(Exception):
                self._reporter.log(f"{self.name}: {error!r}; reporting this also failed: {report_error!r}")

    def warn(self, text: str) -> None:
        """Write a message to stderr without blocking; repetitions are only counted. Called on the loop."""
        self._reporter.log(text)

    def _log_traceback(self, error: BaseException) -> None:
        from traceback import format_exception  # noqa: PLC0415 - rarely needed

        self._reporter.log("".join(format_exception(type(error), error, error.__traceback__)).rstrip())

    @property
    def _reporter(self) -> ErrorReports:
        if self._error_reports is None:
            self._error_reports = ErrorReports(self)
        return self._error_reports

    # ---- on the loop

    @property
    def resolver(self) -> Resolver:
        """The host name resolver of this loop, created at first use."""
        if self._resolver is None:
            from pyros1.net.resolve import Resolver  # noqa: PLC0415 - most loops do not need it

            self._resolver = Resolver(self)
        return self._resolver

    def register(self, sock: socket.socket | int, events: int, callback: Callable[[int], object]) -> None:
        """Call ``callback(ready_events)`` whenever the socket is ready.

        Args:
            sock: a non-blocking socket, or a file descriptor.
            events: READ, WRITE or both.
            callback: called on the loop. It must handle EAGAIN, since it may be called when the socket is not ready.
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
        """Stop waiting for a socket, which must be done before closing it. No effect if it is not registered."""
        fd = sock if isinstance(sock, int) else sock.fileno()
        if self._callbacks.pop(fd, None) is not None:
            self._selector.unregister(fd)

    # ---- internal

    def _add_timer(self, handle: TimerHandle) -> None:
        heapq.heappush(self._timers, (handle.when, next(self._timer_counter), handle))

    def _wake(self) -> None:
        self._is_wake_pending = True
        try:
            self._wake_sender.send(b"\0")
        except BlockingIOError:
            pass  # the socket's buffer is full, so the loop will wake up
        except OSError:
            pass  # the loop has stopped

    def _drain_wake(self, mask: int) -> None:
        try:
            while len(self._wake_receiver.recv(4096)) == 4096:
                pass
        except BlockingIOError:
            pass
        # Cleared after the socket was emptied: otherwise a byte sent in between would be lost, while the flag says that
        # one is pending. Cleared before the calls of this iteration are taken from the queue: a thread that saw the
        # flag set has queued its call by then.
        self._is_wake_pending = False

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
            # An earlier callback of this iteration may have unregistered this socket, and even reused its descriptor.
            if callback is not None and callbacks.get(fd) is callback:
                try:
                    callback(mask)
                except Exception as error:  # noqa: BLE001 - the failure of one socket must not affect the others
                    self.report(error)
        if timers and timers[0][0] <= monotonic():
            self._run_timers()
        # Make only the calls queued so far: a call that queues itself must not starve the sockets.
        for _ in range(len(self._calls)):
            function, args = self._calls.popleft()
            try:
                function(*args)
            except Exception as error:  # noqa: BLE001 - as above
                self.report(error)

    def _wait(self, timeout: float | None) -> Iterable[tuple[int, int]]:
        select = self._selector.select
        if not self._spin_time:
            return select(timeout)
        events: Iterable[tuple[int, int]] = ()
        if timeout != 0.0:
            now = monotonic()
            may_poll = self._was_gap_short and self._poll_guard.may_poll(now)
            spin_deadline = self._last_event_at + self._spin_time if may_poll else 0.0
            while not events and now < spin_deadline:
                events = select(0.0)
                yield_processor()  # let other threads run first, such as a client's
                previous, now = now, monotonic()
                if self._poll_guard.note_poll(previous, now):
                    break
        events = events or select(timeout)
        now = monotonic()
        # Twice the spin time, since the gap includes the time to wake up, which polling saves.
        self._was_gap_short = now - self._last_event_at < 2 * self._spin_time
        self._last_event_at = now
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
        if self._error_reports is not None:
            self._error_reports.close()
        self._selector.close()
        self._wake_receiver.close()
        self._wake_sender.close()
