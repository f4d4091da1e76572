"""Limits the number of connections that are not admitted yet: anyone can open them, without a token."""

from __future__ import annotations

import contextlib
import socket
from asyncio import BaseTransport
from typing import TYPE_CHECKING, Any, cast

from websockets.asyncio.server import ServerConnection
from websockets.protocol import State

from pyros1.web.server.shared_transport import SharedTransport

if TYPE_CHECKING:
    from asyncio import Transport

    from pyros1.net.allowlist import Allowlist

MAX_PENDING = 128
"""Maximum number of pending connections; beyond that, the oldest are closed. Pages are admitted immediately."""

ACK_TIMEOUT = 6_000
"""Milliseconds within which a client must acknowledge sent data, or its connection is closed. A ping would not detect
in time that a client is gone, as it is queued behind the unsent data."""


class PendingConnections:
    """The connections that are not admitted yet.

    Args:
        allowlist: decides which machines may connect; None for all machines.
        max_pending: maximum number of pending connections; beyond that, the oldest are closed.
    """

    def __init__(self, allowlist: Allowlist | None = None, max_pending: int = MAX_PENDING) -> None:
        self._allowlist = allowlist
        self._max_pending = max_pending
        self._transports: dict[_Connection, BaseTransport] = {}

    def create_connection(self, *args: Any, **options: Any) -> ServerConnection:
        """Create a connection; to be passed to websockets as ``create_connection``."""
        return _Connection(self, *args, **options)

    def add(self, connection: _Connection, transport: BaseTransport) -> None:
        """Add a new connection; if its machine may not connect, close it before anything is read."""
        peer, local = transport.get_extra_info("peername"), transport.get_extra_info("sockname")
        if self._allowlist is not None and not (peer and local and self._allowlist.admit_address(peer[0], local[0])):
            transport.abort()  # type: ignore[attr-defined]
            return
        with contextlib.suppress(AttributeError, OSError):  # systems without this option keep a dead connection longer
            transport.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, ACK_TIMEOUT)
        self._transports[connection] = transport
        while len(self._transports) > self._max_pending:
            self._transports.pop(next(iter(self._transports))).abort()  # type: ignore[attr-defined]

    def remove(self, connection: object) -> None:
        """Remove a connection that was admitted or closed."""
        self._transports.pop(connection, None)  # type: ignore[call-overload]


class _Connection(ServerConnection):
    def __init__(self, pending_connections: PendingConnections, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._pending_connections = pending_connections

    def connection_made(self, transport: BaseTransport) -> None:
        # No thread may send data after the frame that closes the connection; the state changes before it is written.
        shared = SharedTransport(cast("Transport", transport), self.loop, lambda: self.state is State.OPEN)
        self._shared_transport = shared
        super().connection_made(shared)
        self._pending_connections.add(self, shared)

    def connection_lost(self, exc: Exception | None) -> None:
        self._shared_transport.lose()
        self._pending_connections.remove(self)
        super().connection_lost(exc)
