"""Timeouts of sockets.

`TransferDeadline` is for data of any size on links of any speed. `set_socket_timeouts` sets timeouts in the kernel:
with `settimeout`, Python would check before each call whether the socket is ready, which takes two system calls instead
of one. After a kernel timeout the call raises BlockingIOError.
"""

from __future__ import annotations

import socket
import struct
import sys
from time import monotonic
from typing import Final

_HAS_KERNEL_TIMEOUTS = sys.platform != "win32" and hasattr(socket, "SO_RCVTIMEO") and hasattr(socket, "SO_SNDTIMEO")

MIN_BYTES_PER_SECOND: Final = 1000.0
"""Minimum average rate of a transfer, in bytes per second."""
_MAX_UNSENT: Final = 16 * 1024

SOCKET_TIMEOUTS = (BlockingIOError, TimeoutError)
"""The exceptions that a socket call raises after a timeout."""


class TransferDeadline:
    """The deadline of a transfer, extended as long as data are transferred at no less than MIN_RATE on average.

    So a large value can pass a slow link, but the transfer fails if the peer stops, or sends only a byte now and then.

    Args:
        seconds: maximum pause, and the initial time during which the transfer may be slower.
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
        """Return the remaining seconds; 0 or less if the deadline has passed."""
        return (
            self._seconds + min(self._last_progress, self._started + self._bytes / MIN_BYTES_PER_SECOND) - monotonic()
        )


def limit_unsent(sock: socket.socket) -> None:
    """Limit the unsent bytes that a TCP socket accepts, so that the sender notices the progress of the transfer."""
    if hasattr(socket, "TCP_NOTSENT_LOWAT"):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, _MAX_UNSENT)


def set_socket_timeouts(sock: socket.socket, seconds: float, receive: float | None = None) -> bool:
    """Set the timeout of each receive and send on a socket.

    Args:
        sock: a connected socket.
        seconds: the timeout in seconds; must be positive.
        receive: the timeout for receiving, if different. Without kernel support, ``seconds`` is used for both.

    Returns:
        Whether the timeouts were set in the kernel; otherwise `settimeout` was used.
    """
    if not _HAS_KERNEL_TIMEOUTS:
        sock.settimeout(seconds)
        return False
    sock.settimeout(None)
    value = _timeval(seconds)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, value if receive is None else _timeval(receive))
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, value)
    return True


def _timeval(seconds: float) -> bytes:
    whole_seconds = int(seconds)
    return struct.pack("@ll", whole_seconds, max(1, int((seconds - whole_seconds) * 1e6)))
