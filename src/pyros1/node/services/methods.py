"""The services provided by a node, and their registration with the master."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import NodeError
from pyros1.node import checks
from pyros1.node.services.client import ServiceClient, wait_for_service
from pyros1.node.services.server import MAX_CALLS, ServiceServer
from pyros1.node.services.workers import Workers

if TYPE_CHECKING:
    from pyros1.msgs import Service
    from pyros1.net.master_client import MasterClient
    from pyros1.node.context import Context
    from pyros1.node.registrar import Registrar

_ADVERTISE_SERVICE = "advertise_service(name, type, handler)"
MAX_THREADS = 16 * MAX_CALLS
"""Maximum number of concurrent calls to all services of a node."""


class Services:
    """The services provided by a node, by full name.

    Args:
        context: the node's context.
        get_registrar: returns the node's registrar.
        get_uri: returns the ``rosrpc://`` URI of the node.

    Attributes:
        servers: the services by name; replaced as a whole on changes, so that readers need no lock. A copy is in
            ``context.services``.
    """

    def __init__(self, context: Context, get_registrar: Callable[[], Registrar], get_uri: Callable[[], str]) -> None:
        self.servers: dict[str, ServiceServer] = {}
        self._context = context
        self._get_registrar = get_registrar
        self._get_uri = get_uri
        self._workers = Workers(f"{context.name}:service", MAX_THREADS)
        self._lock = threading.RLock()

    def advertise(
        self, name: str, service_class: type[Service], handler: Callable[[Any], Any], direct: bool = False
    ) -> ServiceServer:
        """Provide a service; see ``Node.advertise_service``.

        Args:
            name: the service's full name.
            service_class: the service class.
            handler: called with each request.
            direct: whether to call the handler immediately, even in a node with ``callbacks="spin"``.

        Raises:
            NodeError: this node already provides the service, or the process was forked.
            MasterError: the master refuses the service.
            NodeShutdownError: the node is shutting down.
        """
        self._context.check_process()
        with self._lock:
            self._context.check_running()
            if name in self.servers:
                raise NodeError(f"this node already provides service {name}")
            server = ServiceServer(
                self._context, self._workers, name, self._get_uri(), service_class, handler, self._unadvertise, direct
            )
            self._set_servers({**self.servers, name: server})
        if not direct:  # opens the socket that clients on this machine derive from the service's URI
            self._context.loop.call_soon(self._context.local_socket_name)
        try:
            self._get_registrar().register("registerService", name, server.uri, self._context.uri)
        except BaseException:
            self._drop(server)
            raise
        return server

    def _unadvertise(self, server: ServiceServer) -> None:
        if self._context.is_forked:
            return
        if not self._context.stopping.is_set():
            self._get_registrar().unregister("registerService", server.name, server.uri, self._context.uri)
        self._drop(server)

    def _drop(self, server: ServiceServer) -> None:
        with self._lock:
            self._set_servers({k: v for k, v in self.servers.items() if v is not server})
        server.close()

    def _set_servers(self, servers: dict[str, ServiceServer]) -> None:
        self.servers = servers
        self._context.services = {**servers}

    def close(self) -> None:
        """Abort all calls to the services and stop their threads."""
        for server in self.servers.values():
            server.close()
        self._workers.close()


class ServiceMethods:
    """The methods of `Node` that deal with services; a base class of `Node`."""

    resolve: Callable[[str], str]
    master: MasterClient
    _context: Context
    _services: Services

    def advertise_service(self, name: str, type: type[Service] | str, handler: Callable[[Any], Any]) -> ServiceServer:
        """Provide a service.

        Args:
            name: name of the service.
            type: service class, or a type's name such as "std_srvs/SetBool".
            handler: called with the request; returns a response, or the values of its fields as a tuple, list or dict,
                or the value of its only field. The message of an exception is sent to the client. Calls may overlap.

        Raises:
            NodeError: this node already provides the service.
            NodeShutdownError: the node is shutting down.
            TypeError: an argument has a wrong type.
        """
        checks.check_name(name, _ADVERTISE_SERVICE)
        checks.check_callback(handler, _ADVERTISE_SERVICE, "handler", type)
        return self._services.advertise(
            self.resolve(name), checks.require_service_class(type, "advertise_service"), handler
        )

    def service(
        self,
        name: str,
        type: type[Service] | str,
        *,
        persistent: bool = False,
        headers: Mapping[str, str] | None = None,
    ) -> ServiceClient:
        """Return a client that calls a service.

        Args:
            name: name of the service.
            type: service class, or a type's name.
            persistent: whether to keep the connection between calls, which is faster, but stays with one provider. If
                the connection breaks, the next call opens a new one.
            headers: extra fields for the connection header.

        Raises:
            TypeError: an argument has a wrong type.
        """
        checks.check_name(name, "service(name, type)")
        checks.check_headers(headers)
        cls = checks.require_service_class(type, "service")
        return ServiceClient(self._context, self.master, self.resolve(name), cls, persistent, headers or {})

    def wait_for_service(self, name: str, timeout: float | None = None) -> None:
        """Wait until a service is available, which means that its provider responds.

        Args:
            name: name of the service.
            timeout: maximum number of seconds to wait; None waits until the node shuts down.

        Raises:
            WaitTimeoutError: the service was not available in time.
            NodeShutdownError: the node is shutting down.
        """
        checks.check_name(name, "wait_for_service(name, timeout)")
        wait_for_service(self._context, self.master, self.resolve(name), timeout)
