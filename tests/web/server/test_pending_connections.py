"""Connections that have not come in, with the server's own limits."""

from __future__ import annotations

import socket
from asyncio import BaseTransport
from typing import Any

from pyros1.web.server.pending_connections import PendingConnections


class Transport(BaseTransport):
    """A transport that notes whether it was aborted."""

    def __init__(self, connection: socket.socket | None = None) -> None:
        super().__init__({"socket": connection})
        self.aborted = False

    def abort(self) -> None:
        self.aborted = True


def test_the_129th_connection_ends_the_oldest() -> None:
    pending_connections = PendingConnections()
    transports = [Transport() for _ in range(129)]
    for number, transport in enumerate(transports):
        key: Any = number
        assert not any(each.aborted for each in transports)
        pending_connections.add(key, transport)
    assert [number for number, each in enumerate(transports) if each.aborted] == [0]


def test_what_is_sent_must_be_acknowledged_within_six_seconds() -> None:
    with socket.socket() as connection:
        key: Any = "connection"
        PendingConnections().add(key, Transport(connection))
        assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == 6000
