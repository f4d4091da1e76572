"""The threads that receive for a node's subscriptions.

All quiet subscriptions share two threads, which wait for messages. A thread that receives a message runs the callbacks,
and stays with that subscription while more than 50 messages per second arrive; if no waiting thread is left, another is
started. So there are two more threads than busy subscriptions: a node with hundreds of idle links has only two threads,
and the callbacks of different topics never wait for each other.
"""

from __future__ import annotations

import contextlib
import sys
import threading
from collections import deque
from time import perf_counter
from typing import TYPE_CHECKING, Protocol

from pyros1.net.poller import WAKE, Poller

if TYPE_CHECKING:
    from collections.abc import Callable

    from pyros1.node.subscribing.delivery_loop import DeliveryLoop

MIN_WAITING_THREADS = 2
"""Number of waiting threads that do not exit when idle."""
IDLE_TIMEOUT = 5.0
"""Seconds after which each further waiting thread exits if nothing wakes it."""


class Driver(Protocol):
    """Runs delivery loops when they have work: the threads of a node, or an asyncio loop (`pyros1.aio.driver`).

    Attributes:
        cooperative: whether `DeliveryLoop.run` must return after each round of turns.
    """

    cooperative: bool

    @property
    def has_waiting_thread(self) -> bool:
        """Whether a thread is waiting for the next message, so that the calling thread may wait for a single link."""

    def register(self, fd: int, delivery: DeliveryLoop) -> None:
        """Run a delivery loop when a socket becomes readable: once, and again after each `rearm`."""

    def rearm(self, fd: int) -> None:
        """Watch a socket again after its delivery loop has run."""

    def unregister(self, fd: int) -> None:
        """Unregister a socket; call this before closing it."""

    def wake(self, delivery: DeliveryLoop) -> None:
        """Schedule a delivery loop to run soon. Thread-safe."""

    def call(self, function: Callable[[], None], timeout: float) -> None:
        """Call a function that unregisters sockets, in the right thread; wait for it at most ``timeout`` seconds."""


class DeliveryThreads:
    """The receiving threads of one node, and their sockets.

    Args:
        name: the node's name, for the names of the threads.
        on_error: called with each exception that a delivery loop does not handle.
    """

    cooperative = False

    def __init__(self, name: str, on_error: Callable[[BaseException], None]) -> None:
        self._name = name
        self._on_error = on_error
        self._poller = Poller()
        self._deliveries: dict[int, DeliveryLoop] = {}
        self._woken_deliveries: deque[DeliveryLoop] = deque()
        self._lock = threading.RLock()  # reentrant: a signal handler in one of these methods may wake a loop
        self._num_waiting = 0
        self._start_failed = False  # whether the system could not start another thread
        self._threads: set[threading.Thread] = set()
        self._num_started = 0
        self._closed = False

    def register(self, fd: int, delivery: DeliveryLoop) -> None:
        """Run a delivery loop when a socket becomes readable: once, and again after each `rearm`."""
        self._deliveries[fd] = delivery
        self._poller.register(fd)
        self._ensure_started()

    def rearm(self, fd: int) -> None:
        """Watch a socket again after its delivery loop has run."""
        self._poller.rearm(fd)

    def unregister(self, fd: int) -> None:
        """Unregister a socket; call this before closing it."""
        self._deliveries.pop(fd, None)
        self._poller.unregister(fd)

    def wake(self, delivery: DeliveryLoop) -> None:
        """Run a delivery loop soon, on one of the threads."""
        self._woken_deliveries.append(delivery)
        self._poller.wake()
        self._ensure_started()

    def call(self, function: Callable[[], None], timeout: float) -> None:
        """Call a function in the calling thread: any thread may unregister sockets."""
        function()

    def close(self, timeout: float = 5.0) -> None:
        """Stop the threads; wait for them at most ``timeout`` seconds."""
        deadline = perf_counter() + timeout
        with self._lock:
            self._closed = True
            # A signal handler may end the node while a thread is being started; that thread ends on its own.
            threads = [other for other in self._threads if other.ident and other is not threading.current_thread()]
            if not self._threads:
                self._poller.close()  # otherwise the last thread closes it
        for _ in threads:
            self._poller.wake()
        for thread in threads:
            thread.join(max(0.0, deadline - perf_counter()))

    def _ensure_started(self) -> None:
        if not self._threads:
            self._keep_one_waiting()

    def _keep_one_waiting(self) -> None:
        with self._lock:
            if self._num_waiting or self._closed:
                return
            self._num_started += 1
            thread = threading.Thread(target=self._work, name=f"{self._name}:reader{self._num_started}", daemon=True)
            self._num_waiting += 1
            self._threads.add(thread)
        try:
            # Started without holding the lock: a signal handler may stop the threads, which need the lock to exit.
            thread.start()
        except RuntimeError as error:  # the system allows no more threads; a busy one will wait when it is done
            with self._lock:
                self._remove_thread(thread)
            raise RuntimeError(
                f"no further thread can be started, so callbacks of several topics share one: {error}"
            ) from error
        self._start_failed = False

    def _work(self) -> None:
        wait = self._poller.wait
        while not self._closed:
            fd = wait(-1 if self._num_waiting <= MIN_WAITING_THREADS else IDLE_TIMEOUT)
            with self._lock:
                if fd is None and self._num_waiting > MIN_WAITING_THREADS:
                    self._remove_thread(
                        threading.current_thread()
                    )  # under the same lock, or all threads would exit together
                    return
                if fd is None or self._closed:
                    continue
                self._num_waiting -= 1
                is_last_waiting = not self._num_waiting
            try:
                if is_last_waiting:
                    self._keep_one_waiting()
            except RuntimeError as error:
                # Since Python 3.12, no thread can be started after the main thread has ended; this is not an error.
                if not self._start_failed and threading.main_thread().is_alive():
                    self._start_failed = True
                    self._report(error)
            try:
                self._run(fd)
            except BaseException as error:  # noqa: BLE001  a bug in pyros1; the other subscriptions must go on
                self._report(error)
            finally:
                with self._lock:
                    self._num_waiting += 1
        with self._lock:
            self._remove_thread(threading.current_thread())

    def _report(self, error: BaseException) -> None:
        try:
            self._on_error(error)
        except Exception as report_error:  # noqa: BLE001  this thread must go on
            with contextlib.suppress(Exception):
                sys.stderr.write(f"{self._name}: {error!r}; reporting this also failed: {report_error!r}\n")

    @property
    def has_waiting_thread(self) -> bool:
        """Whether a thread is waiting for the next message, so that the calling thread may wait for a single link."""
        return self._num_waiting > 0

    def _remove_thread(self, thread: threading.Thread) -> None:
        """Forget a thread that is exiting or was not started; the last one closes the poller. Called with the lock
        held.
        """
        self._num_waiting -= 1
        self._threads.discard(thread)
        if self._closed and not self._threads:
            self._poller.close()

    def _run(self, fd: int) -> None:
        if fd != WAKE:
            delivery = self._deliveries.get(fd)
            if delivery is not None:
                delivery.run(fd)
            return
        try:
            delivery = self._woken_deliveries.popleft()
        except IndexError:
            return  # another thread was quicker
        if self._woken_deliveries:
            self._poller.wake()  # several wake-ups may have been merged into one
        delivery.run(None)
