"""The transport object through which a service handler writes its response."""

from __future__ import annotations

import io
import struct
from functools import cached_property
from typing import Any

from pyros1.ground.errors import ProtocolError, ServiceRefusal
from pyros1.wire.service import RESPONSE_HEAD_SIZE, decode_response_head
from rospy.impl.transport import BIDIRECTIONAL, Transport, next_id


def write_error(transport: Any, text: str) -> None:
    """Write a service's error response.

    Args:
        transport: an object with the method ``write_data``.
        text: the reason.
    """
    data = text.encode()
    transport.write_data(struct.pack("<BI", 0, len(data)) + data)


class RequestTransport(Transport):
    """Collects the response to a request, as a message or as bytes; pyros1's node then sends it.

    Args:
        name: name of the service.
        request: the request.
    """

    transport_type = "TCPROS"
    direction = BIDIRECTIONAL
    _message: Any = None
    _data = b""

    def __init__(
        self, name: str, request: Any
    ) -> None:  # called for each request: attributes that few programs use are created later
        self.name = name
        self._request = request

    @cached_property
    def id(self) -> int:  # type: ignore[override]
        """The number of the connection."""
        return next_id()

    @cached_property
    def header(self) -> dict[str, str]:
        """The caller's connection header."""
        return getattr(self._request, "_connection_header", None) or {}

    @cached_property
    def endpoint_id(self) -> str:  # type: ignore[override]
        """The caller's name."""
        return self.header.get("callerid", "")

    @cached_property
    def write_buff(self) -> io.BytesIO:
        """Buffer in which a program collects bytes before sending them."""
        return io.BytesIO()

    def send_message(self, msg: Any, seq: int) -> None:
        """Respond with a message; ``seq`` is written to its header, if it has one."""
        if getattr(msg, "_has_header", False):
            msg.header.seq = seq
        self._message = msg
        self.__dict__.pop("write_buff", None)

    def write_data(self, data: bytes) -> bool:
        """Respond with bytes: 1, length and response; or 0, length and the reason for the failure."""
        self._data += data
        return True

    def get_response(self, response_class: Any) -> Any:
        """Return the response.

        Raises:
            ServiceRefusal: the service has failed, or has not written a response.
        """
        if self._message is not None:
            return self._message
        try:
            ok, size = decode_response_head(self._data[:RESPONSE_HEAD_SIZE])
        except (ProtocolError, struct.error):
            raise ServiceRefusal("the service has sent no response") from None
        body = self._data[RESPONSE_HEAD_SIZE : RESPONSE_HEAD_SIZE + size]
        if not ok:
            raise ServiceRefusal(body.decode(errors="replace"))
        return response_class().deserialize(body)
