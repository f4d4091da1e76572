"""Timeouts of sockets that the kernel keeps.

With a timeout of its own, Python asks before each call whether the socket is ready: two system calls instead of one.
The socket options SO_RCVTIMEO and SO_SNDTIMEO need only one. At such a timeout the call raises BlockingIOError.
"""

from __future__ import annotations

import socket
import struct
import sys

_DIRECT = sys.platform != "win32" and hasattr(socket, "SO_RCVTIMEO") and hasattr(socket, "SO_SNDTIMEO")

WaitOver = (BlockingIOError, TimeoutError)
"""The exceptions of a call that has timed out."""


def bound_waits(sock: socket.socket, seconds: float, receive: float | None = None) -> bool:
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
