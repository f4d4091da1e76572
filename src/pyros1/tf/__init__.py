"""Coordinate frames over time (https://wiki.ros.org/tf2): the pose of one frame in another, now or at an earlier time.

::

    import pyros1
    from pyros1.tf import Buffer, TransformListener

    with pyros1.Node("where") as node:
        buffer = Buffer()
        TransformListener(node, buffer)
        pose = buffer.lookup_transform("map", "base_link", timeout=5.0)

This is pure Python, with tf2's rules, messages and exceptions. `pyros1.tf.transformations` has functions for
rotations and matrices, which use numpy.
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

_EXPORTS = {
    "Buffer": "pyros1.tf.buffer",
    "BufferClient": "pyros1.tf.buffer_client",
    "BufferServer": "pyros1.tf.buffer_server",
    "ConnectivityException": "pyros1.tf.errors",
    "ExtrapolationException": "pyros1.tf.errors",
    "InvalidArgumentException": "pyros1.tf.errors",
    "LookupException": "pyros1.tf.errors",
    "StaticTransformBroadcaster": "pyros1.tf.broadcaster",
    "TimeoutException": "pyros1.tf.errors",
    "TransformBroadcaster": "pyros1.tf.broadcaster",
    "TransformException": "pyros1.tf.errors",
    "TransformListener": "pyros1.tf.listener",
}


def __getattr__(name: str) -> Any:
    """Import a public name on first use, and return it: a program that only broadcasts needs no buffer, for example."""
    from pyros1.ground.lazy import load  # noqa: PLC0415 - not needed if only submodules are imported

    return load(__name__, _EXPORTS, name)


def __dir__() -> list[str]:
    """Return all public names, loaded or not, for completion."""
    from pyros1.ground.lazy import public_names  # noqa: PLC0415 - most programs never call this

    return public_names(globals(), __all__)
