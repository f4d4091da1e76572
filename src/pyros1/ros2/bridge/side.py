"""What a bridge needs of its side in ROS 2: an interface, of zenoh's session and of rclpy's."""

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
    """A call of a service that a client in ROS 2 has made. Whoever gets it must end it, by one of its methods.

    Attributes:
        key: the key of the service.
        body: the encoded request.
        origin: what the client says of the request; None if the call is not valid, and must be dropped.
    """

    key: DataKey
    body: bytes
    origin: Attachment | None

    def respond(self, body: bytes) -> None:
        """Send the encoded response."""
        ...

    def fail(self, text: str) -> None:
        """Say why there is no response, as far as ROS 2 can be told."""
        ...

    def drop(self) -> None:
        """End the call without a response."""
        ...


class Ros2Side(Link, Protocol):
    """A node in ROS 2, and all that it has. What it calls, it calls on threads of its own.

    Attributes:
        session: None until something can be declared.
    """

    session: Any

    def declare(
        self,
        publishers: Mapping[str, tuple[DataKey, Qos, Priority]],
        subscribers: Mapping[DataKey, Qos],
        services: Iterable[DataKey] = (),
        clients: Iterable[DataKey] = (),
    ) -> dict[str, str]:
        """Have exactly these publishers and so on, see `pyros1.ros2.zenoh.session.Ros2Session.declare`."""
        ...

    def rename(self, node: str) -> None:
        """Give its node another name. All that is declared ends; `declare` declares it anew."""
        ...

    def look_for_routers(self) -> None:
        """Note in `problem` if there is no way to the other nodes any more."""
        ...

    def start_call(
        self, key: DataKey, request: bytes, timeout: float, done: Callable[[bytes | ServiceRefusal], object]
    ) -> None:
        """Call a service without waiting, see `pyros1.ros2.zenoh.session.Ros2Session.start_call`."""
        ...

    def call(self, key: DataKey, request: bytes, timeout: float) -> bytes:
        """Call a service, see `pyros1.ros2.zenoh.session.Ros2Session.call`."""
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
"""Makes the side in ROS 2: it is given its id in zenoh, and the functions that take tokens, messages and calls."""
