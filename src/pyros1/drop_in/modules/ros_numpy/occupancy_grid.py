"""Converts maps to numpy arrays, and back."""

from __future__ import annotations

import sys
from array import array
from typing import Any

import numpy as np

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.nav_msgs.msg import MapMetaData, OccupancyGrid
from ros_numpy.registry import converts_from_numpy, converts_to_numpy

__getattr__ = module_getattr(__name__)


@converts_to_numpy(OccupancyGrid)
def occupancygrid_to_numpy(msg: Any) -> Any:
    """Convert a map to a masked array of shape (height, width), with unknown cells masked."""
    data = np.asarray(msg.data, dtype=np.int8).reshape(msg.info.height, msg.info.width)
    return np.ma.array(data, mask=data == -1, fill_value=-1)  # type: ignore[no-untyped-call, unused-ignore]


@converts_from_numpy(OccupancyGrid)
def numpy_to_occupancy_grid(arr: Any, info: Any = None) -> Any:
    """Convert a map to a message.

    Args:
        arr: array of int8 of shape (height, width); masked cells are unknown.
        info: the map's origin and resolution; None for default values.

    Raises:
        TypeError: the array has the wrong shape or type.
    """
    if arr.ndim != 2:
        raise TypeError("Array must be 2D")
    if arr.dtype != np.int8:
        raise TypeError("Array must be of int8s")
    if isinstance(arr, np.ma.MaskedArray):
        arr = arr.filled(-1)  # type: ignore[no-untyped-call, unused-ignore]
    info = info or MapMetaData()
    info.height, info.width = arr.shape
    return OccupancyGrid(info=info, data=array("b", arr.tobytes()))
