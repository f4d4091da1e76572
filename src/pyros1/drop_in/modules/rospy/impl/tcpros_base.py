"""Connections that a program opens to services itself, separate from the node's (https://wiki.ros.org/ROS/TCPROS)."""

from __future__ import annotations

import io
import socket
import struct
from collections.abc import Callable
from time import monotonic
from typing import Any

from genpy.message import DeserializationError as _DeserializationError

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground.errors import ProtocolError
from pyros1.msgs import Message
from pyros1.wire.framing import MAX_MESSAGE_SIZE
from pyros1.wire.header import HeaderReader, encode_header
from rospy.exceptions import TransportException, TransportInitError, TransportTerminated
from rospy.impl.transport import BIDIRECTIONAL, Transport
from rospy.msg import serialize_message
from rospy.names import get_caller_id
from rospy.service import ServiceException

DEFAULT_BUFF_SIZE = 65536
TCPROS = "TCPROS"
_REASON = "pyros1's nodes accept connections themselves; see Publisher.impl and Subscriber.impl"
_HEADER_TIMEOUT = 60.0
_LENGTH = struct.Struct("<I")
Read = Callable[[int], bytes]
"""A function that receives the given number of bytes."""


class TCPROSTransportProtocol:
    """The protocol of a connection: the header that is sent, and how messages are received.

    Args:
        resolved_name: name of the topic or service.
        recv_data_class: class of the messages to receive; None if there are none.
        queue_size, buff_size: accepted for compatibility.
    """

    direction = BIDIRECTIONAL

    def __init__(
        self,
        resolved_name: str,
        recv_data_class: Any,
        queue_size: int | None = None,
        buff_size: int = DEFAULT_BUFF_SIZE,
    ) -> None:
        if recv_data_class and not issubclass(recv_data_class, Message):
            raise TransportInitError("Unable to initialize transport: data class is not a message data class")
        self.resolved_name = resolved_name
        self.recv_data_class = recv_data_class
        self.queue_size = queue_size
        self.buff_size = buff_size

    def get_header_fields(self) -> dict[str, str]:
        """Return the fields of the connection header."""
        return {}

    def receive(self, read: Read) -> Any:
        """Receive and return a message.

        Raises:
            TransportException: the message is too large.
            DeserializationError: the message cannot be decoded.
        """
        return self.recv_data_class().deserialize(_receive_with_length(read))


class TCPROSServiceClient(TCPROSTransportProtocol):
    """A service client's protocol.

    Args:
        resolved_name: the service's name.
        service_class: class of the service.
        headers: additional fields of the connection header.
        buff_size: accepted for compatibility.
    """

    def __init__(
        self,
        resolved_name: str,
        service_class: Any,
        headers: dict[str, str] | None = None,
        buff_size: int = DEFAULT_BUFF_SIZE,
    ) -> None:
        super().__init__(resolved_name, service_class._response_class, buff_size=buff_size)
        self.service_class = service_class
        self.headers = headers or {}

    def get_header_fields(self) -> dict[str, str]:
        """Return the fields of the connection header."""
        fields = {"service": self.resolved_name, "md5sum": self.service_class._md5sum, "callerid": get_caller_id()}
        return {**fields, **self.headers}

    def receive(self, read: Read) -> Any:
        """Receive and return a response.

        Raises:
            ServiceException: the service has failed.
        """
        if read(1) != b"\0":
            return super().receive(read)
        raise ServiceException(
            f"service [{self.resolved_name}] responded with an error: {_receive_with_length(read)!r}"
        )


def _receive_with_length(read: Read) -> bytes:
    """Receive a 4-byte length, then that many bytes; return the bytes."""
    (size,) = _LENGTH.unpack(read(_LENGTH.size))
    if size > MAX_MESSAGE_SIZE:
        raise TransportException(f"a message of {size} bytes is too large")
    return read(size)


