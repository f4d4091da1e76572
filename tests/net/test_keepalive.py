"""keepalive: sockets that notice when the other machine is gone."""

from __future__ import annotations

import socket
import struct
import sys

import pytest

from pyros1.net import keepalive
from pyros1.net.keepalive import enable_keepalive, is_peer_dead


def test_the_times_are_those_of_stock_t37() -> None:
    with socket.socket() as sock:
        enable_keepalive(sock)
        assert sock.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        if sys.platform == "linux":
            options = (socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT)
            assert [sock.getsockopt(socket.IPPROTO_TCP, option) for option in options] == [60, 10, 9]


def test_a_closed_socket_is_no_error() -> None:
    sock = socket.socket()
    sock.close()
    enable_keepalive(sock)
    with pytest.raises(OSError):
        sock.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)


class Silent(socket.socket):
    """A socket whose system says how long the other machine has been silent."""

    def __init__(self, retransmits: int, probes: int, seconds: float) -> None:
        super().__init__()
        self.info = struct.pack("@2x2B52xI", retransmits, probes, int(1000 * seconds))

    def getsockopt(self, *_: int) -> bytes:  # type: ignore[override]  # only for one option
        return self.info


@pytest.mark.parametrize(
    ("retransmits", "probes", "seconds", "gone"),
    [
        (9, 0, 160, True),  # data were sent again and again
        (0, 3, 160, True),  # nobody answers whether there is room again
        (9, 0, 100, False),
        (0, 1, 160, False),  # alive, but it has not read for long
        (0, 0, 10_000, False),  # nothing was sent
    ],
)
def test_a_silent_machine_with_data_under_way(retransmits: int, probes: int, seconds: float, gone: bool) -> None:
    with Silent(retransmits, probes, seconds) as sock:
        assert is_peer_dead(sock) is gone


@pytest.mark.skipif(sys.platform != "linux", reason="the layout is Linux's")
def test_the_system_says_when_it_has_heard_of_the_other_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(keepalive, "MIN_UNANSWERED", 0)
    monkeypatch.setattr(keepalive, "PROBE_IDLE_TIME", 0)
    monkeypatch.setattr(keepalive, "PROBE_INTERVAL", 0)
    with socket.create_server(("127.0.0.1", 0)) as listener, socket.socket() as sock:
        sock.connect(listener.getsockname())
        sock.send(b"x")
        assert is_peer_dead(sock)
        monkeypatch.setattr(keepalive, "PROBE_IDLE_TIME", 3600)
        assert not is_peer_dead(sock)
    assert not is_peer_dead(sock)
