"""Connects to TCP ports without blocking the loop.

A host name may have several addresses, some of which may be unreachable (often the IPv6 addresses). So the time is
divided among all of them.
"""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING

from pyros1.ground.errors import DeadlineError, TransportError, UnknownHostError, UnreachableError
from pyros1.net.loop import WRITE

if TYPE_CHECKING:
    from pyros1.net.loop import Loop, TimerHandle

OnConnected = Callable[["socket.socket | None", "TransportError | None"], object]

IN_PROGRESS = {
    errno.EINPROGRESS,
    errno.EWOULDBLOCK,
    errno.EALREADY,
    getattr(errno, "WSAEWOULDBLOCK", errno.EINPROGRESS),
}


class ConnectHandle:
    """A connection that is being established."""

    def __init__(self, loop: Loop, host: str, port: int, timeout_s: float, on_done: OnConnected) -> None:
        self._loop = loop
        self._host = host
        self._port = port
        self._on_done: OnConnected | None = on_done
        self._addresses: list[str] = []
        self._sock: socket.socket | None = None
        self._timeout_s = timeout_s
        self._timer: TimerHandle | None = None
        self._address_timer: TimerHandle | None = None  # ends the attempt to connect to the current address
        self._deadline = 0.0
        self._is_any_refused = False

    @property
    def pending(self) -> bool:
        """Whether ``on_done`` is still to be called."""
        return self._on_done is not None

    def cancel(self) -> None:
        """Abandon the connection; ``on_done`` will not be called. Thread-safe."""
        self._on_done = None
        if self._loop.in_loop() or not self._loop.running:
            self._clean_up()
        else:
            self._loop.call_soon(self._clean_up)

    def _start(self) -> None:
        if self._on_done is None:
            return
        self._deadline = monotonic() + self._timeout_s
        self._timer = self._loop.call_later(self._timeout_s, self._on_timeout)
        self._loop.resolver.resolve(self._host, self._on_resolved)

    def _on_resolved(self, addresses: list[str], error: OSError | None) -> None:
        if self._on_done is None:
            return
        if error is not None or not addresses:
            self._fail(UnknownHostError(self._host, error))
            return
        self._addresses = list(addresses)
        self._try_next(0)

    def _try_next(self, last_error_code: int) -> None:
        """Try the remaining addresses in order. If all fail, report a refusal of the connection if there was one,
        since that error is the most informative.
        """
        self._is_any_refused = self._is_any_refused or last_error_code == errno.ECONNREFUSED
        while self._addresses:
            address = self._addresses.pop(0)
            family = socket.AF_INET6 if ":" in address else socket.AF_INET
            try:
                sock = socket.socket(family, socket.SOCK_STREAM)
            except OSError as error:
                last_error_code = error.errno or errno.EIO
                continue
            sock.setblocking(False)
            try:
                error_code = sock.connect_ex((address, self._port))
            except (OSError, OverflowError, UnicodeError) as error:
                error_code = getattr(error, "errno", None) or errno.EINVAL
            if error_code == 0 or error_code in IN_PROGRESS:
                self._sock = sock
                if error_code == 0:
                    self._on_connected()
                else:
                    self._loop.register(sock, WRITE, self._on_writable)
                    if self._addresses:
                        address_timeout_s = (self._deadline - monotonic()) / (len(self._addresses) + 1)
                        self._address_timer = self._loop.call_later(address_timeout_s, self._give_up_address)
                return
            sock.close()
            last_error_code = error_code
            self._is_any_refused = self._is_any_refused or error_code == errno.ECONNREFUSED
        if self._is_any_refused:
            last_error_code = errno.ECONNREFUSED
        failure = UnreachableError(f"cannot connect to {self._host}:{self._port}: {os.strerror(last_error_code)}")
        failure.__cause__ = OSError(last_error_code, os.strerror(last_error_code))
        self._fail(failure)

    def _give_up_address(self) -> None:
        self._close_socket()
        self._try_next(errno.ETIMEDOUT)

    def _on_writable(self, mask: int) -> None:
        sock = self._sock
        if sock is None:
            return
        error_code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        self._loop.unregister(sock)
        if error_code:
            self._close_socket()
            self._try_next(error_code)
        else:
            self._on_connected()

    def _on_connected(self) -> None:
        sock = self._sock
        on_done = self._on_done
        if sock is None or on_done is None:
            return
        try:
            # If nobody listens on the requested port of this machine, the system may choose it as the local port:
            # the socket is then connected to itself.
            is_self_connected = sock.getsockname() == sock.getpeername()
        except OSError as error:
            self._close_socket()
            self._try_next(error.errno or errno.EIO)
            return
        if is_self_connected:
            self._close_socket()
            self._try_next(errno.ECONNREFUSED)
            return
        self._sock = None
        self._on_done = None
        self._clean_up()
        on_done(sock, None)

    def _on_timeout(self) -> None:
        address = f"{self._host}:{self._port}"
        self._fail(DeadlineError(f"could not connect to {address} within {self._timeout_s:g} s"))

    def _fail(self, error: TransportError) -> None:
        on_done = self._on_done
        self._on_done = None
        self._clean_up()
        if on_done is not None:
            on_done(None, error)

    def _close_socket(self) -> None:
        if self._address_timer is not None:
            self._address_timer.cancel()
            self._address_timer = None
        if self._sock is not None:
            self._loop.unregister(self._sock)
            self._sock.close()
            self._sock = None

    def _clean_up(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._close_socket()


def connect(loop: Loop, host: str, port: int, timeout_s: float, on_done: OnConnected) -> ConnectHandle:
    """Connect to a TCP port. Thread-safe.

    Args:
        loop: the loop on which everything runs.
        host: host name or address; names are looked up without blocking the loop, and all their addresses are tried.
        port: the TCP port.
        timeout_s: maximum time in seconds, including the look-up.
        on_done: called once on the loop, with a connected non-blocking socket and None, or with None and an
            UnreachableError or DeadlineError. If ``connect`` is called on the loop, this may happen before it returns.

    Returns:
        A handle whose ``cancel()`` abandons the attempt.
    """
    handle = ConnectHandle(loop, host, port, timeout_s, on_done)
    if loop.in_loop():
        handle._start()
    else:
        loop.call_soon(handle._start)
    return handle
