"""Clouds of points as blocks of numbers that a page hands to its graphics card as they are. Pure but for numpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
RED_GREEN_BLUE = "r, g, b"
"""What colours points by their three fields of these names, from 0 to 1: rviz's RGBF32."""
MONO = "rgb as grey"
"""What colours points by the brightness of their "rgb" or "rgba": rviz's MONO8."""
_MADE = (RED_GREEN_BLUE, MONO)
_BEST = (*_PACKED, RED_GREEN_BLUE, "intensity")
Bounds = tuple[float, float]
"""The least and the greatest value that have colours of their own."""
_Floats = NDArray[np.float32]


def point_cloud2(
    cloud: Any, by: str = "", most: int = MOST_POINTS, numbers: bool = False, bounds: Bounds | None = None
) -> Shape:
    """Return a sensor_msgs/PointCloud2.

    Args:
        cloud: the message.
        by: the field that colours the points, `RED_GREEN_BLUE` or `MONO`; empty for "rgb", "intensity" or "z", the
            first that there is.
        most: the number of points that are sent at most; of larger clouds every second, third ... point.
        numbers: whether to send the points' places in the message and their values, too.
        bounds: of the values; None for the least and the greatest that there are.

    Returns:
        "count", "every" (one of how many points is sent), "fields" (those that can colour), "by", and "colour":

        - "rgb": for each point four bytes blue, green, red and one to ignore; "rgba": and its opacity
        - "value": for each point one byte, from the field's "least" (0) to its "most" (255)
        - "x", "y", "z": nothing; the page knows where the points are

        with the places as float32 x, y, z, and then the colours. Points without a place are left out. If "numbers" are
        sent, the index of each point in the message as uint32, and for "value" its float32, are before the colours.

    Raises:
        ShapeError: the sizes in the message contradict each other, or it has no x, y and z.
    """
    points = _points(cloud)
    fields = _offered(list(points.dtype.names or ()))
    every = -(-len(points) // most) or 1
    points = points[::every]
    places = np.empty((len(points), 3), np.float32)
    with np.errstate(all="ignore"):
        for index, name in enumerate("xyz"):
            places[:, index] = points[name]
    if by not in fields:
        by = next((name for name in _BEST if name in fields), "z")
    colours = _colours(by, points.dtype.names or (), lambda name: points[name]).copy()
    indices = np.arange(len(points), dtype=np.uint32) * np.uint32(every) if numbers else None
    with np.errstate(all="ignore"):
        whole = np.isfinite(places.sum())  # most clouds; to look at each point takes five times as long
    if not whole:
        there = np.isfinite(places).all(axis=1)
        places, colours = places[there], colours[there]
        indices = None if indices is None else indices[there]
    facts = {"kind": "cloud", "count": len(places), "every": every, "fields": fields}
    return _coloured(facts, places, colours, by, indices, bounds)


def point_cloud(
    cloud: Any, by: str = "", most: int = MOST_POINTS, numbers: bool = False, bounds: Bounds | None = None
) -> Shape:
    """Return a sensor_msgs/PointCloud; as `point_cloud2`. Its channels are fields."""
    every = -(-len(cloud.points) // most) or 1
    channels = {
        "intensity" if each.name == "intensities" else each.name: each.values  # as in rviz
        for each in cloud.channels
        if len(each.values) == len(cloud.points) and each.name not in _PLACE
    }
    fields = _offered([*_PLACE, *channels])
    if by not in fields:
        by = next((name for name in _BEST if name in fields), "z")

    def channel(name: str) -> NDArray[Any]:
        return np.asarray(channels[name], np.float32)[::every]

    with np.errstate(all="ignore"):
        places = np.array([(each.x, each.y, each.z) for each in cloud.points[::every]], np.float32).reshape(-1, 3)
        values = places[:, "xyz".index(by)] if by in _PLACE else _colours(by, [*channels], channel)
    there = np.isfinite(places).all(axis=1)
    facts = {"kind": "cloud", "count": int(there.sum()), "every": every, "fields": fields}
    indices = (np.flatnonzero(there) * every).astype(np.uint32) if numbers else None
    return _coloured(facts, places[there], values[there], by, indices, bounds)


def _points(cloud: Any) -> NDArray[Any]:
    width, height, step, row = cloud.width, cloud.height, cloud.point_step, cloud.row_step
    names = [field.name for field in cloud.fields]
    if not {"x", "y", "z"} <= {*names}:
        raise ShapeError(f"a cloud without x, y and z; it has {', '.join(names) or 'no fields'}"[:300])
    if row < width * step and len(cloud.data) >= width * height * step:
        row = width * step  # many publishers leave row_step at 0; rviz does not look at it
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


def _offered(fields: list[str]) -> list[str]:
    """Return what can colour a cloud that has some fields."""
    several = [RED_GREEN_BLUE] if {"r", "g", "b"} <= {*fields} else []
    return [*fields, *several, *([MONO] if {*_PACKED} & {*fields} else [])]


def _colours(by: str, fields: Sequence[str], column: Callable[[str], NDArray[Any]]) -> NDArray[Any]:
    """Return the values of a field, or packed colours that are made of one or three."""
    if by in fields:
        return column(by)
    if by == RED_GREEN_BLUE:
        levels = [255 * column(name).astype(np.float32) for name in "rgb"]
    else:
        numbers = _numbers(column(next(name for name in _PACKED if name in fields)))
        parts = [(numbers >> shift & 255).astype(np.float32) for shift in (16, 8, 0)]
        levels = [0.299 * parts[0] + 0.587 * parts[1] + 0.114 * parts[2]] * 3
    red, green, blue = (np.nan_to_num(level).clip(0, 255).round().astype(np.uint32) for level in levels)
    packed: NDArray[np.uint32] = red << 16 | green << 8 | blue
    return packed


def _numbers(values: NDArray[Any]) -> NDArray[np.uint32]:
    """Return the bits of values of four bytes as numbers."""
    order = ">" if values.dtype.byteorder == ">" else "<"
    return np.ascontiguousarray(values).view(f"{order}u4").astype("<u4", copy=False)


def _good(field: Any) -> bool:
    return field.datatype in _KINDS and bool(field.name)


def _coloured(
    facts: dict[str, Any],
    places: _Floats,
    values: NDArray[Any],
    by: str,
    indices: NDArray[np.uint32] | None,
    bounds: Bounds | None,
) -> Shape:
    facts["by"] = by
    blob = places.tobytes()
    if indices is not None:
        facts["numbers"] = True
        blob += indices.tobytes()
    if by in (*_PACKED, *_MADE) and values.dtype.itemsize == 4:
        return {**facts, "colour": "rgba" if by == "rgba" else "rgb"}, blob + _numbers(values).tobytes()
    if by in _PLACE:
        return {**facts, "colour": by}, blob
    with np.errstate(all="ignore"):
        floats = values.astype(np.float32)
        finite = floats[np.isfinite(floats)]
        least, most = bounds or ((float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0))
        facts |= {"least": least, "most": most}
        share = (floats - least) * np.float32(255 / (most - least) if most != least else 0)
        if len(finite) < len(floats):
            share = np.nan_to_num(share, nan=0.0, posinf=255.0, neginf=0.0)
        levels = share.clip(0, 255).astype(np.uint8)
    if indices is not None:
        blob += floats.tobytes()
    return {**facts, "colour": "value"}, blob + levels.tobytes()
