"""Converts maps to messages and back (no I/O)."""

from __future__ import annotations

from math import hypot, isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.msgs.geometry_msgs.msg import Point, Pose, Quaternion
from pyros1.msgs.nav_msgs.msg import MapMetaData, OccupancyGrid
from pyros1.msgs.std_msgs.msg import Header
from pyros1.robot_nodes.map_server.errors import MapDataError
from pyros1.tf.rotation import from_angles, to_angles


def make_grid(cells: NDArray[np.int8], resolution: float, origin: tuple[float, float, float]) -> Any:
    """Return a nav_msgs/OccupancyGrid without stamps or frame.

    Args:
        cells: the map, with shape (height, width), the lowest row first.
        resolution: size of a cell in m.
        origin: pose of the corner of cell (0, 0): x and y in m, yaw in radians.
    """
    height, width = cells.shape
    x, y, yaw = origin
    pose = Pose(Point(x, y, 0.0), Quaternion(*from_angles(0.0, 0.0, yaw)))
    info = MapMetaData(resolution=resolution, width=width, height=height, origin=pose)
    return OccupancyGrid(header=Header(), info=info, data=np.ascontiguousarray(cells).reshape(-1))


def read_grid(message: Any) -> tuple[NDArray[np.int8], tuple[float, float, float]]:
    """Return the cells of a nav_msgs/OccupancyGrid, with shape (height, width), and its origin: x, y, yaw.

    Raises:
        MapDataError: the grid has no cells, or their number does not match its size.
    """
    info = message.info
    cells = np.asarray(message.data, dtype=np.int8)
    if not cells.size or cells.size != info.width * info.height:
        raise MapDataError(f"the map has {cells.size} cells instead of {info.width} x {info.height}")
    position, rotation = info.origin.position, info.origin.orientation
    parts = rotation.x, rotation.y, rotation.z, rotation.w
    length = hypot(*parts)
    x, y, z, w = (part / length if length else 0.0 for part in parts)
    yaw = to_angles((x, y, z, w))[2] if length else 0.0
    origin = (position.x, position.y, yaw)
    if not all(map(isfinite, (info.resolution, *origin))):
        raise MapDataError("the map's resolution or origin is not a number")
    return cells.reshape(info.height, info.width), origin
