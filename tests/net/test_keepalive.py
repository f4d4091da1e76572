"""keepalive: sockets that notice when the other machine is gone."""

from __future__ import annotations

import socket
import sys

import pytest

from pyros1.net.keepalive import keep_alive


def test_the_times_are_those_of_stock_t37() -> None:
    with socket.socket() as sock:
        keep_alive(sock)
        assert sock.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        if sys.platform == "linux":
            options = (socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT)
            assert [sock.getsockopt(socket.IPPROTO_TCP, option) for option in options] == [60, 10, 9]


def test_a_closed_socket_is_no_error() -> None:
    sock = socket.socket()
    sock.close()
    keep_alive(sock)
    with pytest.raises(OSError):
        sock.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
