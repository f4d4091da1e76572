"""Tracks which board provides which service, if several boards are connected."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, Protocol


class Server(Protocol):
    """A service of a board."""

    def close(self) -> None:
        """Remove the service from ROS."""


class Servers:
    """The services of all boards of a node. Thread-safe.

    A board that reconnects provides its services again, while the node may not have noticed yet that the old connection
    is broken. So the newest connection gets the service, as in stock ROS, where each connection is a separate node.
    """

    def __init__(self) -> None:
        self._servers: dict[str, Server] = {}
        self._lock = threading.Lock()

    def replace(self, name: str, create: Callable[[], Any]) -> Any:
        """Create a service, after removing one of the same name, and return it.

        Args:
            name: the resolved name of the service.
            create: creates the service.
        """
        with self._lock:
            old = self._servers.pop(name, None)
            if old is not None:
                old.close()
            server = self._servers[name] = create()
            return server

    def forget(self, server: object) -> None:
        """Stop tracking a service that its board has removed."""
        with self._lock:
            self._servers = {name: each for name, each in self._servers.items() if each is not server}
