"""Closes sockets even if forked processes, for example those of ``multiprocessing``, still have them open."""

from __future__ import annotations

import contextlib
import socket


def shutdown_and_close(sock: socket.socket) -> None:
    """Close a connection or a listening socket for all processes that have it open, which `close` alone does not."""
    with contextlib.suppress(OSError):  # the peer is gone, or the system does not support it for listening sockets
        sock.shutdown(socket.SHUT_RDWR)
    sock.close()
