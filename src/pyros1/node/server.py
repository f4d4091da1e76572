"""The TCPROS server: one port per node for topics and services; the first header decides (T04, T05, O15).

Runs on the loop. The connection of a peer that stays silent, or sends its header byte by byte, is closed at the
deadline and delays no other.
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
from pyros1.node.same_host import is_own, listen, name_beside
from pyros1.wire.handshake import Refusal
from pyros1.wire.header import HeaderReader, encode_header

if TYPE_CHECKING:
    from pyros1.net.hosts import LocalAddress
    from pyros1.net.loop import TimerHandle
    from pyros1.net.xmlrpc_server import Dispatch
    from pyros1.node.context import Context
    from pyros1.node.services.server import ServiceServer

HEADER_TIMEOUT = 10.0
MOST_GREETINGS = 256
"""Most connections whose header is not complete; the oldest is closed for a new one."""


class _Greeting:
    """A connection whose header is not complete."""

    def __init__(self, sock: socket.socket) -> None:
        self.sock = sock
        self.reader = HeaderReader()
        self.timer: TimerHandle | None = None


class TcprosServer:
    """Server that listens, reads headers and hands the connections to publications and services.

    Args:
        context: the node.
        address: where to listen.
        services: returns the node's services by name.
        port: 0 for any.

    Attributes:
        port: the port it listens on.
        uri: of its services.

    Raises:
        OSError: the port is taken.
    """

    def __init__(
        self,
        context: Context,
        address: LocalAddress,
        services: Callable[[], dict[str, ServiceServer]],
        port: int = 0,
    ) -> None:
        self._context = context
        self._services = services
        self._greetings: dict[socket.socket, _Greeting] = {}
        listener = listening_socket(address.bind, port, address.ports)
        self.port: int = listener.getsockname()[1]
        self.uri = make_uri(address.advertised, self.port, "rosrpc").rstrip("/")
        say, guests = context.tell_trouble, context.guests
        self._acceptor = Acceptor(context.loop, listener, self._accepted, say, guests=guests)
        self._local_acceptor: Acceptor | None = None
        self._local_name = ""
        context.local_name = self.local_name

    def local_name(self) -> str:
        """Return the name of the socket for programs that share memory; empty if there is none. On the loop."""
        if self._local_acceptor is None and self._context.local_key:
            try:
                listener, self._local_name = listen(name_beside(self.uri, self._context.local_key))
            except OSError as error:
                self._context.tell_trouble(f"no socket for programs of this machine: {error.strerror or error}")
                return ""
            context = self._context
            self._local_acceptor = Acceptor(context.loop, listener, self._accepted_local, context.tell_trouble)
        return self._local_name

    def _accepted_local(self, sock: socket.socket) -> None:
        try:
            own = is_own(sock)
        except OSError:
            own = False
        if own:
            self._accepted(sock)
        else:
            sock.close()

    def _accepted(self, sock: socket.socket) -> None:
        if len(self._greetings) >= MOST_GREETINGS:
            self._end(next(iter(self._greetings.values())))
        greeting = _Greeting(sock)
        self._greetings[sock] = greeting
        greeting.timer = self._context.loop.call_later(HEADER_TIMEOUT, self._end, greeting)
        self._context.loop.register(sock, selectors.EVENT_READ, lambda _: self._read(greeting))

    def _read(self, greeting: _Greeting) -> None:
        try:
            data = greeting.sock.recv(65536)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._end(greeting)
            return
        try:
            header = greeting.reader.feed(data)
        except ProtocolError as error:
            http = data.startswith((b"POST ", b"GET "))
            self._refuse(
                greeting, "this is an HTTP request; the node's API is on another port" if http else str(error), None
            )
            return
        if header is not None:
            self._hand_over(greeting, header)

    def _hand_over(self, greeting: _Greeting, header: dict[str, str]) -> None:
        self._release(greeting)
        sock = greeting.sock
        try:
            if "topic" in header:
                topic = header["topic"]
                publication = self._context.publications.get(topic)
                if publication is None:
                    known = ", ".join(self._context.publications) or "none"
                    raise Refusal(f"[{self._context.name}] is not a publisher of [{topic}]. Topics are [{known}]")
                publication.accept(sock, header)
            elif "service" in header:
                service = self._services().get(header["service"])
                if service is None:
                    raise Refusal(f"[{self._context.name}] is not a provider of [{header['service']}]")
                service.accept(sock, header, greeting.reader.rest)
            else:
                raise Refusal("no topic or service name detected")
        except (Refusal, Error) as refusal:
            self._refuse(greeting, str(refusal), header)
        except OSError:
            sock.close()

    def _refuse(self, greeting: _Greeting, reason: str, header: dict[str, str] | None) -> None:
        """Send the reason to the peer, log it, and close."""
        self._release(greeting)
        if self._context.stopping.is_set():
            greeting.sock.close()  # who heard of this node a moment ago comes too late: nothing is wrong
            return
        header = header or {}
        what = header.get("topic") or header.get("service")
        if what:
            who = header.get("callerid", "?")
            self._context.log.peer(WARN, "refused a connection from %s for %s: %s", who, what, reason)
        else:  # not a ROS node, or a broken one
            text = "refused a connection from %s that names no topic or service: %s"
            self._context.log.peer(WARN, text, _host(greeting.sock), reason)
        with contextlib.suppress(OSError):
            greeting.sock.send(encode_header({"error": reason}))
            greeting.sock.shutdown(socket.SHUT_WR)
        greeting.sock.close()

    def _release(self, greeting: _Greeting) -> None:
        """Let the loop forget a connection, whose socket stays open."""
        if self._greetings.pop(greeting.sock, None) is not None:
            self._context.loop.unregister(greeting.sock)
        if greeting.timer is not None:
            greeting.timer.cancel()

    def _end(self, greeting: _Greeting) -> None:
        self._release(greeting)
        greeting.sock.close()

    def close(self) -> None:
        """Stop to listen. On the loop."""
        self._acceptor.close()
        if self._local_acceptor is not None:
            self._local_acceptor.close()
        for greeting in list(self._greetings.values()):
            self._end(greeting)


def _host(sock: socket.socket) -> str:
    """The address of the machine at the other end of a connection."""
    try:
        peer = sock.getpeername()
        return str(peer[0]) if isinstance(peer, tuple) else "this machine"
    except OSError:
        return "a machine that is gone"


def open_ports(
    context: Context,
    address: LocalAddress,
    services: Callable[[], dict[str, ServiceServer]],
    dispatch: Dispatch,
    ports: tuple[int, int],
) -> tuple[TcprosServer, XmlRpcServer]:
    """Listen for other nodes: return the server for topics and services, and that of the slave API.

    Args:
        context: the node.
        address: where to listen, and for whom.
        services: returns the node's services by name.
        dispatch: answers calls of the slave API.
        ports: of the slave API, and of topics and services; 0 for any.

    Raises:
        NodeError: it cannot listen there.
    """
    if address.allowed is not None:
        from pyros1.net.guests import Guests  # noqa: PLC0415 - slow to import, and most nodes let everybody in

        context.guests = Guests(address.allowed, lambda text: context.log.warn("%s", text))
    tcpros: TcprosServer | None = None
    try:
        tcpros = TcprosServer(context, address, services, ports[1])
        slave = XmlRpcServer(
            context.loop,
            dispatch,
            bind_host=address.bind,
            advertised_host=address.advertised,
            port=ports[0],
            ports=address.ports,
            guests=context.guests,
            say=context.tell_trouble,
        )
    except OSError as error:
        if tcpros is not None:
            context.loop.run(tcpros.close)
        raise NodeError(f"{context.name} cannot listen on {address.bind}: {error.strerror or error}") from error
    context.rpc.make_room = slave.make_room
    return tcpros, slave