class TCPROSTransport(Transport):
    """A connection that the program manages itself: ``connect``, ``send_message``, ``receive_once``, ``close``.

    Args:
        protocol: the protocol, for example a `rospy.impl.tcpros_service.TCPROSServiceClient`.
        name: name of the topic or service.
        header: the other side's connection header, if it is known.

    Attributes:
        header: the other side's connection header.
        type, md5sum, callerid_pub: fields of that header.
        done: whether the connection has ended.
    """

    transport_type = TCPROS

    def __init__(self, protocol: TCPROSTransportProtocol, name: str, header: dict[str, str] | None = None) -> None:
        if not name:
            raise TransportInitError("Unable to initialize transport: name is not set")
        super().__init__(protocol.direction, name)
        self.protocol = protocol
        self.header = header
        self.endpoint_id = self.callerid_pub = "unknown"
        self.buff_size = DEFAULT_BUFF_SIZE
        self.socket: socket.socket | None = None
        self._received = b""

    def connect(self, dest_addr: str, dest_port: int, endpoint_id: str, timeout: float | None = None) -> None:
        """Connect, and exchange headers.

        Args:
            dest_addr, dest_port: host and port to connect to.
            endpoint_id: the other side's URI.
            timeout: seconds for this wait and each later one; None for no limit.

        Raises:
            TransportInitError: the connection could not be established.
        """
        self.endpoint_id = endpoint_id
        try:
            self.socket = socket.create_connection((dest_addr, dest_port), timeout)
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.socket.sendall(encode_header(self.protocol.get_header_fields()))
            self._read_header(self.socket)
        except (OSError, ProtocolError, TransportException) as error:
            self.close()
            raise TransportInitError(f"Unable to initiate TCP/IP socket to {dest_addr}:{dest_port}: {error}") from error

    def _read_header(self, sock: socket.socket) -> None:
        reader = HeaderReader()
        deadline = monotonic() + (sock.gettimeout() or _HEADER_TIMEOUT)
        header = None
        while header is None:
            data = sock.recv(4096)
            if not data or monotonic() > deadline:
                raise TransportTerminated("connection from sender terminated before handshake header received")
            header = reader.feed(data)
        self.header, self._received = header, bytes(reader.bytes_after_header)
        if "error" in header:
            raise TransportInitError(f"remote error reported: {header['error']}")
        for field in ("md5sum", "type"):
            if field not in header:
                raise TransportInitError(f"header missing required field [{field}]")
        self.type, self.md5sum = header["type"], header["md5sum"]
        self.callerid_pub = header.get("callerid", self.callerid_pub)

    def send_message(self, msg: Any, seq: int) -> None:
        """Send a message.

        Args:
            msg: the message.
            seq: sequence number for the message's header, if it has one.

        Raises:
            TransportInitError: there is no connection.
            TransportTerminated: the connection has ended.
        """
        if self.socket is None:
            raise TransportInitError("TCPROS transport was not successfully initialized")
        buffer = io.BytesIO()
        serialize_message(buffer, seq, msg)
        try:
            self.socket.sendall(buffer.getvalue())
        except OSError as error:
            self.close()
            raise TransportTerminated(f"{error.errno}{error.strerror}") from error

    def receive_once(self) -> list[Any]:
        """Receive the next message, and return it in a list.

        Raises:
            TransportTerminated: the connection has ended.
            TransportException: the received bytes are not a message.
            ServiceException: a service has failed.
        """
        if self.socket is None:
            raise TransportException("connection not initialized")
        try:
            message = self.protocol.receive(self._read)
        except (_DeserializationError, ProtocolError) as error:
            raise TransportException(f"receive_once[{self.name}]: DeserializationError {error}") from error
        message._connection_header = self.header
        return [message]

    def _read(self, size: int) -> bytes:
        parts = [self._received[:size]]
        self._received = self._received[size:]
        missing_size = size - len(parts[0])
        while missing_size:
            try:
                data = self.socket.recv(min(missing_size, DEFAULT_BUFF_SIZE)) if self.socket is not None else b""
            except OSError as error:
                raise TransportTerminated(str(error)) from error
            if not data:
                raise TransportTerminated("unable to receive data from sender, check sender's logs for details")
            parts.append(data)
            missing_size -= len(data)
        return b"".join(parts)

    def close(self) -> None:
        """Close the connection."""
        if self.socket is not None:
            self.socket.close()
            self.socket = None
        super().close()


def start_tcpros_server() -> None:
    """Do nothing: `rospy.init_node` starts the server."""


__getattr__ = module_getattr(
    "rospy.impl.tcpros_base",
    TCPROSServer=_REASON,
    TCPServer=_REASON,
    get_tcpros_server_address=_REASON,
    init_tcpros_server=_REASON,
    recv_buff=_REASON,
)
