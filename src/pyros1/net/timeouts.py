"""How long to wait for sockets.

`TransferDeadline` is for data of any size on links of any speed. `set_socket_timeouts` sets timeouts that the kernel
keeps: with a timeout of its own, Python asks before each call whether the socket is ready, which takes two system calls
instead of one. At such a timeout the call raises BlockingIOError.
"""

from __future__ import annotations

import socket
import struct
import sys
from time import monotonic
from typing import Final

_DIRECT = sys.platform != "win32" and hasattr(socket, "SO_RCVTIMEO") and hasattr(socket, "SO_SNDTIMEO")

MIN_RATE: Final = 1000.0
"""Minimum rate of a transfer in the long run, in bytes per second."""
_UNSENT: Final = 16 * 1024

SOCKET_TIMEOUTS = (BlockingIOError, TimeoutError)
"""The exceptions of a call that has timed out."""


class TransferDeadline:
    """How long to wait for data that arrive or leave in pieces: as long as they move, and are not slower than MIN_RATE.

    So a large value gets through a slow link, but a peer that stops, or sends byte after byte, is given up.

    Args:
        seconds: longest pause, and the time in which the data may be slower.
    """

    __slots__ = ("_bytes", "_last_progress", "_seconds", "_started")

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._started = self._last_progress = monotonic()
        self._bytes = 0

    def add_bytes(self, count: int) -> None:
        """Record that this many bytes were received or sent."""
        self._bytes += count
        self._last_progress = monotonic()

    def remaining(self) -> float:
        """Return the seconds that are left; not above 0: too late."""
        return self._seconds + min(self._last_progress, self._started + self._bytes / MIN_RATE) - monotonic()


def limit_unsent(sock: socket.socket) -> None:
    """Let a TCP socket take few bytes that it cannot send yet, so that a sender sees how they go."""
    if hasattr(socket, "TCP_NOTSENT_LOWAT"):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, _UNSENT)


def set_socket_timeouts(sock: socket.socket, seconds: float, receive: float | None = None) -> bool:
    """Set the timeout of each receive and send on a socket.

    Args:
        sock: a connected socket.
        seconds: above 0.
        receive: seconds for receiving; None: as for sending. Without kernel support, ``seconds`` is used for both.

    Returns:
        Whether the kernel keeps the timeout; otherwise Python does, with `settimeout`.
    """
    if not _DIRECT:
        sock.settimeout(seconds)
        return False
    sock.settimeout(None)
    value = _timeval(seconds)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, value if receive is None else _timeval(receive))
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, value)
    return True


def _timeval(seconds: float) -> bytes:
    whole = int(seconds)
    return struct.pack("@ll", whole, max(1, int((seconds - whole) * 1e6)))
