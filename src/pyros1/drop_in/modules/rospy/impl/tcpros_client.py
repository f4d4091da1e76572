"""What the caller and the provider of a service say over a connection of which a program takes care itself."""

from __future__ import annotations

from typing import Any

from pyros1.msgs import Message
from pyros1.wire.service import RESPONSE_HEAD_SIZE, decode_response_head
from rospy.impl.tcpros_base import DEFAULT_BUFF_SIZE, TCPROSTransportProtocol, checked_size, recv_buff
from rospy.msg import deserialize_messages
from rospy.names import get_caller_id
from rospy.service import ServiceException

_ERROR_STEP = 256
"""Maximum number of bytes of an error's text to read at once."""


class TCPROSServiceClient(TCPROSTransportProtocol):
    """Calls of a service, for a `rospy.impl.tcpros_base.TCPROSTransport`.

    Args:
        resolved_name: of the service.
        service_class: its class.
        headers: further fields of the connection header.
        buff_size: as in rospy.
    """

    def __init__(
        self,
        resolved_name: str,
        service_class: Any,
        headers: dict[str, str] | None = None,
        buff_size: int = DEFAULT_BUFF_SIZE,
    ) -> None:
        response: type[Message] = service_class._response_class
        super().__init__(resolved_name, response, buff_size=buff_size)
        self.service_class = service_class
        self.headers = headers or {}

    def get_header_fields(self) -> dict[str, str]:
        """Return the fields of the connection header."""
        fields = {"service": self.resolved_name, "md5sum": self.service_class._md5sum, "callerid": get_caller_id()}
        return {**fields, **self.headers}

    def read_messages(self, b: Any, msg_queue: list[Any], sock: Any) -> None:
        """Take a response out of a buffer.

        Args:
            b: what has come, up to its position.
            msg_queue: gets the response, if it is whole.
            sock: where the rest of an error's text is read.

        Raises:
            ServiceException: the service has failed.
            TransportTerminated: the connection has ended.
        """
        if not b.tell() or b.getvalue()[0]:
            deserialize_messages(b, msg_queue, self.recv_data_class, self.queue_size, 1, 1)
            if b.tell() == 1:  # only the byte that marks success is left
                b.seek(0)
            return
        while b.tell() < RESPONSE_HEAD_SIZE:
            recv_buff(sock, b, _ERROR_STEP)
        _, size = decode_response_head(b.getvalue()[:RESPONSE_HEAD_SIZE])
        end = RESPONSE_HEAD_SIZE + checked_size(size)
        while b.tell() < end:
            recv_buff(sock, b, _ERROR_STEP)
        text = b.getvalue()[RESPONSE_HEAD_SIZE:end]
        b.seek(0)
        b.truncate()
        raise ServiceException(f"service [{self.resolved_name}] responded with an error: {text!r}")


class TCPService(TCPROSTransportProtocol):
    """The provider's side of a connection.

    Args:
        resolved_name: of the service.
        service_class: its class.
        buff_size: as in rospy.
    """

    def __init__(self, resolved_name: str, service_class: Any, buff_size: int = DEFAULT_BUFF_SIZE) -> None:
        super().__init__(resolved_name, service_class._request_class, buff_size=buff_size)
        self.service_class = service_class

    def get_header_fields(self) -> dict[str, str]:
        """Return the fields of the connection header."""
        cls = self.service_class
        return {
            "service": self.resolved_name,
            "type": cls._type,
            "md5sum": cls._md5sum,
            "callerid": get_caller_id(),
        }
