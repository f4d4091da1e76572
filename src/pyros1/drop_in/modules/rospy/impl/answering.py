"""One request at a service, as a connection on which its answer is written."""

from __future__ import annotations

import io
import struct
from functools import cached_property
from typing import Any

from pyros1.ground.errors import ProtocolError, ServiceRefusal
from pyros1.wire.service import RESPONSE_HEAD_SIZE, decode_response_head
from rospy.impl.transport import BIDIRECTIONAL, Transport, next_number


def write_error(transport: Any, text: str) -> None:
    """Write the answer of a service that has failed.

    Args:
        transport: has ``write_data``.
        text: the reason.
    """
    data = text.encode()
    transport.write_data(struct.pack("<BI", 0, len(data)) + data)


class Exchange(Transport):
    """Takes the answer to a request, as a message or as bytes; pyros1's node sends it.

    Args:
        name: of the service.
        request: the request.
    """

    transport_type = "TCPROS"
    direction = BIDIRECTIONAL
    _message: Any = None
    _data = b""

    def __init__(self, name: str, request: Any) -> None:  # one for each call: what few ask for is made when they do
        self.name = name
        self._request = request

    @cached_property
    def id(self) -> int:  # type: ignore[override]
        """Its number."""
        return next_number()

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
        """Takes what a program writes before it sends it."""
        return io.BytesIO()

    def send_message(self, msg: Any, seq: int) -> None:
        """Answer with a message; ``seq`` is put into its header, if it has one."""
        if getattr(msg, "_has_header", False):
            msg.header.seq = seq
        self._message = msg
        self.__dict__.pop("write_buff", None)

    def write_data(self, data: bytes) -> bool:
        """Answer with bytes: 1, length and response; or 0, length and reason."""
        self._data += data
        return True

    def answer(self, response_class: Any) -> Any:
        """Return the response.

        Raises:
            ServiceRefusal: the answer is that the service has failed, or there is none.
        """
        if self._message is not None:
            return self._message
        try:
            ok, size = decode_response_head(self._data[:RESPONSE_HEAD_SIZE])
        except (ProtocolError, struct.error):
            raise ServiceRefusal("the service has sent no answer") from None
        body = self._data[RESPONSE_HEAD_SIZE : RESPONSE_HEAD_SIZE + size]
        if not ok:
            raise ServiceRefusal(body.decode(errors="replace"))
        return response_class().deserialize(body)
