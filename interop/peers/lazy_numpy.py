"""Lets programs import numpy only when they use it.

genpy, and so each program of stock ROS 1 in Python, imports numpy at its start, and few use it. `.ci/run` installs this
module for Debian's Python in the fresh system in which the tests run, with a file ``lazy_numpy.pth`` that imports it:
each start then takes 0.25 s instead of 0.45 s.
"""

import sys
import threading
from types import ModuleType

_lock = threading.RLock()


class _LazyModule(ModuleType):
    def __getattr__(self, name: str) -> object:
        with _lock:
            if sys.modules.get("numpy") is self:
                del sys.modules["numpy"]
        import numpy

        return getattr(numpy, name)


sys.modules.setdefault("numpy", _LazyModule("numpy"))
