"""Waiting for many sockets in one thread, with the least overhead that the machine offers.

`selectors` builds a key object per event; on Linux epoll's own answer, a list of (descriptor, events), is enough.
"""

from __future__ import annotations

import contextlib
import select
import selectors
import socket

MOST_EVENTS = 32  # taken at a time; the default would allocate room for a thousand at each call


class _Selector:
    """The portable fallback, with epoll's interface."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()

    def register(self, fd: int) -> None:
        self._selector.register(fd, selectors.EVENT_READ)

    def unregister(self, fd: int) -> None:
        self._selector.unregister(fd)

    def poll(self, _timeout: float, _most: int) -> list[tuple[int, int]]:
        return [(key.fd, mask) for key, mask in self._selector.select()]

    def close(self) -> None:
        self._selector.close()


class Poller:
    """Waits until one of the registered sockets can be read, or until woken.

    All methods but `wake` belong to the thread that waits, or to the time before it starts.
    """

    def __init__(self) -> None:
        self._poll = select.epoll() if hasattr(select, "epoll") else _Selector()
        self._bell, self._button = socket.socketpair()
        self._bell.setblocking(False)
        self._button.setblocking(False)
        self._bell_fd = self._bell.fileno()
        self.register(self._bell_fd)

    def register(self, fd: int) -> None:
        """Start to wait for that descriptor."""
        if isinstance(self._poll, _Selector):
            self._poll.register(fd)
        else:
            self._poll.register(fd, select.EPOLLIN)

    def unregister(self, fd: int) -> None:
        """Stop to wait for that descriptor; it must still be open."""
        self._poll.unregister(fd)

    def wait(self) -> list[tuple[int, int]]:
        """Wait, without limit of time, and return (descriptor, events) pairs; a wake-up alone gives an empty list."""
        events = self._poll.poll(-1, MOST_EVENTS)
        for index, (fd, _) in enumerate(events):
            if fd == self._bell_fd:
                with contextlib.suppress(BlockingIOError):
                    self._bell.recv(4096)
                del events[index]
                break
        return events

    def wake(self) -> None:
        """Make `wait` return, now or the next time. Any thread; a full pipe means that a wake-up is under way."""
        with contextlib.suppress(OSError):
            self._button.send(b"\0")

    def close(self) -> None:
        """Release the descriptors."""
        self._poll.close()
        self._bell.close()
        self._button.close()
