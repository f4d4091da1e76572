"""What a caller of a service says over a connection that a program makes itself."""

from __future__ import annotations

from typing import Any

from pyros1.msgs import Message
from pyros1.wire.service import RESPONSE_HEAD_SIZE, decode_response_head
from rospy.impl.tcpros_base import DEFAULT_BUFF_SIZE, TCPROSTransport, TCPROSTransportProtocol
from rospy.service import ServiceException


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
        return {"service": self.resolved_name, "md5sum": self.service_class._md5sum, **self.headers}

    def take(self, transport: TCPROSTransport) -> list[Any]:
        """Receive a response.

        Raises:
            ServiceException: the service has failed.
            TransportException: the connection has ended.
        """
        ok, size = decode_response_head(transport.receive_bytes(RESPONSE_HEAD_SIZE))
        body = transport.receive_bytes(size)
        if not ok:
            raise ServiceException(f"service [{self.resolved_name}] responded with an error: {body!r}")
        return [self.recv_data_class._decode(body, 0, size)]
