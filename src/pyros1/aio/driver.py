"""Runs delivery loops on an asyncio loop, instead of threads."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyros1.node.subscribing.delivery_loop import DeliveryLoop


class LoopDriver:
    """The driver of one node's delivery loops; all methods except `wake` and `call` run in the asyncio loop's thread.

    Args:
        loop: the running asyncio loop.
        on_error: called with each exception that a delivery loop does not handle.
    """

    cooperative = True
    has_waiting_thread = False

    def __init__(self, loop: asyncio.AbstractEventLoop, on_error: Callable[[BaseException], None]) -> None:
        self._loop = loop
        self._thread = threading.get_ident()
        self._on_error = on_error
        self._deliveries: dict[int, DeliveryLoop] = {}
        self._running_fd: int | None = None  # the socket for which a delivery loop is running, until rearmed

    def register(self, fd: int, delivery: DeliveryLoop) -> None:
        """Run a delivery loop when a socket becomes readable: once, and again after each `rearm`."""
        self._deliveries[fd] = delivery
        self._loop.add_reader(fd, self._on_readable, fd)

    def rearm(self, fd: int) -> None:
        """Watch a socket again, after its delivery loop has run."""
        if fd == self._running_fd:
            self._running_fd = None  # the asyncio loop is still watching the socket
        elif fd in self._deliveries:
            self._loop.add_reader(fd, self._on_readable, fd)

    def unregister(self, fd: int) -> None:
        """Stop watching a socket; call this before closing the socket."""
        self._deliveries.pop(fd, None)
        with contextlib.suppress(RuntimeError):  # the asyncio loop is closed
            self._loop.remove_reader(fd)

    def wake(self, delivery: DeliveryLoop) -> None:
        """Schedule a delivery loop to run soon. Thread-safe."""
        with contextlib.suppress(RuntimeError):  # the asyncio loop is closed
            self._loop.call_soon_threadsafe(self._run, delivery)

    def call(self, function: Callable[[], None], timeout: float) -> None:
        """Call a function in the asyncio loop's thread; wait at most ``timeout`` seconds until it returns."""
        if threading.get_ident() != self._thread and self._loop.is_running():
            called = threading.Event()

            def call_and_notify() -> None:
                function()
                called.set()

            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(call_and_notify)
                called.wait(timeout)
                return
        function()

    def _on_readable(self, fd: int) -> None:
        delivery = self._deliveries.get(fd)
        if delivery is None:
            return
        self._running_fd = fd
        self._run(delivery, fd)
        if self._running_fd is not None and fd in self._deliveries:
            self._loop.remove_reader(fd)
        self._running_fd = None

    def _run(self, delivery: DeliveryLoop, fd: int | None = None) -> None:
        try:
            if delivery.driver is self:
                delivery.run(fd)
            else:
                delivery.driver.wake(delivery)  # the delivery loop was moved to another driver
        except Exception as error:  # noqa: BLE001  a bug in pyros1; the other subscriptions must go on
            self._on_error(error)


def can_drive(loop: asyncio.AbstractEventLoop) -> bool:
    """Return whether an asyncio loop can wait for sockets. The default loop on Windows cannot."""
    watched_socket, other_socket = socket.socketpair()
    try:
        loop.add_reader(watched_socket, lambda: None)
        loop.remove_reader(watched_socket)
    except NotImplementedError:
        return False
    finally:
        watched_socket.close()
        other_socket.close()
    return True
