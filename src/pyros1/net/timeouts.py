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
"""Maximum number of unsent bytes that a socket accepts; see `limit_unsent`."""

SOCKET_TIMEOUTS = (BlockingIOError, TimeoutError)
"""The exceptions that a socket call raises after a timeout."""


class TransferDeadline:
    """The deadline of a transfer, which is extended while data are transferred at an average rate of at least
    MIN_BYTES_PER_SECOND.

    So a large value can be sent over a slow link, but the transfer fails if the peer stops, or sends only a byte now
    and then.

    Args:
        seconds: maximum time without any progress; also the time by which the transfer may lag behind the minimum rate.
    """

    __slots__ = ("_last_progress_at", "_num_bytes", "_seconds", "_started_at")

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._started_at = self._last_progress_at = monotonic()
        self._num_bytes = 0

    def add_bytes(self, count: int) -> None:
        """Record that ``count`` more bytes were received or sent."""
        self._num_bytes += count
        self._last_progress_at = monotonic()

    def remaining(self) -> float:
        """Return the remaining seconds; 0 or less if the deadline has passed."""
        return (
            self._seconds
            + min(self._last_progress_at, self._started_at + self._num_bytes / MIN_BYTES_PER_SECOND)
            - monotonic()
        )


def limit_unsent(sock: socket.socket) -> None:
    """Limit the unsent bytes that a TCP socket accepts, so that the sender notices the progress of the transfer."""
    if hasattr(socket, "TCP_NOTSENT_LOWAT"):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, _MAX_UNSENT)


def set_socket_timeouts(sock: socket.socket, seconds: float, receive_seconds: float | None = None) -> bool:
    """Set the timeouts for receiving from and sending to a socket.

    Args:
        sock: a connected socket.
        seconds: the timeout in seconds; must be positive.
        receive_seconds: the timeout for receiving; None for ``seconds``. Without kernel support, ``seconds`` is used
            for both.

    Returns:
        Whether the timeouts were set in the kernel; otherwise `settimeout` was used.
    """
    if not _HAS_KERNEL_TIMEOUTS:
        sock.settimeout(seconds)
        return False
    sock.settimeout(None)
    timeval = _timeval(seconds)
    sock.setsockopt(
        socket.SOL_SOCKET, socket.SO_RCVTIMEO, timeval if receive_seconds is None else _timeval(receive_seconds)
    )
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, timeval)
    return True


def _timeval(seconds: float) -> bytes:
    whole_seconds = int(seconds)
    return struct.pack("@ll", whole_seconds, max(1, int((seconds - whole_seconds) * 1e6)))
