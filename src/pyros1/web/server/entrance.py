"""Connections that have not come in yet: whoever reaches the port can open them, without a token, and say nothing."""

from __future__ import annotations

import contextlib
import socket
from asyncio import BaseTransport
from typing import TYPE_CHECKING, Any

from websockets.asyncio.server import ServerConnection

if TYPE_CHECKING:
    from pyros1.net.guests import Guests

MOST = 128
"""Most connections that have not come in. The oldest make room, as those of pages come in within moments."""

TAKEN = 6_000
"""Milliseconds within which a client takes of what is sent, or its connection ends. Whoever takes nothing gets no ping
either: it waits behind the rest."""


class Entrance:
    """The connections that have not come in.

    Args:
        guests: decides from which machines one may connect; None: from all.
        most: how many.
    """

    def __init__(self, guests: Guests | None = None, most: int = MOST) -> None:
        self._guests = guests
        self._most = most
        self._transports: dict[_Connection, BaseTransport] = {}

    def connection(self, *args: Any, **options: Any) -> ServerConnection:
        """Return a connection; for the argument ``create_connection`` of websockets."""
        return _Connection(self, *args, **options)

    def add(self, connection: _Connection, transport: BaseTransport) -> None:
        """Take a new connection, or end it before anything is read."""
        peer, here = transport.get_extra_info("peername"), transport.get_extra_info("sockname")
        if self._guests is not None and not (peer and here and self._guests.may_come(peer[0], here[0])):
            transport.abort()  # type: ignore[attr-defined]
            return
        with contextlib.suppress(AttributeError, OSError):  # systems without it keep the connection for longer
            transport.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, TAKEN)
        self._transports[connection] = transport
        while len(self._transports) > self._most:
            self._transports.pop(next(iter(self._transports))).abort()  # type: ignore[attr-defined]

    def remove(self, connection: object) -> None:
        """Forget a connection that has come in, or gone."""
        self._transports.pop(connection, None)  # type: ignore[call-overload]


class _Connection(ServerConnection):
    def __init__(self, entrance: Entrance, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._entrance = entrance

    def connection_made(self, transport: BaseTransport) -> None:
        super().connection_made(transport)
        self._entrance.add(self, transport)

    def connection_lost(self, exc: Exception | None) -> None:
        self._entrance.remove(self)
        super().connection_lost(exc)
