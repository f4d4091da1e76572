"""Ports for programs that must be told which port to listen on, in tests that run in several processes at a time."""

from __future__ import annotations

import functools
import itertools
import os
import socket
import sys

_FIRST = 20000
_RANGES, _RANGE_SIZE = 120, 100
"""The ranges end below the ports that Linux gives to connections, so that no connection takes one before it is used."""
_SPARE = 10
"""Number of ports at the end of a range that are not returned: some tests also use the ports after the returned one."""


def free_port() -> int:
    """Return a port that nobody listens on, and that no other process of tests is given while this one runs.

    Raises:
        OSError: all ports of this process are in use.
    """
    for port in itertools.islice(_own_range().ports, _RANGE_SIZE - _SPARE):
        with socket.socket() as sock:
            if sys.platform == "linux":  # elsewhere this lets two programs listen on a port
                sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # what was closed lately is free
            try:
                sock.bind(("127.0.0.1", port))
            except OSError:
                continue
        return port
    raise OSError("all ports of this process are in use")


class Range:
    """The ports of a process: no other process has them until `close`, or the end of the process.

    Attributes:
        ports: the ports, again and again: each is used as late as possible after its last use.
    """

    def __init__(self) -> None:
        self._claim_fd: int | None = None
        number = self._claim()
        first = _FIRST + number * _RANGE_SIZE
        self.ports = itertools.cycle(range(first, first + _RANGE_SIZE - _SPARE))

    def _claim(self) -> int:
        """Return the number of a range that is free. The abstract name of a socket claims it: like ports, each network
        namespace has its own.
        """
        number = os.getpid() % _RANGES
        if sys.platform != "linux":
            return number
        claim = socket.socket(socket.AF_UNIX)
        for attempt in range(_RANGES):
            number = (os.getpid() + attempt) % _RANGES
            try:
                claim.bind(f"\0pyros1-tests-ports-{number}")
            except OSError:
                continue
            break
        else:
            raise OSError("all ranges of ports are in use")
        self._claim_fd = claim.detach()  # a process holds it until its end
        return number

    def close(self) -> None:
        """Let another process have the ports."""
        if self._claim_fd is not None:
            os.close(self._claim_fd)


@functools.cache
def _own_range() -> Range:
    return Range()
