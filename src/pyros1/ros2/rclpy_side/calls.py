"""A service call from a ROS 2 client, received through rclpy."""

from __future__ import annotations

from collections.abc import Callable

from pyros1.ros2.zenoh.attachments import GID_SIZE, Attachment
from pyros1.ros2.zenoh.names import DataKey


class NoResponse(Exception):
    """A call gets no response. Raised by a callback, since that is the only way to make rclpy send nothing."""


class RclpyCall:
    """A call; see `pyros1.ros2.bridge.side.Call`.

    Args:
        key: the key of the service.
        body: the encoded request.
        end: called with the encoded response, or with None if there is none; only the first time counts.

    Attributes:
        key, body: as above.
        origin: a placeholder that marks the call as valid; rclpy does not tell who calls.
    """

    def __init__(self, key: DataKey, body: bytes, end: Callable[[bytes | None], object]) -> None:
        self.key = key
        self.body = body
        self.origin: Attachment | None = Attachment(0, 0, bytes(GID_SIZE))
        self._end = end

    def respond(self, body: bytes) -> None:
        """Send the encoded response."""
        self._end(body)

    def fail(self, text: str) -> None:
        """End the call without a response: ROS 2 services cannot return errors."""
        self._end(None)

    def drop(self) -> None:
        """End the call without a response."""
        self._end(None)
