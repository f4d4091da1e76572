"""Links to a machine that was switched off, or that the network no longer reaches, end after some minutes."""

from __future__ import annotations

import contextlib
import socket
import struct
from typing import Final

IDLE: Final = 60
"""Seconds of silence after which the system asks the other machine whether it is still alive, like stock (T37)."""
INTERVAL: Final = 10
"""Seconds between such questions."""
COUNT: Final = 9
"""Questions without an answer after which the link ends."""
UNANSWERED: Final = 3
"""Repetitions or questions without an answer before a silent machine counts as gone."""

_ACKNOWLEDGED = struct.Struct("@2x2B52xI")  # of struct tcp_info: retransmits, probes, last_ack_recv in ms


def keep_alive(sock: socket.socket) -> None:
    """Let a socket notice within some minutes that the other machine is gone (T37)."""
    with contextlib.suppress(OSError):
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for option, value in (("TCP_KEEPIDLE", IDLE), ("TCP_KEEPINTVL", INTERVAL), ("TCP_KEEPCNT", COUNT)):
            if hasattr(socket, option):  # not available on every system
                sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)


def set_nodelay_and_keepalive(sock: socket.socket) -> None:
    """Let a TCP socket send what it is given at once, and `keep_alive`; other sockets need neither."""
    if sock.family in (socket.AF_INET, socket.AF_INET6):
        keep_alive(sock)
        with contextlib.suppress(OSError):  # some systems report here that the peer has gone; a read reports it as well
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def is_peer_dead(sock: socket.socket) -> bool:
    """Return whether the other machine has been silent for so long, although it has something to acknowledge.

    While data are under way there is no keep-alive: the system repeats them for a quarter of an hour. A program that
    does not read is no reason: its machine acknowledges each question whether there is room again. (The option
    TCP_USER_TIMEOUT would end that link as well.)
    """
    if not hasattr(socket, "TCP_INFO"):
        return False
    try:
        info = sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _ACKNOWLEDGED.size)
    except OSError:
        return False
    if len(info) < _ACKNOWLEDGED.size:
        return False
    retransmits, probes, silent_ms = _ACKNOWLEDGED.unpack(info)
    return bool(max(retransmits, probes) >= UNANSWERED and silent_ms >= 1000 * (IDLE + INTERVAL * COUNT))
