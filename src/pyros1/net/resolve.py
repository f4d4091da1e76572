"""Resolves host names without blocking a loop; other threads can wait with a timeout.

The system's look-up blocks, for many seconds if a name server does not respond, so it runs in short-lived threads: at
most ``MAX_THREADS`` per loop, and one per name. Results are cached.
"""

from __future__ import annotations

import socket
import threading
from collections import deque
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING, Final

from pyros1.net.signal_safe import Event

if TYPE_CHECKING:
    from pyros1.net.loop import Loop

MAX_THREADS: Final = 8
MAX_CACHED: Final = 1000
POSITIVE_TTL_S: Final = 30.0
"""Seconds for which addresses are cached."""
NEGATIVE_TTL_S: Final = 2.0
"""Seconds for which the error of a failed look-up is cached."""

OnResolved = Callable[[list[str], "OSError | None"], object]


def direct_addresses(host: str) -> list[str] | None:
    """Return the addresses of localhost or of a numeric host; None if the name must be looked up."""
    if host == "localhost":
        return ["127.0.0.1", "::1"]
    for family in (socket.AF_INET, socket.AF_INET6):
        try:
            socket.inet_pton(family, host)
        except (OSError, ValueError, UnicodeError):
            continue
        return [host]
    return None


def resolve_host(host: str) -> list[str]:
    """Look up the addresses of a host and return them; may block.

    Raises:
        OSError: there is no such host, or the look-up failed.
    """
    try:
        entries = socket.getaddrinfo(host.encode() if host.isascii() else host, None, type=socket.SOCK_STREAM)
    except UnicodeError as error:
        raise OSError(f"{host[:60]!r} is not a host name") from error
    return list(dict.fromkeys(str(entry[4][0]) for entry in entries))


class HostLookup:
    """A look-up in a separate thread, so that the caller can stop waiting: the system's call cannot be interrupted.

    Args:
        host: a host name, or an address.
    """

    def __init__(self, host: str) -> None:
        self._host = host
        self._done = Event()
        self._addresses = direct_addresses(host) or []
        self._error: OSError | None = None
        if self._addresses:
            self._done.set()
        else:
            threading.Thread(target=self._run, name=f"look-up of {host[:60]}", daemon=True).start()

    def _run(self) -> None:
        try:
            addresses = resolve_host(self._host)
        except OSError as error:
            self._error = self._error or error
        else:
            self._addresses = addresses
        self._done.set()

    def wait(self, seconds: float) -> list[str]:
        """Wait for the addresses and return them. After a timeout, call it again to continue waiting.

        Args:
            seconds: maximum number of seconds to wait.

        Raises:
            TimeoutError: there is no result yet.
            OSError: there is no such host, the look-up failed, or it was cancelled.
        """
        if not self._done.wait(seconds):
            raise TimeoutError("no answer from the name server")
        if self._error is not None:
            raise self._error
        return self._addresses

    def cancel(self) -> None:
        """Make all calls of `wait` raise an OSError."""
        self._error = OSError("cancelled")
        self._done.set()


class Resolver:
    """Resolves host names for one loop. All methods run on the loop."""

    def __init__(self, loop: Loop) -> None:
        self._loop = loop
        self._cache: dict[str, tuple[float, list[str], OSError | None]] = {}
        self._callbacks_by_host: dict[str, list[OnResolved]] = {}
        self._queue: deque[str] = deque()
        self._num_threads = 0
        self._closed = False

    def resolve(self, host: str, on_done: OnResolved) -> None:
        """Look up a host and call ``on_done(addresses, error)``: immediately if no look-up is needed, or else later on
        the loop.
        """
        known_addresses = direct_addresses(host)
        if known_addresses is not None:
            on_done(known_addresses, None)
            return
        cached = self._cache.get(host)
        if cached is not None and cached[0] > monotonic():
            on_done(cached[1], cached[2])
            return
        callbacks = self._callbacks_by_host.get(host)
        if callbacks is not None:
            callbacks.append(on_done)
            return
        self._callbacks_by_host[host] = [on_done]
        self._queue.append(host)
        if self._num_threads < MAX_THREADS:
            self._num_threads += 1
            threading.Thread(target=self._resolve_queued, name=f"{self._loop.name} resolver", daemon=True).start()

    def close(self) -> None:
        """Start no more look-ups; those in progress continue."""
        self._closed = True
        self._queue.clear()

    def _resolve_queued(self) -> None:
        while not self._closed:
            try:
                host = self._queue.popleft()
            except IndexError:
                break
            try:
                addresses, error = resolve_host(host), None
            except OSError as failure:
                addresses, error = [], failure
            self._loop.call_soon(self._on_result, host, addresses, error)
        self._loop.call_soon(self._on_thread_exit)

    def _on_thread_exit(self) -> None:
        self._num_threads -= 1
        if self._queue and not self._closed:
            # A name was queued after the thread's last check.
            self._num_threads += 1
            threading.Thread(target=self._resolve_queued, name=f"{self._loop.name} resolver", daemon=True).start()

    def _on_result(self, host: str, addresses: list[str], error: OSError | None) -> None:
        if len(self._cache) >= MAX_CACHED:
            self._cache.clear()
        self._cache[host] = (monotonic() + (NEGATIVE_TTL_S if error else POSITIVE_TTL_S), addresses, error)
        for on_done in self._callbacks_by_host.pop(host, ()):
            on_done(addresses, error)
