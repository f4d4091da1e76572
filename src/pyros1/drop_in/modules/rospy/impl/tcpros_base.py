"""A connection to the provider of a service that a program makes itself."""

from __future__ import annotations

import io
import logging
import socket
from collections.abc import Callable
from errno import EAGAIN, EWOULDBLOCK
from time import monotonic
from typing import Any

from genpy.message import DeserializationError as _DeserializationError

from pyros1.drop_in.missing import names as _names
from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import ProtocolError
from pyros1.msgs import Message
from pyros1.wire.framing import MAX_MESSAGE_SIZE
from pyros1.wire.header import HeaderReader, encode_header
from rospy.core import *  # noqa: F403  stock's module has these names as well
from rospy.exceptions import (
    ROSException,
    ROSInternalException,
    TransportException,
    TransportInitError,
    TransportTerminated,
)
from rospy.impl.transport import BIDIRECTIONAL, INBOUND, OUTBOUND, Transport
from rospy.msg import deserialize_messages, serialize_message
from rospy.names import LATE, get_caller_id

DEFAULT_BUFF_SIZE = 65536
TCPROS = "TCPROS"
python3 = 1
logger = logging.getLogger("rospy.tcpros")
_ENDED = "unable to receive data from sender, check sender's logs for details"


def checked_size(size: int) -> int:
    """Return the size of a message that comes; raises TransportException if it is too large."""
    if size > MAX_MESSAGE_SIZE:
        raise TransportException(f"{size} bytes are too many for a message")
    return size


def recv_buff(sock: Any, b: Any, buff_size: int) -> int:
    """Read from a socket into a buffer.

    Args:
        sock: the socket.
        b: a writable binary file.
        buff_size: at most so many bytes.

    Returns:
        The number of bytes; 0 if there is nothing yet at a socket that does not wait.

    Raises:
        TransportTerminated: the connection has ended.
    """
    try:
        data = sock.recv(buff_size)
    except BlockingIOError:
        return 0
    except OSError as error:
        raise TransportTerminated(_ENDED) from error
    if not data:
        raise TransportTerminated(_ENDED)
    b.write(data)
    return len(data)


