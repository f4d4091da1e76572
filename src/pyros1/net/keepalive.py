"""TCP keep-alive, which ends links to a machine that was switched off."""

from __future__ import annotations

import contextlib
import socket


def keep_alive(sock: socket.socket) -> None:
    """Let a socket notice within some minutes that the other machine is gone (T37)."""
    with contextlib.suppress(OSError):
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for option, value in (("TCP_KEEPIDLE", 60), ("TCP_KEEPINTVL", 10), ("TCP_KEEPCNT", 9)):
            if hasattr(socket, option):  # not available on every system
                sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)
