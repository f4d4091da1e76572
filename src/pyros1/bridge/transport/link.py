"""The interface for sending packets between sites; tests implement it without a network."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.protocol.key_expressions import Key
from pyros1.bridge.transport.connections import Connection

Receive = Callable[[Key, bytes, bytes], object]
"""Called with key, head and body of each packet, in any thread. It returns at once and raises nothing."""


class Link(Protocol):
    """A link to the other sites. Its methods block on the network only where, and as long as, their descriptions say.

    Attributes:
        problem: why there is no connection; empty if nothing is known to be wrong.
    """

    problem: str

    def connections(self) -> list[Connection]:
        """Return the current connections, if they are known."""
        ...

    def send(self, packet: Send) -> None:
        """Send a packet below this site's prefix. It may be lost. This waits only while a packet of the same priority
        cannot be sent, and only for a limited time.
        """
        ...

    def try_send(self, packet: Send) -> bool:
        """Send a small packet if that takes hardly any waiting, a millisecond at most; return whether it was sent. The
        caller makes sure that no other thread sends packets of the same priority meanwhile.
        """
        ...

    def listen(self, site: str, key: str, on: bool) -> None:
        """Receive what another site sends on a key, or stop. ``hello``, ``to``, ``again`` and ``call`` packets for
        this site are always received.
        """
        ...

    def close(self) -> None:
        """Close the link."""
        ...
