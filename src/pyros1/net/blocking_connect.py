"""Connects to a TCP port from a blocking thread, within a time limit that includes the name look-up."""

from __future__ import annotations

import errno
import os
import select
import socket
from collections.abc import Callable
from functools import partial
from time import monotonic

from pyros1.ground.errors import UnknownHostError
from pyros1.net.connect import IN_PROGRESS
from pyros1.net.resolve import HostLookup

POLL_INTERVAL = 0.2
"""Maximum number of seconds between two calls of ``check``."""


class _DeadlineExceeded(TimeoutError):
    """The deadline of `blocking_connect` has passed. Distinguishes this from a TimeoutError raised by ``check``."""


def blocking_connect(host: str, port: int, seconds: float, check: Callable[[], object]) -> socket.socket:
    """Connect to a TCP port and return the non-blocking socket.

    Args:
        host: host name or address; all its addresses are tried.
        port: the TCP port.
        seconds: maximum total time in seconds.
        check: called at least every POLL_INTERVAL seconds; may raise an exception to abort.

    Raises:
        UnknownHostError: the name cannot be resolved in time.
        TimeoutError: there is no response in time.
        OSError: the connection was refused, or there is no route to the host.
    """
    deadline = monotonic() + seconds

    def next_wait(until: float = deadline) -> float:
        check()
        remaining = until - monotonic()
        if remaining <= 0:
            raise _DeadlineExceeded(f"no answer within {seconds:g} s")
        return min(POLL_INTERVAL, remaining)

    last_error: OSError = OSError("no address")
    addresses = _resolve(host, next_wait)
    for index, address in enumerate(addresses):
        sock = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_STREAM)
        try:
            address_deadline = monotonic() + (deadline - monotonic()) / (len(addresses) - index)
            _connect(sock, address, port, partial(next_wait, address_deadline))
        except BaseException as error:
            sock.close()
            if not isinstance(error, OSError):
                raise
            check()
            if not isinstance(last_error, ConnectionRefusedError):  # a refusal is more informative than a missing route
                last_error = error
        else:
            return sock
    raise last_error


def _resolve(host: str, next_wait: Callable[[], float]) -> list[str]:
    lookup = HostLookup(host)
    while True:
        try:
            seconds = next_wait()
        except _DeadlineExceeded as error:
            try:
                lookup.wait(0)
            except OSError as reason:
                raise UnknownHostError(host, reason) from error
            raise
        try:
            return lookup.wait(seconds)
        except TimeoutError:
            pass
        except OSError as error:
            raise UnknownHostError(host, error) from error


def _connect(sock: socket.socket, address: str, port: int, next_wait: Callable[[], float]) -> None:
    sock.setblocking(False)
    error_code = sock.connect_ex((address, port))
    while error_code in IN_PROGRESS:
        if _wait_writable(sock, next_wait()):
            error_code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
    if not error_code and sock.getsockname() == sock.getpeername():  # connected to itself, see net.connect
        error_code = errno.ECONNREFUSED
    if error_code:
        raise OSError(error_code, os.strerror(error_code))


def _wait_writable(sock: socket.socket, seconds: float) -> bool:
    if hasattr(select, "poll"):
        poll = select.poll()
        poll.register(sock, select.POLLOUT)
        return bool(poll.poll(seconds * 1000))
    return bool(select.select([], [sock], [sock], seconds)[1])
