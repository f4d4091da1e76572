"""Synchronizes messages of several topics, and caches recent messages (https://wiki.ros.org/message_filters).

::

    import pyros1
    from pyros1.filters import Subscriber, Synchronizer

    with pyros1.Node("stereo") as node:
        inputs = [Subscriber(node, name, "sensor_msgs/Image") for name in ("left", "right")]
        Synchronizer(inputs, queue_size=10, slop=0.02).connect(lambda left, right: ...)
        node.spin()

In asyncio programs: ``async for left, right in synchronized(node, {"left": Image, "right": Image}, slop=0.02)``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.filters.asyncio_synchronizer import synchronized
    from pyros1.filters.chain import Cache, Filter, Subscriber, Synchronizer
    from pyros1.filters.synchronizers import ApproximateTime, ExactTime, Recent

__all__ = [
    "ApproximateTime",
    "Cache",
    "ExactTime",
    "Filter",
    "Recent",
    "Subscriber",
    "Synchronizer",
    "synchronized",
]

_EXPORTS = {
    "ApproximateTime": "pyros1.filters.synchronizers",
    "Cache": "pyros1.filters.chain",
    "ExactTime": "pyros1.filters.synchronizers",
    "Filter": "pyros1.filters.chain",
    "Recent": "pyros1.filters.synchronizers",
    "Subscriber": "pyros1.filters.chain",
    "Synchronizer": "pyros1.filters.chain",
    "synchronized": "pyros1.filters.asyncio_synchronizer",
}


def __getattr__(name: str) -> Any:
    """Load and return a public name when it is first used."""
    from pyros1.ground.lazy import load  # noqa: PLC0415 - not needed if only submodules are imported

    return load(__name__, _EXPORTS, name)


def __dir__() -> list[str]:
    """Return all public names, loaded or not, for completion."""
    from pyros1.ground.lazy import public_names  # noqa: PLC0415 - most programs never call this

    return public_names(globals(), __all__)
