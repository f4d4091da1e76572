"""A poller with which several threads wait for many sockets together; each event wakes one thread.

A socket that was reported is not reported again until `rearm` is called; until then the thread that received it may use
it exclusively. On Linux, all threads wait in epoll with EPOLLONESHOT. Elsewhere, one thread at a time waits in a
selector.
"""

from __future__ import annotations

import contextlib
import select
import selectors
import socket
import threading
from collections import deque

from pyros1.net.signal_safe import Event

WAKE = -1
"""Result of `wait` after a call to `wake`."""


class Poller:
    """A set of sockets for which several threads wait. All methods are thread-safe.

    Args:
        portable: whether to use a selector even where epoll is available.
    """

    def __init__(self, portable: bool = False) -> None:
        self._wake_receiver, self._wake_sender = socket.socketpair()
        self._wake_receiver.setblocking(False)
        self._wake_sender.setblocking(False)
        self._wake_fd = self._wake_receiver.fileno()
        self._backend = _SelectorBackend() if portable or not hasattr(select, "EPOLLONESHOT") else _EpollBackend()
        self._backend.add(self._wake_fd)

    def register(self, fd: int) -> None:
        """Start waiting for a descriptor."""
        self._backend.add(fd)

    def unregister(self, fd: int) -> None:
        """Stop waiting for a descriptor, which must still be open; `wait` may have just returned it in another thread.
        Allowed after `close`.
        """
        self._backend.remove(fd)

    def rearm(self, fd: int) -> None:
        """Wait again for a descriptor that `wait` has returned."""
        self._backend.rearm(fd)

    def wait(self, timeout: float = -1) -> int | None:
        """Wait for a descriptor.

        Args:
            timeout: maximum number of seconds; -1 for no limit.

        Returns:
            A readable descriptor, WAKE after a call to `wake`, or None after the timeout.
        """
        fd = self._backend.wait(timeout)
        if fd != self._wake_fd:
            return fd
        with contextlib.suppress(BlockingIOError):
            self._wake_receiver.recv(1)
        self._backend.rearm(self._wake_fd)
        return WAKE

    def wake(self) -> None:
        """Make one call of `wait` return WAKE: a pending one, or the next. If very many calls of `wake` are made at the
        same time, some have no effect.
        """
        with contextlib.suppress(OSError):
            self._wake_sender.send(b"\0")

    def close(self) -> None:
        """Release the descriptors. No thread may be in `wait`, or call it later."""
        self._backend.close()
        self._wake_receiver.close()
        self._wake_sender.close()


class _EpollBackend:
    def __init__(self) -> None:
        self._epoll = select.epoll()
        self._mask = select.EPOLLIN | select.EPOLLONESHOT

    def add(self, fd: int) -> None:
        self._epoll.register(fd, self._mask)

    def rearm(self, fd: int) -> None:
        self._epoll.modify(fd, self._mask)

    def remove(self, fd: int) -> None:
        try:
            self._epoll.unregister(fd)
        except ValueError:
            if not self._epoll.closed:  # closing it removes all descriptors
                raise

    def wait(self, timeout: float) -> int | None:
        events = self._epoll.poll(timeout, 1)
        return events[0][0] if events else None

    def close(self) -> None:
        self._epoll.close()


class _SelectorBackend:
    """A replacement for epoll. Only the thread that waits in the selector changes its set of sockets.

    No other thread ever waits for a lock, so signal handlers may call any method.
    """

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()
        self._select_lock = threading.Lock()  # locked by the thread that waits in the selector
        self._changes: deque[tuple[int, bool, Event | None]] = deque()
        self._wake_receiver, self._wake_sender = socket.socketpair()
        self._wake_receiver.setblocking(False)
        self._wake_sender.setblocking(False)
        self._selector.register(self._wake_receiver, selectors.EVENT_READ)

    def add(self, fd: int) -> None:
        self._request_change(fd, True)

    rearm = add

    def remove(self, fd: int) -> None:
        removed = Event()
        self._request_change(fd, False, removed)
        # After this, the owner may close the descriptor. If no thread is waiting in the selector now, the next thread
        # that is about to wait there removes the descriptor first.
        while self._select_lock.locked() and not removed.wait(0.1):
            pass

    def _request_change(self, fd: int, is_added: bool, applied: Event | None = None) -> None:
        self._changes.append((fd, is_added, applied))
        with contextlib.suppress(OSError):
            self._wake_sender.send(b"\0")

    def _apply_changes(self) -> None:
        """Make the requested changes, in order. Called by the thread that holds the lock."""
        while self._changes:
            fd, is_added, applied = self._changes.popleft()
            with contextlib.suppress(KeyError, ValueError, OSError):
                if is_added:
                    self._selector.register(fd, selectors.EVENT_READ)
                else:
                    self._selector.unregister(fd)
            if applied is not None:
                applied.set()

    def wait(self, timeout: float) -> int | None:
        if not self._select_lock.acquire(timeout=timeout):
            return None
        try:
            while True:
                self._apply_changes()
                events = self._selector.select(None if timeout < 0 else timeout)
                if not events:
                    return None
                for key, _ in events:
                    if key.fileobj is not self._wake_receiver:
                        self._selector.unregister(key.fd)
                        return key.fd
                with contextlib.suppress(BlockingIOError):
                    self._wake_receiver.recv(4096)
        finally:
            self._select_lock.release()

    def close(self) -> None:
        self._selector.close()
        self._wake_receiver.close()
        self._wake_sender.close()
