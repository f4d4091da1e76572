"""Makes connections fail within a few minutes if the other machine was switched off or has become unreachable."""

from __future__ import annotations

import contextlib
import socket
import struct
from typing import Final

PROBE_IDLE_TIME: Final = 60
"""Seconds of silence after which the system sends the first keep-alive probe, as in stock ROS (T37)."""
PROBE_INTERVAL: Final = 10
"""Seconds between two keep-alive probes."""
MAX_PROBES: Final = 9
"""Number of unanswered probes after which the connection is closed."""
MIN_UNANSWERED: Final = 3
"""Minimum number of unanswered retransmissions or probes before a silent machine is considered gone."""

_TCP_INFO = struct.Struct("@2x2B52xI")  # of struct tcp_info: retransmits, probes, last_ack_recv in ms


def enable_keepalive(sock: socket.socket) -> None:
    """Enable keep-alive probes, so that a socket notices within a few minutes that the other machine is gone (T37)."""
    with contextlib.suppress(OSError):
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for option, value in (
            ("TCP_KEEPIDLE", PROBE_IDLE_TIME),
            ("TCP_KEEPINTVL", PROBE_INTERVAL),
            ("TCP_KEEPCNT", MAX_PROBES),
        ):
            if hasattr(socket, option):  # not available on every system
                sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)


def set_nodelay_and_keepalive(sock: socket.socket) -> None:
    """Make a TCP socket send data without delay, and enable keep-alive probes; leave other sockets unchanged."""
    if sock.family in (socket.AF_INET, socket.AF_INET6):
        enable_keepalive(sock)
        # On some systems, this call reports that the peer is gone; the next read will report it, too.
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def is_peer_dead(sock: socket.socket) -> bool:
    """Return whether the other machine has been silent for too long although it should have acknowledged data.

    While data are unacknowledged, there are no keep-alive probes: the system retransmits for a quarter of an hour. A
    peer that merely does not read is not considered dead: its machine still acknowledges the window probes. (The
    option TCP_USER_TIMEOUT would close the connection in that case as well.)
    """
    if not hasattr(socket, "TCP_INFO"):
        return False
    try:
        info = sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _TCP_INFO.size)
    except OSError:
        return False
    if len(info) < _TCP_INFO.size:
        return False
    retransmits, probes, silent_ms = _TCP_INFO.unpack(info)
    return bool(
        max(retransmits, probes) >= MIN_UNANSWERED
        and silent_ms >= 1000 * (PROBE_IDLE_TIME + PROBE_INTERVAL * MAX_PROBES)
    )
