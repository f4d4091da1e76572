"""Numeric arrays that share the received bytes: memoryviews, or numpy arrays as with rospy's ``numpy_msg``.

See https://wiki.ros.org/rospy_tutorials/Tutorials/numpy.

The arrays have one dimension and are read-only. Each function returns None for arrays of messages that it does not
create; the decoder then creates a list.
"""

from __future__ import annotations

import struct
import sys
from typing import Any

from pyros1.msgs.base import Message, View
from pyros1.msgs.records import view_records


def memoryview_view(buffer: bytes, position: int, count: int, code: str | type[Message]) -> Any:
    """Return ``count`` numbers at ``position`` as a memoryview of shape (count,), with the struct code as its format.

    Raises:
        NotImplementedError: the machine is not little-endian.
    """
    if not isinstance(code, str):
        return None
    if sys.byteorder != "little":
        raise NotImplementedError("arrays as memoryviews need a little-endian machine; use numpy arrays")
    view = memoryview(buffer)[position : position + count * struct.calcsize("<" + code)]
    return view if code == "B" else view.cast("B").cast(code)  # type: ignore[call-overload]  # codes are struct's


def make_numpy_view(numpy: Any, *, records: bool = False) -> View:
    """Return a function that creates numpy arrays of shape (count,), for a decoder's argument ``view``.

    Args:
        numpy: the numpy module.
        records: whether arrays of messages of fixed size become numpy arrays as well, see `records.view_records`.
    """
    types = {code: numpy.dtype("<" + code) for code in "bBhHiIqQfd?"}
    from_buffer, empty = numpy.frombuffer, numpy.empty

    def view(buffer: bytes, position: int, count: int, code: str | type[Message]) -> Any:
        if not isinstance(code, str):
            return view_records(buffer, position, count, code) if records else None
        if not count:
            return empty(0, types[code])
        return from_buffer(buffer, types[code], count, position)

    return view


def make_genpy_view(numpy: Any) -> View:
    """Return a function like that of `make_numpy_view`, except that it leaves uint8 and char arrays as bytes, like
    genpy.

    Args:
        numpy: the numpy module.
    """
    make_array = make_numpy_view(numpy)

    def view(buffer: bytes, position: int, count: int, code: str | type[Message]) -> Any:
        return bytes(buffer[position : position + count]) if code == "B" else make_array(buffer, position, count, code)

    return view


def find_view(arrays: str | None) -> View | None:
    """Return the function that creates the arrays of received messages.

    Args:
        arrays: None for bytes, tuples and lists; "memoryview"; "numpy", also for arrays of messages of fixed size.

    Raises:
        ValueError: ``arrays`` is something else.
    """
    if arrays is None:
        return None
    if arrays == "memoryview":
        return memoryview_view
    if arrays == "numpy":
        import numpy  # noqa: PLC0415  slow to import

        return make_numpy_view(numpy, records=True)
    raise ValueError(f'arrays must be None, "memoryview" or "numpy", not {arrays!r}')
