"""The end of a socket, even if other processes share it: those that were forked, as by ``multiprocessing``."""

from __future__ import annotations

import contextlib
import socket


def shutdown_and_close(sock: socket.socket) -> None:
    """Close a connection, or a port, for all processes: with `close` alone, it ends when the last of them ends."""
    with contextlib.suppress(OSError):  # the other side has gone; or the system cannot do that with a port
        sock.shutdown(socket.SHUT_RDWR)
    sock.close()
