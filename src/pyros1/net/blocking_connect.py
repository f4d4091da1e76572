"""Connects a waiting thread to a TCP port, in a bounded time, name look-up included."""

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
"""Seconds between checks whether to continue."""


class _DeadlineExceeded(TimeoutError):
    """The time is over; other timeouts are those of `check`."""


def blocking_connect(host: str, port: int, seconds: float, check: Callable[[], object]) -> socket.socket:
    """Return a connected socket.

    Args:
        host: name or address; all its addresses are tried.
        seconds: longest time in all.
        check: called at least every POLL_INTERVAL seconds; what it raises ends the attempt.

    Raises:
        UnknownHostError: the name cannot be resolved in time.
        TimeoutError: there is no answer in time.
        OSError: the connection was refused, or there is no way to the host.
    """
    deadline = monotonic() + seconds

    def step(end: float = deadline) -> float:
        check()
        remaining = end - monotonic()
        if remaining <= 0:
            raise _DeadlineExceeded(f"no answer within {seconds:g} s")
        return min(POLL_INTERVAL, remaining)

    last: OSError = OSError("no address")
    addresses = _addresses(host, step)
    for number, address in enumerate(addresses):
        sock = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_STREAM)
        try:
            share = monotonic() + (deadline - monotonic()) / (len(addresses) - number)
            _connect(sock, address, port, partial(step, share))
        except BaseException as error:
            sock.close()
            if not isinstance(error, OSError):
                raise
            check()
            if not isinstance(last, ConnectionRefusedError):  # which says more than that there is no way to the others
                last = error
        else:
            return sock
    raise last


def _addresses(host: str, step: Callable[[], float]) -> list[str]:
    resolve_host = HostLookup(host)
    silent: TimeoutError | None = None
    while True:
        try:
            wait = step()
        except _DeadlineExceeded as error:
            if silent is None:
                raise
            raise UnknownHostError(host, silent) from error
        try:
            return resolve_host.wait(wait)
        except TimeoutError as error:
            silent = error
        except OSError as error:
            raise UnknownHostError(host, error) from error


def _connect(sock: socket.socket, address: str, port: int, step: Callable[[], float]) -> None:
    sock.setblocking(False)
    code = sock.connect_ex((address, port))
    while code in IN_PROGRESS:
        if _writable(sock, step()):
            code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
    if not code and sock.getsockname() == sock.getpeername():  # connected to itself, see net.connect
        code = errno.ECONNREFUSED
    if code:
        raise OSError(code, os.strerror(code))


def _writable(sock: socket.socket, seconds: float) -> bool:
    if hasattr(select, "poll"):
        poll = select.poll()
        poll.register(sock, select.POLLOUT)
        return bool(poll.poll(seconds * 1000))
    return bool(select.select([], [sock], [sock], seconds)[1])
