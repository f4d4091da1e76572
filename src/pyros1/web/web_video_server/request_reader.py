"""Reads a request from a connection within a time limit."""

from __future__ import annotations

import io
import socket
from collections.abc import Callable
from time import monotonic
from typing import Any


class RequestReader(io.RawIOBase):
    """Reads a connection's bytes until a deadline, however slowly they arrive.

    A socket timeout would start again with each byte, so a few slow clients could occupy all connections.

    Args:
        connection: the connection.
        seconds: seconds after which reading raises TimeoutError.
        clock: returns the time in seconds.
    """

    def __init__(self, connection: socket.socket, seconds: float, clock: Callable[[], float] = monotonic) -> None:
        super().__init__()
        self._connection = connection
        self._clock = clock
        self._deadline = clock() + seconds

    def readable(self) -> bool:
        """Return True."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read into a buffer; return the number of bytes, 0 at the end.

        Raises:
            TimeoutError: the deadline has passed.
            OSError: the connection is broken.
        """
        remaining = self._deadline - self._clock()
        if remaining <= 0.0:
            raise TimeoutError("the request was not complete in time")
        self._connection.settimeout(remaining)
        return self._connection.recv_into(buffer)
