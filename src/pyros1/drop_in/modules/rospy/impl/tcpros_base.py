"""A connection to the provider of a service that a program makes itself."""

from __future__ import annotations

import socket
import struct
from time import monotonic
from typing import Any

from pyros1.drop_in.missing import names as _names
from pyros1.ground.errors import ProtocolError
from pyros1.msgs import Message
from pyros1.wire.framing import MAX_MESSAGE_SIZE
from pyros1.wire.header import HeaderReader, encode_header
from rospy.core import *  # noqa: F403  stock's module has these names, too
from rospy.exceptions import (
    ROSException,
    ROSInternalException,
    TransportException,
    TransportInitError,
    TransportTerminated,
)
from rospy.impl.transport import BIDIRECTIONAL, INBOUND, OUTBOUND, Transport
from rospy.names import LATE, get_caller_id

DEFAULT_BUFF_SIZE = 65536
TCPROS = "TCPROS"


class TCPROSTransportProtocol:
    """What is said over a connection.

    Args:
        resolved_name: topic or service.
        recv_data_class: class of the messages that come.
        queue_size, buff_size: as in rospy.
    """

    direction = BIDIRECTIONAL

    def __init__(
        self,
        resolved_name: str,
        recv_data_class: type[Message],
        queue_size: int | None = None,
        buff_size: int = DEFAULT_BUFF_SIZE,
    ) -> None:
        if recv_data_class and not issubclass(recv_data_class, Message):
            raise TransportInitError("recv_data_class is not a Message data class")
        self.resolved_name = resolved_name
        self.recv_data_class = recv_data_class
        self.queue_size = queue_size
        self.buff_size = buff_size

    def get_header_fields(self) -> dict[str, str]:
        """Return the fields of the connection header."""
        return {}

    def take(self, transport: TCPROSTransport) -> list[Any]:
        """Receive a message.

        Raises:
            TransportException: the connection has ended, or what came is not a message.
        """
        (size,) = struct.unpack("<I", transport.receive_bytes(4))
        return [self.recv_data_class._decode(transport.receive_bytes(size), 0, size)]


class TCPROSTransport(Transport):
    """A connection of which the program takes care itself: ``connect``, ``send_message``, ``receive_once``, ``close``.

    Args:
        protocol: what is said, for example a `rospy.impl.tcpros_service.TCPROSServiceClient`.
        name: topic or service.
        header: the other side's connection header, if it is known.

    Attributes:
        header: the other side's connection header. done: whether the connection has ended.
        stat_bytes, stat_num_msg: bytes and messages received.
    """

    transport_type = TCPROS

    def __init__(self, protocol: TCPROSTransportProtocol, name: str, header: dict[str, str] | None = None) -> None:
        if not name:
            raise TransportInitError("Unable to initialize transport: name is not set")
        super().__init__(protocol.direction, name)
        self.protocol = protocol
        self.header = header or {}
        self.endpoint_id = "unset"
        self.buff_size = DEFAULT_BUFF_SIZE
        self.socket: socket.socket | None = None
        self._rest = b""

    def connect(self, dest_addr: str, dest_port: int, endpoint_id: str, timeout: float | None = None) -> None:
        """Connect, and exchange headers.

        Args:
            dest_addr, dest_port: where to.
            endpoint_id: the other side's URI.
            timeout: seconds for this and each later wait; None: no limit.

        Raises:
            TransportInitError: that failed.
        """
        self.endpoint_id = endpoint_id
        try:
            self.socket = socket.create_connection((dest_addr, dest_port), timeout)
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.write_header()
            self.read_header()
        except (OSError, ProtocolError, TransportException) as error:
            self.close()
            raise TransportInitError(f"Unable to initiate TCP/IP socket to {dest_addr}:{dest_port}: {error}") from error

    def write_header(self) -> None:
        """Send our connection header."""
        fields = {"callerid": get_caller_id(), **self.protocol.get_header_fields()}
        self._sock().sendall(encode_header(fields))

    def read_header(self) -> None:
        """Receive the other side's connection header.

        Raises:
            TransportInitError: it refuses.
        """
        reader = HeaderReader()
        until = monotonic() + (self._sock().gettimeout() or 60.0)
        header = None
        while header is None:
            data = self._sock().recv(4096)
            if not data or monotonic() > until:
                raise TransportInitError("unable to receive data from sender, check sender's logs for details")
            header = reader.feed(data)
        self.header, self._rest = header, reader.rest
        if "error" in header:
            raise TransportInitError(f"remote error reported: {header['error']}")

    def send_message(self, msg: Any, seq: int) -> None:
        """Send a message.

        Args:
            msg: the message.
            seq: put into its header, if it has one.
        """
        if getattr(msg, "_has_header", False):
            msg.header.seq = seq
        frame = msg.__class__._encode_frame(msg)
        self.write_data(frame if isinstance(frame, bytes) else b"".join(frame))

    def write_data(self, data: bytes) -> int:
        """Send bytes; return their number.

        Raises:
            TransportTerminated: the connection has ended.
        """
        try:
            self._sock().sendall(data)
        except OSError as error:
            self.close()
            raise TransportTerminated(str(error)) from error
        return len(data)

    def receive_once(self) -> list[Any]:
        """Receive what comes next: a list of at least one message.

        Raises:
            TransportException: the connection has ended.
            ServiceException: a service has failed.
        """
        messages = self.protocol.take(self)
        for message in messages:
            message._connection_header = self.header
        self.stat_num_msg += len(messages)
        return messages

    def receive_bytes(self, count: int) -> bytes:
        """Receive exactly so many bytes.

        Raises:
            TransportTerminated: the connection has ended, or nothing came in time.
        """
        if count > MAX_MESSAGE_SIZE:
            raise TransportException(f"{count} bytes are too many for a message")
        parts, have = [self._rest], len(self._rest)
        while have < count:
            try:
                data = self._sock().recv(65536)
            except OSError as error:
                self.close()
                raise TransportTerminated(f"unable to receive data from sender: {error}") from error
            if not data:
                self.close()
                raise TransportTerminated("unable to receive data from sender, check sender's logs for details")
            self.stat_bytes += len(data)
            parts.append(data)
            have += len(data)
        whole = b"".join(parts)
        self._rest = whole[count:]
        return whole[:count]

    def _sock(self) -> socket.socket:
        if self.socket is None:
            raise ROSException("the connection is not open")
        return self.socket

    def set_endpoint_id(self, endpoint_id: str) -> None:
        """Set the other side's URI or name."""
        self.endpoint_id = endpoint_id

    def fileno(self) -> int | None:
        """Return the socket's number; None without one."""
        return self.socket.fileno() if self.socket is not None else None

    def get_transport_info(self) -> str:
        """Return the addresses of both ends, as text."""
        try:
            here, there = self._sock().getsockname(), self._sock().getpeername()
        except (OSError, ROSException):
            return "not connected"
        return f"TCPROS connection on port {here[1]} to [{there[0]}:{there[1]} on socket {self.fileno()}]"

    def close(self) -> None:
        """Close the connection."""
        if self.socket is not None:
            self.socket.close()
            self.socket = None
        super().close()


_own = "pyros1's node does this itself"
_unlike = ("TCPROSServer", "TCPServer", "init_tcpros_server", "start_tcpros_server", "get_tcpros_server_address")
__getattr__, __dir__ = _names(
    __name__,
    {**LATE, "ServiceException": "rospy.service", "Log": "rosgraph_msgs.msg"},
    dict.fromkeys((*_unlike, "recv_buff"), _own),
)
