"""XML-RPC servers for node-like programs: a server in a thread, and the handler of its methods."""

from __future__ import annotations

import logging
import socket
import threading
from collections.abc import Callable
from errno import EADDRINUSE
from socketserver import ForkingMixIn, ThreadingMixIn
from typing import Any
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

from pyros1.drop_in.module_attributes import module_getattr
from rosgraph.names import isstring
from rosgraph.network import create_local_xmlrpc_uri, get_bind_address, use_ipv6

_log = logging.getLogger("xmlrpc")

__getattr__ = module_getattr(__name__)


class SilenceableXMLRPCRequestHandler(SimpleXMLRPCRequestHandler):
    """A request handler that keeps connections open and logs nothing."""

    protocol_version = "HTTP/1.1"

    def log_message(self, format: str, *args: Any) -> None:
        """Log nothing."""


class ThreadingXMLRPCServer(ThreadingMixIn, SimpleXMLRPCServer):
    """A server with a thread for each connection.

    Args:
        addr: host and port.
        log_requests: as in Python's servers; has no effect, since the handler logs nothing.
    """

    daemon_threads = True

    def __init__(self, addr: tuple[str, int], log_requests: bool = True) -> None:
        if use_ipv6():
            self.address_family = socket.AF_INET6
        super().__init__(addr, SilenceableXMLRPCRequestHandler, log_requests)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Log an error in handling a connection, unless the connection was closed."""
        import sys

        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            _log.error("error in a call from %s: %s", client_address, error)


class ForkingXMLRPCServer(ForkingMixIn, SimpleXMLRPCServer):
    """A server with a process for each connection; see `ThreadingXMLRPCServer`."""

    def __init__(
        self,
        addr: tuple[str, int],
        request_handler: type[SimpleXMLRPCRequestHandler] = SilenceableXMLRPCRequestHandler,
        log_requests: bool = True,
    ) -> None:
        super().__init__(addr, request_handler, log_requests)


class XmlRpcHandler:
    """Base class of handlers, whose public methods can be called remotely."""

    def _ready(self, uri: str) -> None:
        """Handle the start of the server, whose address is ``uri``."""

    def _shutdown(self, reason: str) -> None:
        """Handle the shutdown of the server."""


class XmlRpcNode:
    """An XML-RPC server in a thread.

    Args:
        port: port to listen on; 0 for any.
        rpc_handler: its public methods can be called remotely.
        on_run_error: called with the exception that ended the server; None to log the exception.

    Attributes:
        uri: address of the server, once it is known.
    """

    def __init__(
        self, port: int = 0, rpc_handler: Any = None, on_run_error: Callable[[Exception], object] | None = None
    ) -> None:
        if port and isstring(port):
            port = int(port)
        self.handler = rpc_handler
        self.port = port
        self.uri: str | None = None
        self.server: ThreadingXMLRPCServer | None = None
        self.is_shutdown = False
        self.on_run_error = on_run_error

    def start(self) -> None:
        """Start the server in a thread of its own."""
        threading.Thread(target=self.run, daemon=True).start()

    def set_uri(self, uri: str) -> None:
        """Set the address."""
        self.uri = uri

    def run(self) -> None:
        """Serve requests until the server is stopped."""
        try:
            self._run()
        except Exception as error:  # noqa: BLE001  the program decides what to do
            if self.is_shutdown:
                return
            if self.on_run_error is None:
                _log.error("XML-RPC server: %s", error)
            else:
                self.on_run_error(error)

    def _run_init(self) -> None:
        bind = get_bind_address()
        try:
            self.server = ThreadingXMLRPCServer((bind, self.port or 0), log_requests=False)
        except OSError as error:
            if error.errno == EADDRINUSE:
                print(f"ERROR: Unable to start XML-RPC server, port {self.port} is already in use")
            raise
        self.port = self.server.server_address[1]
        if not self.port:
            self.uri = None
        self.set_uri(create_local_xmlrpc_uri(self.port))
        self.server.register_multicall_functions()
        self.server.register_instance(self.handler)

    def _run(self) -> None:
        self._run_init()
        if self.handler is not None:
            self.handler._ready(self.uri)
        if self.server is not None and not self.is_shutdown:
            self.server.serve_forever()

    def shutdown(self, reason: str) -> None:
        """Stop the server."""
        self.is_shutdown = True
        server, self.server = self.server, None
        if server is not None:
            server.shutdown()
            server.server_close()
        handler, self.handler = self.handler, None
        if handler is not None:
            handler._shutdown(reason)
