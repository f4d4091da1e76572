"""Bags: files of recorded messages (https://wiki.ros.org/Bags/Format/2.0).

::

    import pyros1.bag

    with pyros1.bag.open("run.bag") as bag:
        for topic, message, time, connection in bag.messages(["/odom", "/scan"], start=10.0, end=20.0):
            ...
        frame = pandas.DataFrame(bag.arrays("/odom"))

Times in seconds count from the bag's beginning, negative ones from its end; a `Time` is taken as it is.
"""

from pyros1.bag.api import Bag, BagMessage, bag_topics, open
from pyros1.bag.container import BagWriter
from pyros1.bag.errors import BagError, EncryptedError, NotABagError, UnindexedError

__all__ = [
    "Bag",
    "BagError",
    "BagMessage",
    "BagWriter",
    "EncryptedError",
    "NotABagError",
    "UnindexedError",
    "bag_topics",
    "open",
]
