"""Numeric arrays that refer to the received bytes instead of copying them: memoryviews, or numpy arrays as rospy's
``numpy_msg`` gives them (https://wiki.ros.org/rospy_tutorials/Tutorials/numpy).

They are read-only.
"""

from __future__ import annotations

import struct
import sys
from typing import Any

from pyros1.msgs.base import View


def memoryview_view(buffer: bytes, position: int, count: int, code: str) -> Any:
    """Return ``count`` numbers of the struct code at ``position`` as a memoryview of that format.

    Raises:
        NotImplementedError: on a machine whose numbers are not little-endian.
    """
    if sys.byteorder != "little":
        raise NotImplementedError("arrays as memoryviews need a little-endian machine; use numpy arrays")
    part = memoryview(buffer)[position : position + count * struct.calcsize("<" + code)]
    return part if code == "B" else part.cast("B").cast(code)  # type: ignore[call-overload]  # codes are struct's


def numpy_view(numpy: Any) -> View:
    """Return the function that makes numpy arrays.

    Args:
        numpy: the numpy module.
    """
    types = {code: numpy.dtype("<" + code) for code in "bBhHiIqQfd?"}
    from_buffer, empty = numpy.frombuffer, numpy.empty

    def view(buffer: bytes, position: int, count: int, code: str) -> Any:
        if not count:
            return empty(0, types[code])
        return from_buffer(buffer, types[code], count, position)

    return view
