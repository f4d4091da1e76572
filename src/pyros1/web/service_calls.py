"""Service calls on behalf of a page or client; they may take long, and are cancelled when its connection ends."""

from __future__ import annotations

import threading
from typing import Any

from pyros1.node import Node
from pyros1.web.server.wire import RequestError

MAX_CONCURRENT_CALLS = 16
"""Maximum number of concurrent service calls per connection."""


class ServiceCalls:
    """The running service calls of one page or client."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._active_clients: set[Any] = set()
        self._closed = False

    def call(self, node: Node, name: str, service_class: Any, request: Any, timeout: float) -> Any:
        """Call a service and return the response.

        Args:
            node: the calling node.
            name: the service's full name.
            service_class: the service type's class.
            request: the request.
            timeout: maximum number of seconds to wait for the response.

        Raises:
            RequestError: the connection has ended.
            ServiceError: the call failed.
        """
        with node.service(name, service_class) as client:
            with self._lock:
                if self._closed:
                    raise RequestError("the caller has disconnected")
                self._active_clients.add(client)
            try:
                return client.call(request, timeout)
            finally:
                with self._lock:
                    self._active_clients.discard(client)

    def close(self) -> None:
        """Cancel all running calls, and reject further ones."""
        with self._lock:
            self._closed = True
            clients = list(self._active_clients)
        for client in clients:
            client.close()
