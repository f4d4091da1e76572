"""The services that a node provides, and their registration with the master."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import NodeError
from pyros1.node.services.server import MOST_CALLS, ServiceServer
from pyros1.node.services.workers import Workers

if TYPE_CHECKING:
    from pyros1.msgs import Service
    from pyros1.node.context import Context
    from pyros1.node.registrar import Registrar

MOST_THREADS = 16 * MOST_CALLS
"""Most calls of all services of a node at the same time."""


class Services:
    """The services that a node provides, by full name.

    Args:
        context: the node.
        registrar: the node's registrations with the master.
        address: returns the ``rosrpc://`` URI of the node.

    Attributes:
        servers: by name; replaced as a whole on changes, so that readers need no lock. Also ``context.services``.
    """

    def __init__(self, context: Context, registrar: Callable[[], Registrar], address: Callable[[], str]) -> None:
        self.servers: dict[str, ServiceServer] = {}
        self._context = context
        self._registrar = registrar
        self._address = address
        self._workers = Workers(f"{context.name}:service", MOST_THREADS)
        self._lock = threading.RLock()

    def advertise(
        self, name: str, service_class: type[Service], handler: Callable[[Any], Any], direct: bool = False
    ) -> ServiceServer:
        """Provide a service; see ``Node.advertise_service``.

        Args:
            direct: whether to answer at once, even in a node that spins.
        """
        self._context.check_here()
        with self._lock:
            self._context.check_running()
            if name in self.servers:
                raise NodeError(f"this node already provides service {name}")
            server = ServiceServer(
                self._context, self._workers, name, self._address(), service_class, handler, self._unadvertise, direct
            )
            self._set({**self.servers, name: server})
        try:
            self._registrar().register("registerService", name, server.uri, self._context.uri)
        except BaseException:
            self._drop(server)
            raise
        return server

    def _unadvertise(self, server: ServiceServer) -> None:
        if self._context.forked:
            return
        if not self._context.stopping.is_set():
            self._registrar().unregister("registerService", server.name, server.uri, self._context.uri)
        self._drop(server)

    def _drop(self, server: ServiceServer) -> None:
        with self._lock:
            self._set({k: v for k, v in self.servers.items() if v is not server})
        server.close()

    def _set(self, servers: dict[str, ServiceServer]) -> None:
        self.servers = servers
        self._context.services = {**servers}

    def close(self) -> None:
        """End all calls and their threads."""
        for server in self.servers.values():
            server.close()
        self._workers.close()
