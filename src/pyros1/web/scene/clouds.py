"""Clouds of points as blocks of numbers that a page hands to its graphics card as they are. Pure but for numpy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.web.scene.shape import Shape, ShapeError

MOST_POINTS = 1_500_000
"""Most points of a cloud that are sent."""
_KINDS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""numpy's names of the types of sensor_msgs/PointField."""
_PACKED = ("rgb", "rgba")
_PLACE = ("x", "y", "z")
Bounds = tuple[float, float]
"""The least and the greatest value that have colours of their own."""
_Floats = NDArray[np.float32]


def point_cloud2(
    cloud: Any, by: str = "", most: int = MOST_POINTS, numbers: bool = False, bounds: Bounds | None = None
) -> Shape:
    """Return a sensor_msgs/PointCloud2.

    Args:
        cloud: the message.
        by: the field that colours the points; empty for "rgb", "intensity" or "z", the first that there is.
        most: the number of points that are sent at most; of larger clouds every second, third ... point.
        numbers: whether to send the points' places in the message and their values, too.
        bounds: of the values; None for the least and the greatest that there are.

    Returns:
        "count", "every" (one of how many points is sent), "fields" (those that can colour), "by", and "colour":

        - "rgb": for each point four bytes blue, green, red and one to ignore
        - "value": for each point one byte, from the field's "least" (0) to its "most" (255)
        - "x", "y", "z": nothing; the page knows where the points are

        with the places as float32 x, y, z, and then the colours. Points without a place are left out. If "numbers" are
        sent, the index of each point in the message as uint32, and for "value" its float32, are before the colours.

    Raises:
        ShapeError: the sizes in the message contradict each other, or it has no x, y and z.
    """
    points = _points(cloud)
    fields = list(points.dtype.names or ())
    every = -(-len(points) // most) or 1
    points = points[::every]
    places = np.empty((len(points), 3), np.float32)
    with np.errstate(all="ignore"):
        for index, name in enumerate("xyz"):
            places[:, index] = points[name]
    if by not in fields:
        by = next((name for name in (*_PACKED, "intensity") if name in fields), "z")
    colours = points[by].copy()
    indices = np.arange(len(points), dtype=np.uint32) * np.uint32(every) if numbers else None
    with np.errstate(all="ignore"):
        whole = np.isfinite(places.sum())  # most clouds; to look at each point takes five times as long
    if not whole:
        there = np.isfinite(places).all(axis=1)
        places, colours = places[there], colours[there]
        indices = None if indices is None else indices[there]
    facts = {"kind": "cloud", "count": len(places), "every": every, "fields": fields}
    return _coloured(facts, places, colours, by, bool(cloud.is_bigendian), indices, bounds)


def point_cloud(
    cloud: Any, by: str = "", most: int = MOST_POINTS, numbers: bool = False, bounds: Bounds | None = None
) -> Shape:
    """Return a sensor_msgs/PointCloud; as `point_cloud2`. Its channels are fields."""
    every = -(-len(cloud.points) // most) or 1
    channels = {
        each.name: each.values
        for each in cloud.channels
        if len(each.values) == len(cloud.points) and each.name not in _PLACE
    }
    fields = [*_PLACE, *channels]
    if by not in fields:
        by = next((name for name in (*_PACKED, "intensity") if name in channels), "z")
    with np.errstate(all="ignore"):
        places = np.array([(each.x, each.y, each.z) for each in cloud.points[::every]], np.float32).reshape(-1, 3)
        values = np.asarray(channels[by], np.float32)[::every] if by in channels else places[:, "xyz".index(by)]
    there = np.isfinite(places).all(axis=1)
    facts = {"kind": "cloud", "count": int(there.sum()), "every": every, "fields": fields}
    indices = (np.flatnonzero(there) * every).astype(np.uint32) if numbers else None
    return _coloured(facts, places[there], values[there], by, False, indices, bounds)


def _points(cloud: Any) -> NDArray[Any]:
    width, height, step, row = cloud.width, cloud.height, cloud.point_step, cloud.row_step
    names = [field.name for field in cloud.fields]
    if not {"x", "y", "z"} <= {*names}:
        raise ShapeError(f"a cloud without x, y and z; it has {', '.join(names) or 'no fields'}"[:300])
    if step < 1 or row < width * step or len(cloud.data) < (row * (height - 1) + width * step if height else 0):
        raise ShapeError(f"{width} x {height} points of {step} bytes do not fit into {len(cloud.data)} bytes")
    order = ">" if cloud.is_bigendian else "<"
    known = {field.name: (order + _KINDS[field.datatype], field.offset) for field in cloud.fields if _good(field)}
    if any(offset + np.dtype(kind).itemsize > step for kind, offset in known.values()):
        raise ShapeError(f"a field ends behind its point, which has {step} bytes")
    if not {"x", "y", "z"} <= known.keys():
        raise ShapeError("x, y and z of the points are of no type of numbers")
    if not width or not height:
        return np.empty(0, [(name, kind) for name, (kind, _) in known.items()])
    layout = np.dtype(
        {
            "names": [*known],
            "formats": [kind for kind, _ in known.values()],
            "offsets": [offset for _, offset in known.values()],
            "itemsize": step,
        }
    )
    if height == 1 or row == width * step:
        return np.frombuffer(cloud.data, layout, width * height)
    rows: NDArray[Any] = np.ndarray((height, width), layout, cloud.data, strides=(row, step))
    return rows.reshape(-1)


def _good(field: Any) -> bool:
    return field.datatype in _KINDS and bool(field.name)


def _coloured(
    facts: dict[str, Any],
    places: _Floats,
    values: NDArray[Any],
    by: str,
    swapped: bool,
    indices: NDArray[np.uint32] | None,
    bounds: Bounds | None,
) -> Shape:
    facts["by"] = by
    blob = places.tobytes()
    if indices is not None:
        facts["numbers"] = True
        blob += indices.tobytes()
    if by in _PACKED and values.dtype.itemsize == 4:
        packed = np.ascontiguousarray(values)
        return {**facts, "colour": "rgb"}, blob + (packed.byteswap() if swapped else packed).tobytes()
    if by in _PLACE:
        return {**facts, "colour": by}, blob
    with np.errstate(all="ignore"):
        floats = values.astype(np.float32)
        finite = floats[np.isfinite(floats)]
        least, most = bounds or ((float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0))
        facts |= {"least": least, "most": most}
        share = (floats - least) * np.float32(255 / (most - least) if most > least else 0)
        if len(finite) < len(floats):
            share = np.nan_to_num(share, nan=0.0, posinf=255.0, neginf=0.0)
        levels = share.clip(0, 255).astype(np.uint8)
    if indices is not None:
        blob += floats.tobytes()
    return {**facts, "colour": "value"}, blob + levels.tobytes()
