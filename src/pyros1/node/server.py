"""The TCPROS server: one port per node for topics and services. The connection header says which topic or service a
peer wants (T04, T05, O15).

Runs on the loop. A peer that sends nothing, or sends its header too slowly, is disconnected after HEADER_TIMEOUT
seconds; it does not delay other peers.
"""

from __future__ import annotations

import contextlib
import selectors
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING

from pyros1.ground.errors import Error, NodeError, ProtocolError
from pyros1.net.acceptor import Acceptor
from pyros1.net.hosts import make_uri
from pyros1.net.ports import listening_socket
from pyros1.net.xmlrpc_server import XmlRpcServer
from pyros1.node.log.levels import WARN
from pyros1.node.same_host import is_same_user, listen, socket_name_for
from pyros1.wire.handshake import Refusal
from pyros1.wire.header import HeaderReader, encode_header

if TYPE_CHECKING:
    from pyros1.net.hosts import LocalAddress
    from pyros1.net.loop import TimerHandle
    from pyros1.net.xmlrpc_server import Dispatch
    from pyros1.node.context import Context
    from pyros1.node.services.server import ServiceServer

HEADER_TIMEOUT = 10.0
MAX_HANDSHAKES = 256
"""Maximum number of connections with an incomplete header; beyond that, the oldest of them is closed."""


class _Handshake:
    """A connection whose header has not been received completely."""

    def __init__(self, sock: socket.socket) -> None:
        self.sock = sock
        self.reader = HeaderReader()
        self.timer: TimerHandle | None = None


class TcprosServer:
    """Accepts connections, reads their headers, and passes the connections to publications and services.

    Args:
        context: the node's context.
        address: the address to listen on.
        get_services: returns the node's services, by name.
        port: the port to listen on; 0 for any.

    Attributes:
        port: the port that the server listens on.
        uri: the URI to register services with, ``rosrpc://host:port``.

    Raises:
        OSError: the port is in use.
    """

    def __init__(
        self,
        context: Context,
        address: LocalAddress,
        get_services: Callable[[], dict[str, ServiceServer]],
        port: int = 0,
    ) -> None:
        self._context = context
        self._get_services = get_services
        self._handshakes: dict[socket.socket, _Handshake] = {}
        listener = listening_socket(address.bind, port, address.ports)
        self.port: int = listener.getsockname()[1]
        self.uri = make_uri(address.advertised, self.port, "rosrpc").rstrip("/")
        warn, allowlist = context.log_system_error, context.allowlist
        self._acceptor = Acceptor(context.loop, listener, self._on_accepted, warn, allowlist=allowlist)
        self._local_acceptor: Acceptor | None = None
        self._local_socket_name = ""
        context.local_socket_name = self.local_socket_name

    def local_socket_name(self) -> str:
        """Return the name of the socket for programs that share memory, or "" if there is none. Called on the loop."""
        if self._local_acceptor is None and self._context.local_key:
            try:
                listener, self._local_socket_name = listen(socket_name_for(self.uri, self._context.local_key))
            except OSError as error:
                self._context.log_system_error(
                    f"cannot open a socket for programs on this machine: {error.strerror or error}"
                )
                return ""
            context = self._context
            self._local_acceptor = Acceptor(context.loop, listener, self._on_accepted_local, context.log_system_error)
        return self._local_socket_name

    def _on_accepted_local(self, sock: socket.socket) -> None:
        try:
            is_own_user = is_same_user(sock)
        except OSError:
            is_own_user = False
        if is_own_user:
            self._on_accepted(sock)
        else:
            sock.close()

    def _on_accepted(self, sock: socket.socket) -> None:
        if len(self._handshakes) >= MAX_HANDSHAKES:
            self._discard(next(iter(self._handshakes.values())))
        handshake = _Handshake(sock)
        self._handshakes[sock] = handshake
        handshake.timer = self._context.loop.call_later(HEADER_TIMEOUT, self._discard, handshake)
        self._context.loop.register(sock, selectors.EVENT_READ, lambda _: self._read(handshake))

    def _read(self, handshake: _Handshake) -> None:
        try:
            data = handshake.sock.recv(65536)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._discard(handshake)
            return
        try:
            header = handshake.reader.feed(data)
        except ProtocolError as error:
            is_http = data.startswith((b"POST ", b"GET "))
            self._refuse(
                handshake, "this is an HTTP request; the node's API is on another port" if is_http else str(error), None
            )
            return
        if header is not None:
            self._dispatch(handshake, header)

    def _dispatch(self, handshake: _Handshake, header: dict[str, str]) -> None:
        self._release(handshake)
        sock = handshake.sock
        try:
            if "topic" in header:
                topic = header["topic"]
                publication = self._context.publications.get(topic)
                if publication is None:
                    topics = ", ".join(self._context.publications) or "none"
                    raise Refusal(f"[{self._context.name}] is not a publisher of [{topic}]. Topics are [{topics}]")
                publication.accept(sock, header)
            elif "service" in header:
                service = self._get_services().get(header["service"])
                if service is None:
                    raise Refusal(f"[{self._context.name}] is not a provider of [{header['service']}]")
                service.accept(sock, header, handshake.reader.bytes_after_header)
            else:
                raise Refusal("no topic or service name detected")
        except (Refusal, Error) as refusal:
            self._refuse(handshake, str(refusal), header)
        except OSError:
            sock.close()

    def _refuse(self, handshake: _Handshake, reason: str, header: dict[str, str] | None) -> None:
        """Send the reason to the peer, log it, and close the connection."""
        self._release(handshake)
        if self._context.stopping.is_set():
            handshake.sock.close()  # not an error: the peer does not know yet that this node is shutting down
            return
        header = header or {}
        requested = header.get("topic") or header.get("service")
        if requested:
            caller = header.get("callerid", "?")
            self._context.log.peer_event(WARN, "refused a connection from %s for %s: %s", caller, requested, reason)
        else:  # the peer is not a ROS node, or a broken one
            text = "refused a connection from %s that names no topic or service: %s"
            self._context.log.peer_event(WARN, text, _peer_host(handshake.sock), reason)
        with contextlib.suppress(OSError):
            handshake.sock.send(encode_header({"error": reason}))
            handshake.sock.shutdown(socket.SHUT_WR)
        handshake.sock.close()

    def _release(self, handshake: _Handshake) -> None:
        """Remove a connection from the loop; its socket stays open."""
        if self._handshakes.pop(handshake.sock, None) is not None:
            self._context.loop.unregister(handshake.sock)
        if handshake.timer is not None:
            handshake.timer.cancel()

    def _discard(self, handshake: _Handshake) -> None:
        self._release(handshake)
        handshake.sock.close()

    def close(self) -> None:
        """Stop listening. Called on the loop."""
        self._acceptor.close()
        if self._local_acceptor is not None:
            self._local_acceptor.close()
        for handshake in list(self._handshakes.values()):
            self._discard(handshake)


