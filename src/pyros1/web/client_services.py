"""Services that rosbridge clients provide: the server's node advertises them, and passes calls on to the clients."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any
from weakref import WeakValueDictionary

from pyros1.graph import Graph
from pyros1.ground.errors import MasterUnreachableError
from pyros1.msgs import Message, Service
from pyros1.node import Node
from pyros1.node.services.server import ServiceServer

Handler = Callable[[Any], Message]


class ClientServices:
    """The services that clients provide. If several clients provide the same service, the one that advertised it last
    gets the calls.

    A client that reconnects thus regains its service at once, although the server may notice only seconds later that
    the old connection is dead. Callers do not notice when another client takes over a service. While the master is slow
    to respond to a request about one service, clients can still advertise and unadvertise others.

    Args:
        node: returns the server's node.
    """

    def __init__(self, node: Callable[[], Node]) -> None:
        self._node = node
        self._lock = threading.Lock()  # guards `_locks`
        self._locks: WeakValueDictionary[str, threading.Lock] = WeakValueDictionary()  # service -> its lock
        self._services: dict[str, _Service] = {}

    def provide(self, name: str, cls: type[Service], handler: Handler) -> Callable[[], None]:
        """Provide a service on behalf of a client.

        Args:
            name: the service's full name.
            cls: the service type's class.
            handler: called with each request, in one of the node's threads; returns the response.

        Returns:
            A function that stops providing the service, unless another client has taken it over.

        Raises:
            NodeError: the server itself provides the service.
        """
        with self._lock_of(name):
            service = self._services.get(name)
            if service is not None and not (service.cls._md5sum == cls._md5sum and self._is_registered(name, service)):
                self._services.pop(name).server.shutdown()
                service = None
            if service is None:
                service = _Service(cls, handler)
                service.server = self._node().advertise_service(name, cls, service.handle)
                self._services[name] = service
            service.handler = handler
        return lambda: self._stop_providing(name, handler)

    def _lock_of(self, name: str) -> threading.Lock:
        """Return a service's lock, which exists as long as a thread holds it or waits for it."""
        with self._lock:
            return self._locks.setdefault(name, threading.Lock())

    def _is_registered(self, name: str, service: _Service) -> bool:
        """Return whether a service is still registered for the server's node; another node may have taken it over."""
        try:
            return Graph(self._node().master).service_uri(name) == service.server.uri
        except MasterUnreachableError:
            return True  # the node will register it again when the master is back

    def _stop_providing(self, name: str, handler: Handler) -> None:
        with self._lock_of(name):
            service = self._services.get(name)
            if service is not None and service.handler is handler:
                del self._services[name]
                service.server.shutdown()


class _Service:
    server: ServiceServer

    def __init__(self, cls: type[Service], handler: Handler) -> None:
        self.cls = cls
        self.handler = handler

    def handle(self, request: Any) -> Message:
        return self.handler(request)