class TCPROSTransportProtocol:
    """What is said over a connection.

    Args:
        resolved_name: topic or service.
        recv_data_class: class of the messages that come; None if none come.
        queue_size, buff_size: as in rospy.
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

    def read_messages(self, b: Any, msg_queue: list[Any], sock: Any) -> None:
        """Take the whole messages out of a buffer, and keep the rest in it.

        Args:
            b: what has come, up to its position.
            msg_queue: gets the messages.
            sock: where more could be read.

        Raises:
            DeserializationError: a message cannot be read.
        """
        deserialize_messages(b, msg_queue, self.recv_data_class, queue_size=self.queue_size)


class TCPROSTransport(Transport):
    """A connection of which the program takes care itself: ``connect``, ``send_message``, ``receive_once``, ``close``.

    Args:
        protocol: what is said, for example a `rospy.impl.tcpros_service.TCPROSServiceClient`.
        name: topic or service.
        header: the other side's connection header, if it is known.

    Attributes:
        header: the other side's connection header; of it: type, md5sum, callerid_pub, is_latched.
        done: whether the connection has ended.
        local_endpoint: our end of the socket, as Python's ``getsockname`` has it. remote_endpoint: the other end, if
            `connect` has made the connection.
        stat_bytes, stat_num_msg: bytes and messages sent and received.
    """

    transport_type = TCPROS

    def __init__(self, protocol: TCPROSTransportProtocol, name: str, header: dict[str, str] | None = None) -> None:
        if not name:
            raise TransportInitError("Unable to initialize transport: name is not set")
        super().__init__(protocol.direction, name)
        self.protocol = protocol
        self.header = header
        self.endpoint_id = self.callerid_pub = "unknown"
        self.is_latched = False
        self.local_endpoint: Any = (None, None)
        self.remote_endpoint: Any = (None, None)
        self.buff_size = DEFAULT_BUFF_SIZE
        self.socket: socket.socket | None = None
        self.read_buff = io.BytesIO()
        self.write_buff = io.BytesIO()

    def connect(self, dest_addr: str, dest_port: int, endpoint_id: str, timeout: float | None = None) -> None:
        """Connect, and exchange headers.

        Args:
            dest_addr, dest_port: where to.
            endpoint_id: the other side's URI.
            timeout: seconds for this and each later wait; None: no limit.

        Raises:
            TransportInitError: that failed.
        """
        from rosgraph.network import ROSHandshakeException

        self.endpoint_id = endpoint_id
        try:
            self.socket = socket.create_connection((dest_addr, dest_port), timeout)
            self.local_endpoint, self.remote_endpoint = self.socket.getsockname(), self.socket.getpeername()
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.write_header()
            self.read_header()
        except (OSError, ProtocolError, TransportException, ROSHandshakeException) as error:
            self.close()
            raise TransportInitError(f"Unable to initiate TCP/IP socket to {dest_addr}:{dest_port}: {error}") from error

    def write_header(self) -> None:
        """Send the fields of the protocol as our connection header; without a socket, do nothing."""
        if self.socket is not None:
            data = encode_header(self.protocol.get_header_fields())
            self.socket.sendall(data)
            self.stat_bytes += len(data)

    def read_header(self) -> None:
        """Receive the other side's connection header; without a socket, do nothing.

        Raises:
            TransportInitError: it refuses, or its header has no type or md5sum.
            ROSHandshakeException: the connection ends before.
        """
        if self.socket is None:
            return
        reader = HeaderReader()
        until = monotonic() + (self._sock().gettimeout() or 60.0)
        header, received = None, 0
        while header is None:
            data = self._sock().recv(4096)
            if not data or monotonic() > until:
                from rosgraph.network import ROSHandshakeException

                raise ROSHandshakeException(
                    "connection from sender terminated before handshake header received. "
                    f"{received} bytes were received. Please check sender for additional details."
                )
            received += len(data)
            header = reader.feed(data)
        self.header = header
        self.read_buff.write(reader.rest)
        if "error" in header:
            raise TransportInitError(f"remote error reported: {header['error']}")
        for field in ("md5sum", "type"):
            if field not in header:
                raise TransportInitError(f"header missing required field [{field}]")
        self.type, self.md5sum = header["type"], header["md5sum"]
        self.callerid_pub = header.get("callerid", self.callerid_pub)
        self.is_latched = header.get("latching") == "1"

    def send_message(self, msg: Any, seq: int) -> None:
        """Send a message.

        Args:
            msg: the message.
            seq: put into its header, if it has one.
        """
        serialize_message(self.write_buff, seq, msg)
        data, self.write_buff = self.write_buff.getvalue(), io.BytesIO()
        self.write_data(data)

    def write_data(self, data: bytes) -> int:
        """Send bytes; return their number.

        Raises:
            TransportInitError: there is no connection.
            TransportTerminated: it has ended.
        """
        try:
            self._sock().sendall(data)
        except OSError as error:
            self.close()
            raise TransportTerminated(f"{error.errno}{error.strerror}") from error
        self.stat_bytes += len(data)
        self.stat_num_msg += 1
        return len(data)

    def receive_once(self) -> list[Any]:
        """Receive what comes next: a list of at least one message; an empty one if the connection is closed meanwhile.

        Raises:
            TransportTerminated: the connection has ended.
            TransportException: what came is not a message.
            ServiceException: a service has failed.
        """
        if self.socket is None:
            raise TransportException("connection not initialized")
        buffer, sock, found = self.read_buff, self.socket, list[Any]()
        try:
            while not (found or self.done or PROCESS.is_shutdown):
                if buffer.tell() >= 4:
                    self.protocol.read_messages(buffer, found, sock)
                if not found:
                    if buffer.tell() > MAX_MESSAGE_SIZE:
                        raise TransportException("too many bytes for a message")
                    self.stat_bytes += recv_buff(sock, buffer, self.protocol.buff_size)
        except (_DeserializationError, ProtocolError) as error:
            raise TransportException(f"receive_once[{self.name}]: DeserializationError {error}") from error
        for message in found:
            message._connection_header = self.header
        self.stat_num_msg += len(found)
        return found

    def receive_loop(self, msgs_callback: Callable[[list[Any], Any], object]) -> None:
        """Receive messages until the connection or the node ends, then close.

        Args:
            msgs_callback: called with the messages that have come, and this object.
        """
        try:
            while self.socket is not None and not self.done and not PROCESS.is_shutdown:
                messages = self.receive_once()
                if not self.done and not PROCESS.is_shutdown:
                    msgs_callback(messages, self)
        except TransportException as error:
            logger.debug("[%s] failed to receive incoming message: %s", self.name, error)
        finally:
            self.close()

    def _sock(self) -> socket.socket:
        if self.socket is None:
            raise TransportInitError("TCPROS transport was not successfully initialized")
        return self.socket

    def set_socket(self, sock: socket.socket, endpoint_id: str) -> None:
        """Use a connected socket.

        Args:
            sock: the socket.
            endpoint_id: the other side's URI or name.

        Raises:
            TransportInitError: there is a socket already.
        """
        if self.socket is not None:
            raise TransportInitError("socket already initialized")
        self.socket = sock
        self.local_endpoint = sock.getsockname()
        self.set_endpoint_id(endpoint_id)

    def set_endpoint_id(self, endpoint_id: str) -> None:
        """Set the other side's URI or name."""
        self.endpoint_id = endpoint_id

    def fileno(self) -> int | None:
        """Return the socket's number; None without one."""
        return self.socket.fileno() if self.socket is not None else None

    def get_transport_info(self) -> str:
        """Return the addresses of both ends, as text."""
        here, there = self.local_endpoint, self.remote_endpoint
        return f"TCPROS connection on port {here[1]} to [{there[0]}:{there[1]} on socket {self.fileno()}]"

    def close(self) -> None:
        """Close the connection."""
        if self.socket is not None:
            self.socket.close()
            self.socket = None
        super().close()


_server = ("TCPROSServer", "TCPServer", "init_tcpros_server", "start_tcpros_server", "get_tcpros_server_address")
__getattr__, __dir__ = _names(
    __name__,
    {
        **LATE,
        **dict.fromkeys(_server, "rospy.impl.tcpros_server"),
        "ServiceException": "rospy.service",
        "Log": "rosgraph_msgs.msg",
    },
)