def _peer_host(sock: socket.socket) -> str:
    """Return the address of the peer's machine, or a description for messages."""
    try:
        address = sock.getpeername()
        return str(address[0]) if isinstance(address, tuple) else "this machine"
    except OSError:
        return "a peer that has disconnected"


def open_ports(
    context: Context,
    address: LocalAddress,
    get_services: Callable[[], dict[str, ServiceServer]],
    dispatch: Dispatch,
    ports: tuple[int, int],
) -> tuple[TcprosServer, XmlRpcServer]:
    """Listen for other nodes and set the context's allowlist; return the server for topics and services, and the server
    of the slave API.

    Args:
        context: the node's context.
        address: the address to listen on, and the hosts that may connect.
        get_services: returns the node's services, by name.
        dispatch: executes calls to the slave API.
        ports: the port of the slave API, and the port of topics and services; 0 for any.

    Raises:
        NodeError: the node cannot listen on the address, or a port is in use.
    """
    if address.allowed is not None:
        from pyros1.net.allowlist import Allowlist  # noqa: PLC0415 - slow to import, and most nodes accept all hosts

        context.allowlist = Allowlist(address.allowed, lambda text: context.log.warn("%s", text))
    tcpros: TcprosServer | None = None
    try:
        tcpros = TcprosServer(context, address, get_services, ports[1])
        slave = XmlRpcServer(
            context.loop,
            dispatch,
            bind_host=address.bind,
            advertised_host=address.advertised,
            port=ports[0],
            ports=address.ports,
            allowlist=context.allowlist,
            warn=context.log_system_error,
        )
    except OSError as error:
        if tcpros is not None:
            context.loop.run(tcpros.close)
        raise NodeError(f"{context.name} cannot listen on {address.bind}: {error.strerror or error}") from error
    context.rpc.make_room = slave.make_room
    return tcpros, slave
