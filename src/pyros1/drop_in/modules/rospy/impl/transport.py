"""Base class of connections."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

from pyros1.drop_in.module_attributes import module_hooks as _module_hooks

INBOUND, OUTBOUND, BIDIRECTIONAL = "i", "o", "b"
next_id = itertools.count(1).__next__


class Transport:
    """A connection.

    Args:
        direction: "i", "o" or "b".
        name: name of the topic or service.

    Attributes:
        id: number of the connection.
        endpoint_id: name or address of the other side.
        done: whether the connection has ended.
        stat_bytes, stat_num_msg: number of bytes and messages received.
    """

    transport_type = "UNKNOWN"
    done = False  # on the class, since each service call creates an object of a subclass
    cleanup_cb: Callable[[Any], object] | None = None
    endpoint_id = ""
    stat_bytes = 0
    stat_num_msg = 0
    md5sum: str | None = None
    type: str | None = None

    def __init__(self, direction: str, name: str = "unnamed") -> None:
        self.name = name
        self.direction = direction
        self.id = next_id()

    def fileno(self) -> int | None:
        """Return the socket's file descriptor.

        Raises:
            NotImplementedError: in this base class.
        """
        raise NotImplementedError

    def write_data(self, data: bytes) -> Any:
        """Send bytes.

        Raises:
            NotImplementedError: in this base class.
        """
        raise NotImplementedError

    def set_cleanup_callback(self, cleanup_callback: Callable[[Any], object]) -> None:
        """Call a function with this object when the connection is closed."""
        self.cleanup_cb = cleanup_callback

    def get_transport_info(self) -> str:
        """Return a description of the connection."""
        return f"{self.transport_type} connection to [{self.endpoint_id}]"

    def close(self) -> None:
        """Close the connection."""
        is_first, self.done = not self.done, True
        if is_first and self.cleanup_cb is not None:
            self.cleanup_cb(self)


_reason = "pyros1's nodes have their own links; see Publisher.impl.connections"
__getattr__, __dir__ = _module_hooks(
    __name__, missing_reasons=dict.fromkeys(("DeadTransport", "ProtocolHandler"), _reason)
)
