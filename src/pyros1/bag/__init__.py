"""Bags: files of recorded messages (https://wiki.ros.org/Bags/Format/2.0).

::

    import pyros1.bag

    with pyros1.bag.open("run.bag") as bag:
        for topic, message, time, connection in bag.messages(["/odom", "/scan"], start=10.0, end=20.0):
            ...
        frame = pandas.DataFrame(bag.arrays("/odom"))

    with pyros1.bag.open("new.bag", "w") as bag:
        bag.write("/odom", message, stamp)

Times in seconds are relative to the bag's beginning or, if negative, to its end; a `Time` is absolute.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.bag.api import Bag, BagMessage, bag_topics, open
    from pyros1.bag.errors import BagError, EncryptedError, NotABagError, UnindexedError
    from pyros1.bag.format.writer import BagWriter
    from pyros1.bag.writing import BagOutput

__all__ = [
    "Bag",
    "BagError",
    "BagMessage",
    "BagOutput",
    "BagWriter",
    "EncryptedError",
    "NotABagError",
    "UnindexedError",
    "bag_topics",
    "open",
]

_EXPORTS = {
    "Bag": "pyros1.bag.api",
    "BagError": "pyros1.bag.errors",
    "BagMessage": "pyros1.bag.api",
    "BagOutput": "pyros1.bag.writing",
    "BagWriter": "pyros1.bag.format.writer",
    "EncryptedError": "pyros1.bag.errors",
    "NotABagError": "pyros1.bag.errors",
    "UnindexedError": "pyros1.bag.errors",
    "bag_topics": "pyros1.bag.api",
    "open": "pyros1.bag.api",
}


def __getattr__(name: str) -> Any:
    """Import a public name on first use and return it: programs that only record bags need none of these names."""
    from pyros1.ground.lazy import load  # noqa: PLC0415 - most programs never call this

    return load(__name__, _EXPORTS, name)


def __dir__() -> list[str]:
    """Return all public names, loaded or not, for completion."""
    from pyros1.ground.lazy import public_names  # noqa: PLC0415 - most programs never call this

    return public_names(globals(), __all__)
