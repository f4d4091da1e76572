"""What is said over a topic's connection that a program makes itself, see `rospy.impl.tcpros_base.TCPROSTransport`."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.missing import missing
from pyros1.msgs import Message
from rospy.impl.tcpros_base import DEFAULT_BUFF_SIZE, TCPROSTransport, TCPROSTransportProtocol
from rospy.impl.transport import INBOUND, OUTBOUND
from rospy.names import get_caller_id

__all__ = ["DEFAULT_BUFF_SIZE", "TCPROSPub", "TCPROSSub", "TCPROSTransport", "TCPROSTransportProtocol"]


class TCPROSSub(TCPROSTransportProtocol):
    """A subscriber's side.

    Args:
        resolved_name: the topic.
        recv_data_class: class of its messages.
        queue_size, buff_size: as in rospy.
        tcp_nodelay: ask for messages without delay.
    """

    direction = INBOUND

    def __init__(
        self,
        resolved_name: str,
        recv_data_class: type[Message],
        queue_size: int | None = None,
        buff_size: int = DEFAULT_BUFF_SIZE,
        tcp_nodelay: bool = False,
    ) -> None:
        super().__init__(resolved_name, recv_data_class, queue_size, buff_size)
        self.tcp_nodelay = tcp_nodelay

    def get_header_fields(self) -> dict[str, str]:
        """Return the fields of the connection header."""
        nodelay = "1" if self.tcp_nodelay else "0"
        return {**_described(self.resolved_name, self.recv_data_class), "tcp_nodelay": nodelay}


class TCPROSPub(TCPROSTransportProtocol):
    """A publisher's side.

    Args:
        resolved_name: the topic.
        pub_data_class: class of its messages.
        is_latch: whether the newest message is sent to each new subscriber.
        headers: further fields of the connection header.
    """

    direction = OUTBOUND

    def __init__(
        self,
        resolved_name: str,
        pub_data_class: type[Message],
        is_latch: bool = False,
        headers: dict[str, str] | None = None,
    ) -> None:
        super().__init__(resolved_name, None, buff_size=128)
        self.pub_data_class = pub_data_class
        self.is_latch = is_latch
        self.headers = headers or {}

    def get_header_fields(self) -> dict[str, str]:
        """Return the fields of the connection header."""
        latching = "1" if self.is_latch else "0"
        return {**_described(self.resolved_name, self.pub_data_class), "latching": latching, **self.headers}


def _described(topic: str, cls: Any) -> dict[str, str]:
    return {
        "topic": topic,
        "type": cls._type,
        "md5sum": cls._md5sum,
        "message_definition": cls._full_text,
        "callerid": get_caller_id(),
    }


_OWN = "pyros1's nodes have their own links; see Publisher.impl and Subscriber.impl"
__getattr__ = missing(
    "rospy.impl.tcpros_pubsub",
    QueuedConnection=_OWN,
    TCPROSHandler=_OWN,
    check_if_still_publisher=_OWN,
    robust_connect_subscriber=_OWN,
)
