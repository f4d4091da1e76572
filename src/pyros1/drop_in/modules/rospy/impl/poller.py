"""Waiting for file descriptors that fail."""

from __future__ import annotations

import select
from collections.abc import Iterator
from typing import Any

_select: Any = select  # its members differ between systems


class Poller:
    """Finds failed file descriptors with what the system has: kqueue, epoll or poll. For one thread.

    Attributes:
        poller: the system's object.
        add_fd, remove_fd: called with a descriptor. error_iter: yields those that have failed or were closed.
    """

    def __init__(self) -> None:
        for kind in ("kqueue", "epoll", "poll"):
            if hasattr(select, kind):
                self.poller: Any = getattr(select, kind)()
                break
        else:
            kind, self.poller = "", self.noop
        if kind == "kqueue":
            self.kevents: list[Any] = []
        self.add_fd = getattr(self, f"add_{kind}") if kind else self.noop
        self.remove_fd = getattr(self, f"remove_{kind}") if kind else self.noop
        self.error_iter = getattr(self, f"error_{kind}_iter") if kind else self.noop_iter

    def noop(self, *args: object) -> None:
        """Do nothing, where the system has nothing."""

    def noop_iter(self) -> Iterator[int]:
        """Yield nothing."""
        return iter(())

    def add_poll(self, fd: int) -> None:
        """Watch a descriptor with poll."""
        self.poller.register(fd)

    def remove_poll(self, fd: int) -> None:
        """End that."""
        self.poller.unregister(fd)

    def error_poll_iter(self) -> Iterator[int]:
        """Yield the failed descriptors."""
        return self._failed(_select.POLLHUP | _select.POLLERR)

    def add_epoll(self, fd: int) -> None:
        """Watch a descriptor with epoll."""
        self.poller.register(fd, _select.EPOLLHUP | _select.EPOLLERR | _select.EPOLLRDHUP)

    def remove_epoll(self, fd: int) -> None:
        """End that."""
        self.poller.unregister(fd)

    def error_epoll_iter(self) -> Iterator[int]:
        """Yield the failed descriptors."""
        return self._failed(_select.EPOLLHUP | _select.EPOLLERR | _select.EPOLLRDHUP)

    def _failed(self, mask: int) -> Iterator[int]:
        return (fd for fd, event in self.poller.poll(0) if event & mask)

    def add_kqueue(self, fd: int) -> None:
        """Watch a descriptor with kqueue."""
        self.kevents.append(_select.kevent(fd))

    def remove_kqueue(self, fd: int) -> None:
        """End that."""
        self.kevents[:] = [event for event in self.kevents if event.ident != fd]

    def error_kqueue_iter(self) -> Iterator[int]:
        """Yield the failed descriptors."""
        events = self.poller.control(self.kevents, len(self.kevents), 0)
        return (event.ident for event in events if event.flags & (_select.KQ_EV_ERROR | _select.KQ_EV_EOF))
