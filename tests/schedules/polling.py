"""Stand-ins for the modules `select` and `selectors`: waits for the sockets of `network`, which a scheduler controls.

As on Linux, epoll forgets closed sockets, and with EPOLLONESHOT reports each once.
"""

from __future__ import annotations

import errno
import select
import selectors
from collections.abc import Callable
from typing import Any

from .network import Network, Socket, fault


class Epoll:
    """As select.epoll."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self.fd = network.open(self)
        self.watched: dict[int, int] = {}
        network.epolls.append(self)

    def register(self, number: int, mask: int) -> None:
        """Watch a descriptor."""
        self._check(number)
        if number in self.watched:
            raise FileExistsError(errno.EEXIST, "File exists")
        self.watched[number] = mask
        self._network.scheduler.point()

    def modify(self, number: int, mask: int) -> None:
        """Watch it for something else, or again."""
        self._check(number)
        if number not in self.watched:
            raise FileNotFoundError(errno.ENOENT, "No such file or directory")
        self.watched[number] = mask
        self._network.scheduler.point()

    def unregister(self, number: int) -> None:
        """Watch it no more."""
        self._check(number)
        if self.watched.pop(number, None) is None:
            raise FileNotFoundError(errno.ENOENT, "No such file or directory")
        self._network.scheduler.point()

    def poll(self, timeout: float | None = None, maxevents: int = -1) -> list[tuple[int, int]]:
        """Wait for descriptors."""
        if self.fd < 0:
            raise ValueError("I/O operation on closed epoll object")
        self._network.scheduler.wait(self._events, None if timeout is None or timeout < 0 else timeout)
        if self.fd < 0:
            raise ValueError("I/O operation on closed epoll object")
        events = self._events()
        if 0 < maxevents < len(events):
            events = events[:maxevents]
        for number, _ in events:
            mask = self.watched[number]
            if mask & select.EPOLLONESHOT:
                self.watched[number] = 0
            else:  # others come first the next time
                del self.watched[number]
                self.watched[number] = mask
        return events

    def _events(self) -> list[tuple[int, int]]:
        found = []
        for number, mask in self.watched.items():
            file = self._network.files.get(number)
            if not mask or not isinstance(file, Socket):
                continue
            event = mask & ((select.EPOLLIN * file.readable) | (select.EPOLLOUT * file.writable))
            if file.broken:
                event |= select.EPOLLERR | select.EPOLLHUP
            if event:
                found.append((number, event))
        return found

    def _check(self, number: int) -> None:
        if self.fd < 0:
            raise ValueError("I/O operation on closed epoll object")
        if number not in self._network.files:
            raise fault(errno.EBADF) if number >= 0 else ValueError("a negative descriptor")

    def close(self) -> None:
        """Close it."""
        if self.fd >= 0:
            self._network.close(self.fd)
            self._network.epolls.remove(self)
            self.fd = -1


class Poll:
    """As select.poll."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._watched: dict[int, int] = {}

    def register(self, sock: Socket | int, mask: int) -> None:
        """Watch a socket."""
        number = sock if isinstance(sock, int) else sock.fileno()
        if number < 0:
            raise ValueError(f"file descriptor cannot be a negative integer ({number})")
        self._watched[number] = mask

    def poll(self, milliseconds: float | None = None) -> list[tuple[int, int]]:
        """Wait for one of them."""
        files = {number: self._network.files.get(number) for number in self._watched}

        def events() -> list[tuple[int, int]]:
            found = []
            for number, file in files.items():
                mask = self._watched[number]
                if not isinstance(file, Socket):
                    found.append((number, select.POLLNVAL))
                elif event := mask & ((select.POLLIN * file.readable) | (select.POLLOUT * file.writable)):
                    found.append((number, event))
            return found

        self._network.scheduler.wait(events, None if milliseconds is None else milliseconds / 1e3)
        return events()


class SelectModule:
    """As the module select.

    Args:
        now: returns the network of the present run.
    """

    def __init__(self, now: Callable[[], Network]) -> None:
        self._now = now

    def epoll(self) -> Epoll:
        """Return an epoll object."""
        return Epoll(self._now())

    def poll(self) -> Poll:
        """Return a poll object."""
        return Poll(self._now())

    def __getattr__(self, name: str) -> Any:
        return getattr(select, name)


class _Key:
    """As selectors.SelectorKey."""

    def __init__(self, fileobj: Any, fd: int, events: int) -> None:
        self.fileobj, self.fd, self.events = fileobj, fd, events


class Selector:
    """As selectors.DefaultSelector."""

    def __init__(self, network: Network) -> None:
        self._epoll = Epoll(network)
        self._keys: dict[int, _Key] = {}

    def register(self, fileobj: Any, events: int) -> None:
        """Watch a socket or descriptor."""
        fd = fileobj if isinstance(fileobj, int) else fileobj.fileno()
        if fd in self._keys:
            raise KeyError(fd)
        self._epoll.register(fd, events)
        self._keys[fd] = _Key(fileobj, fd, events)

    def unregister(self, fileobj: Any) -> None:
        """Watch it no more."""
        fd = fileobj if isinstance(fileobj, int) else fileobj.fileno()
        del self._keys[fd]
        if fd in self._epoll.watched:
            self._epoll.unregister(fd)

    def select(self, timeout: float | None = None) -> list[tuple[_Key, int]]:
        """Wait."""
        return [(self._keys[fd], mask) for fd, mask in self._epoll.poll(timeout) if fd in self._keys]

    def close(self) -> None:
        """Close it."""
        self._epoll.close()


class SelectorsModule:
    """As the module selectors, whose events have the same numbers as those of epoll here."""

    def __init__(self, now: Callable[[], Network]) -> None:
        self._now = now

    def DefaultSelector(self) -> Selector:
        """Return a selector."""
        return Selector(self._now())

    def __getattr__(self, name: str) -> Any:
        return getattr(selectors, name)
