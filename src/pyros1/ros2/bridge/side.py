"""The interface of a bridge's ROS 2 side, implemented by the zenoh and rclpy sessions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol, runtime_checkable

from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.link import Link
from pyros1.ground.errors import ServiceRefusal
from pyros1.ros2.zenoh.attachments import Attachment
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.qos import Qos


@runtime_checkable
class Call(Protocol):
    """A service call from a client in ROS 2. The receiver must end it with one of its methods.

    Attributes:
        key: the key of the service.
        body: the encoded request.
        origin: the attachment of the request; None if the call is not valid, and must be dropped.
    """

    key: DataKey
    body: bytes
    origin: Attachment | None

    def respond(self, body: bytes) -> None:
        """Send the encoded response."""
        ...

    def fail(self, text: str) -> None:
        """End the call without a response, and tell ROS 2 why, if possible."""
        ...

    def drop(self) -> None:
        """End the call without a response."""
        ...


class Ros2Side(Link, Protocol):
    """A node in ROS 2, with its publishers, subscribers and services. Its callbacks run on its own threads.

    Attributes:
        way: how it connects to ROS 2: ``zenoh`` or ``rclpy``.
        session: None until something can be declared.
    """

    way: str
    session: Any

    def declare(
        self,
        publishers: Mapping[str, tuple[DataKey, Qos, Priority]],
        subscribers: Mapping[DataKey, Qos],
        services: Iterable[DataKey] = (),
        clients: Iterable[DataKey] = (),
    ) -> dict[str, str]:
        """Make exactly these declarations; does nothing before there is a connection.

        Args:
            publishers: the publishers, by the keys of their packets: each with its key in ROS 2, its QoS, and the
                priority of its messages, which only zenoh uses.
            subscribers: the keys to subscribe to, each with QoS.
            services: the keys of services to offer.
            clients: the keys of services to call.

        Returns:
            Topic or service -> why it cannot be declared; the others are declared.

        Raises:
            DeclarationError: rclpy does not do it in time, or fails.
        """
        ...

    def rename(self, node: str) -> None:
        """Rename its node. This undeclares everything; `declare` declares it again.

        Raises:
            DeclarationError: rclpy does not do it in time, or fails.
        """
        ...

    def look_for_routers(self) -> None:
        """Record in `problem` if the other nodes can no longer be reached."""
        ...

    def call(self, key: DataKey, request: bytes, timeout: float) -> bytes:
        """Call a service in ROS 2 for which there is a client, and return the encoded response.

        Args:
            key: the key of the service.
            request: the encoded request.
            timeout: maximum number of seconds to wait.

        Raises:
            ServiceRefusal: there was no response, or an error.
        """
        ...

    def start_call(
        self, key: DataKey, request: bytes, timeout: float, done: Callable[[bytes | ServiceRefusal], object]
    ) -> None:
        """Call a service in ROS 2 as `call` does, without waiting for the response.

        Args:
            key: the key of the service.
            request: the encoded request.
            timeout: maximum number of seconds until there is a response.
            done: called once, on any thread, with the encoded response, or with the reason why there is none, also if
                the session closes. It must return at once.

        Raises:
            ServiceRefusal: the call cannot be made; then `done` is not called.
        """
        ...


MakeSide = Callable[
    [
        str,
        Callable[[str, bool], object],
        Callable[[DataKey, bytes, bytes, str], object],
        Callable[[Call], object],
    ],
    Ros2Side,
]
"""Makes the ROS 2 side, given its id in zenoh and the callbacks for tokens, messages and calls."""
