"""Merges the static transforms that several publishers latched, since the player publishes all of them together.
Does no I/O.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.bag.format.records import Connection
from pyros1.ground.errors import MessageError
from pyros1.msgs import AnyMsg, load_message

TRANSFORMS_TYPE = "tf2_msgs/TFMessage"


def is_static_transforms(connection: Connection) -> bool:
    """Return whether a connection's messages are static transforms, which late subscribers must receive.

    The connection need not be latched, since bags written by Python programs do not record that.
    """
    return (
        connection.topic.rpartition("/")[2] == "tf_static"
        and connection.type == TRANSFORMS_TYPE
        and connection.md5sum == load_message(TRANSFORMS_TYPE)._md5sum
    )


class StaticTransforms:
    """Publishes static transforms, always together with all earlier ones: for each child frame, only the latest.

    Args:
        send: publishes a message.
    """

    def __init__(self, send: Callable[[AnyMsg], object]) -> None:
        self._send = send
        self._class: Any = load_message(TRANSFORMS_TYPE)
        self._transforms: dict[str, Any] = {}

    def publish(self, message: AnyMsg) -> None:
        """Publish a message with all earlier transforms; a message that cannot be decoded is published unchanged."""
        try:
            received = self._class._decode(message._buff, 0, len(message._buff)).transforms
            transforms = self._transforms | {transform.child_frame_id: transform for transform in received}
            message = AnyMsg(self._class._encode(self._class(list(transforms.values()))))
        except MessageError:
            pass
        else:
            self._transforms = transforms
        self._send(message)
