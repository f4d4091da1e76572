"""Servers of TCPROS connections that a program makes itself; the node has its own
(https://wiki.ros.org/ROS/TCPROS).
"""

from __future__ import annotations

import contextlib
import io
import socket
import threading
from collections.abc import Callable
from typing import Any

from rosgraph.network import (
    get_bind_address,
    get_host_name,
    read_ros_handshake_header,
    use_ipv6,
    write_ros_handshake_header,
)

from pyros1.drop_in.process import PROCESS
from rospy.core import add_shutdown_hook, logwarn, xmlrpcapi
from rospy.exceptions import ROSException, ROSInternalException
from rospy.names import get_caller_id
from rospy.service import SERVICES

Handler = Callable[[socket.socket, Any], object]
HeaderHandler = Callable[[socket.socket, Any, dict[str, str]], "str | dict[str, str] | None"]
_HEADER_SECONDS = 60.0


class TCPServer:
    """Accepts connections.

    Args:
        inbound_handler: called with the socket and the address of each.
        port: 0: the system chooses.

    Attributes:
        addr, port: where it listens. server_sock: its socket. is_shutdown: whether it has ended.

    Raises:
        OSError: it cannot listen there.
    """

    def __init__(self, inbound_handler: Handler, port: int = 0) -> None:
        self.inbound_handler = inbound_handler
        self.is_shutdown = False
        family = socket.AF_INET6 if use_ipv6() else socket.AF_INET
        self.server_sock = socket.socket(family, socket.SOCK_STREAM)
        try:
            self.server_sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self.server_sock.bind((get_bind_address(), port))
            self.server_sock.listen(5)
        except OSError:
            self.server_sock.close()
            raise
        self.addr, self.port = self.server_sock.getsockname()[:2]

    def start(self) -> None:
        """Accept connections in a thread of its own."""
        threading.Thread(target=self.run, name="TCPServer", daemon=True).start()

    def run(self) -> None:
        """Accept connections until `shutdown`.

        Raises:
            ROSInternalException: it does not listen.
        """
        if self.server_sock.fileno() < 0 and not self.is_shutdown:
            raise ROSInternalException("TCPServer did not connect")
        while not self.is_shutdown:
            try:
                sock, address = self.server_sock.accept()
            except (TimeoutError, ConnectionAbortedError):
                continue
            except OSError:
                if self.is_shutdown:
                    return
                raise
            if self.is_shutdown:
                sock.close()
                return
            try:
                self.inbound_handler(sock, address)
            except OSError as error:
                logwarn("Failed to handle inbound connection due to socket error: %s", error)

    def get_full_addr(self) -> tuple[str, int]:
        """Return host and port, as others reach it."""
        return get_host_name(), self.port

    def shutdown(self) -> None:
        """End the server."""
        if self.is_shutdown:
            return
        self.is_shutdown = True
        with contextlib.suppress(OSError):
            self.server_sock.shutdown(socket.SHUT_RDWR)  # wakes the accepting thread
        self.server_sock.close()


def _refuse(sock: socket.socket, client_addr: Any, header: dict[str, str]) -> dict[str, str]:
    """Refuse a connection."""
    return {"error": "unhandled connection"}


class TCPROSServer:
    """Accepts connections, reads their headers, and hands them on.

    Args:
        port: 0: the system chooses.

    Attributes:
        topic_connection_handler, service_connection_handler: called with the socket, the address and the header;
            they return a reason to refuse the connection, or None.
    """

    def __init__(self, port: int = 0) -> None:
        self.port = port
        self.tcp_ros_server: TCPServer | None = None
        self.lock = threading.Lock()
        self.topic_connection_handler: HeaderHandler = _refuse
        self.service_connection_handler: HeaderHandler = _refuse

    def start_server(self) -> tuple[int, str, list[Any]] | None:
        """Begin to accept connections; return (0, reason, []) if that fails."""
        with self.lock:
            if self.tcp_ros_server is None:
                try:
                    self.tcp_ros_server = TCPServer(self._accept, self.port)
                except OSError as error:
                    return 0, f"unable to establish TCPROS server: {error}", []
                self.tcp_ros_server.start()
        return None

    def get_address(self) -> tuple[str | None, int | None]:
        """Return host and port; (None, None) before the start."""
        return (None, None) if self.tcp_ros_server is None else self.tcp_ros_server.get_full_addr()

    def shutdown(self, reason: str = "") -> None:
        """End the server."""
        if self.tcp_ros_server is not None:
            self.tcp_ros_server.shutdown()

    def _accept(self, sock: socket.socket, address: Any) -> None:
        """Pass on a connection; close it if it is silent or refused."""
        try:
            sock.settimeout(_HEADER_SECONDS)
            header = read_ros_handshake_header(sock, io.BytesIO(), 4096)
            sock.settimeout(None)
            why: Any = "no topic or service name detected"
            if "topic" in header:
                why = self.topic_connection_handler(sock, address, header)
            elif "service" in header:
                why = self.service_connection_handler(sock, address, header)
            if not why:
                return
            text = why.get("error", "") if isinstance(why, dict) else str(why)
            write_ros_handshake_header(sock, {"error": "node shutting down" if PROCESS.ending else text})
            logwarn("Could not process inbound connection: %s%s", text, header)
        except Exception as error:  # noqa: BLE001 - the program's handler
            logwarn("Inbound TCP/IP connection failed: %s", error)
        sock.close()


def service_connection_handler(sock: socket.socket, client_addr: Any, header: dict[str, str]) -> str | None:
    """Say why a connection to a service is refused.

    Raises:
        NotImplementedError: it is not: then pyros1's node takes such connections itself.
    """
    for field in ("service", "md5sum", "callerid"):
        if field not in header:
            return f"Missing required '{field}' field"
    name = header["service"]
    service = SERVICES.get_service(name)
    if service is None:
        return f"[{get_caller_id()}] is not a provider of  [{name}]"
    wanted = service.service_class._md5sum
    if header["md5sum"] not in ("*", wanted):
        return f"request from [{header['callerid']}]: md5sums do not match: [{header['md5sum']}] vs. [{wanted}]"
    raise NotImplementedError("pyros1's node serves the connections of services itself")


_own: list[TCPROSServer] = []


def init_tcpros_server(port: int = 0) -> TCPROSServer:
    """Return the program's own server, made with the first call; it ends with the node."""
    if not _own:
        _own.append(TCPROSServer(port))
        add_shutdown_hook(_own[0].shutdown)
    return _own[0]


def start_tcpros_server() -> Any:
    """Start the program's own server; see `TCPROSServer.start_server`."""
    return init_tcpros_server().start_server()


def get_tcpros_server_address() -> tuple[str | None, int | None]:
    """Return host and port of the program's own server, or those where the node takes connections.

    Raises:
        ROSException: there is neither.
    """
    if _own:
        return _own[0].get_address()
    node = xmlrpcapi(PROCESS.node.uri) if PROCESS.node is not None else None
    if node is None:
        raise ROSException("the TCPROS server has not been started")
    _, _, (_, host, port) = node.requestTopic("/tcpros_server", "/rosout", [["TCPROS"]])
    return host, port
