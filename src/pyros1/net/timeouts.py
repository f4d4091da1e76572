"""Waits that the kernel bounds.

Python bounds the waits of a socket by asking, before each call, whether the socket is ready: two system calls instead
of one. The socket options SO_RCVTIMEO and SO_SNDTIMEO do it in one. A wait that ends so raises BlockingIOError.
"""

from __future__ import annotations

import socket
import struct
import sys

_DIRECT = sys.platform != "win32" and hasattr(socket, "SO_RCVTIMEO") and hasattr(socket, "SO_SNDTIMEO")

WaitOver = (BlockingIOError, TimeoutError)
"""What a call raises when the wait is over."""


def bound_waits(sock: socket.socket, seconds: float, receive: float | None = None) -> bool:
    """Let each receive and send on a socket wait for so long at most.

    Args:
        sock: a connected socket.
        seconds: above 0.
        receive: the same for receiving; None: as for sending. Only the kernel can tell them apart.

    Returns:
        Whether the kernel does it; else Python does, with `settimeout`.
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
