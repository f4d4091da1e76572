"""Accepts connections to a port, on a loop, and continues after the process has temporarily run out of file
descriptors."""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Callable
from math import inf
from time import monotonic
from typing import TYPE_CHECKING, Final

from pyros1.net.loop import READ
from pyros1.net.socket_close import shutdown_and_close

if TYPE_CHECKING:
    from pyros1.net.allowlist import Allowlist
    from pyros1.net.loop import Loop

RETRY_DELAY: Final = 0.2
"""Seconds to wait after a failure to accept; otherwise the system would report the waiting peer again immediately."""
REPORT_INTERVAL: Final = 60.0
"""Seconds without a failure after which the next failure is reported again."""
_MAX_CONNECTIONS_PER_TURN: Final = 64  # after these, the loop serves its other sockets


def is_out_of_files(error: BaseException | None) -> bool:
    """Return whether an error, or one of its causes, means that this process or the system has too many open files."""
    while error is not None:
        if isinstance(error, OSError) and error.errno in (errno.EMFILE, errno.ENFILE):
            return True
        error = error.__cause__
    return False


class Acceptor:
    """Accepts connections as soon as the loop runs. Peers that cannot be accepted wait in the system's queue.

    Args:
        loop: the loop on which everything runs.
        listener: a listening socket, which the acceptor takes over and closes.
        on_connection: called with each accepted socket, which is non-blocking.
        warn: called with a message when connections cannot be accepted; called again only after a minute without
            failures.
        make_room: called when connections cannot be accepted, to close connections that are not needed.
        allowlist: decides which peers may connect; None admits all.
    """

    def __init__(
        self,
        loop: Loop,
        listener: socket.socket,
        on_connection: Callable[[socket.socket], object],
        warn: Callable[[str], object],
        make_room: Callable[[], object] = lambda: None,
        allowlist: Allowlist | None = None,
    ) -> None:
        self._loop = loop
        self._listener = listener
        self._on_connection = on_connection
        self._warn = warn
        self._make_room = make_room
        self._allowlist = allowlist
        self._last_failure_at = -inf  # on the monotonic clock
        self._closed = False
        listener.setblocking(False)
        loop.call_soon(self._listen)

    def close(self) -> None:
        """Close the port. Called on the loop."""
        if not self._closed:
            self._closed = True
            self._loop.unregister(self._listener)
            shutdown_and_close(self._listener)

    def _listen(self) -> None:
        if not self._closed:
            self._loop.register(self._listener, READ, self._on_readable)

    def _on_readable(self, _mask: int) -> None:
        for _ in range(_MAX_CONNECTIONS_PER_TURN):
            try:
                sock, address = self._listener.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:
                self._pause(error)
                return
            if self._allowlist is not None and not self._allowlist.admit(sock, address):
                continue
            sock.setblocking(False)
            self._on_connection(sock)
            if self._closed:
                return

    def _pause(self, error: OSError) -> None:
        self._loop.unregister(self._listener)
        self._loop.call_later(RETRY_DELAY, self._listen)
        self._make_room()
        previous_failure_at, self._last_failure_at = self._last_failure_at, monotonic()
        if self._last_failure_at - previous_failure_at > REPORT_INTERVAL:
            self._warn(
                f"cannot accept a connection: {error.strerror}{_file_limit_hint() if is_out_of_files(error) else ''}"
            )


def _file_limit_hint() -> str:
    """Return the limit of open files and how to change it; an empty string if the system does not report it."""
    # The module `resource` cannot be used here: importing that module would open a file.
    return f". The limit of open files is {os.sysconf('SC_OPEN_MAX')}: see ulimit -n" if hasattr(os, "sysconf") else ""
