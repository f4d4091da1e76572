"""Coordinate frames over time (https://wiki.ros.org/tf2): where is one frame as seen from another, now or then.

::

    import pyros1
    from pyros1.tf import Buffer, TransformListener

    with pyros1.Node("where") as node:
        buffer = Buffer()
        TransformListener(node, buffer)
        pose = buffer.lookup_transform("map", "base_link", timeout=5.0)

tf2's rules, texts and exceptions, in Python alone. `pyros1.tf.transformations` has the calculations.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.tf.broadcaster import StaticTransformBroadcaster, TransformBroadcaster
    from pyros1.tf.buffer import Buffer
    from pyros1.tf.buffer_client import BufferClient
    from pyros1.tf.buffer_server import BufferServer
    from pyros1.tf.errors import (
        ConnectivityException,
        ExtrapolationException,
        InvalidArgumentException,
        LookupException,
        TimeoutException,
        TransformException,
    )
    from pyros1.tf.listener import TransformListener

__all__ = [
    "Buffer",
    "BufferClient",
    "BufferServer",
    "ConnectivityException",
    "ExtrapolationException",
    "InvalidArgumentException",
    "LookupException",
    "StaticTransformBroadcaster",
    "TimeoutException",
    "TransformBroadcaster",
    "TransformException",
    "TransformListener",
]

_HOMES = {
    "Buffer": "buffer",
    "BufferClient": "buffer_client",
    "BufferServer": "buffer_server",
    "StaticTransformBroadcaster": "broadcaster",
    "TransformBroadcaster": "broadcaster",
    "TransformListener": "listener",
}


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used: a static publisher needs no buffer."""
    if name not in __all__:
        raise AttributeError(f"module 'pyros1.tf' has no attribute {name!r}")
    import importlib  # noqa: PLC0415

    return getattr(importlib.import_module(f"pyros1.tf.{_HOMES.get(name, 'errors')}"), name)
