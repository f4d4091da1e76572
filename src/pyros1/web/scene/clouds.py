"""Point clouds as blocks of numbers that a page passes directly to its graphics card. Pure except for numpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.web.scene.shape import Shape, ShapeError

MAX_POINTS = 1_500_000
"""Maximum number of points of a cloud that are sent."""
_DATATYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""numpy's names for the types of sensor_msgs/PointField."""
_PACKED = ("rgb", "rgba")
_XYZ = ("x", "y", "z")
RED_GREEN_BLUE = "r, g, b"
"""The choice to colour points by their three fields of these names, from 0 to 1: rviz's RGBF32."""
MONO = "rgb as grey"
"""The choice to colour points by the brightness of their "rgb" or "rgba": rviz's MONO8."""
_MADE = (RED_GREEN_BLUE, MONO)
_BEST = (*_PACKED, RED_GREEN_BLUE, "intensity")
Bounds = tuple[float, float]
"""The minimum and maximum of the colour scale."""
_Floats = NDArray[np.float32]


def point_cloud2(
    cloud: Any, by: str = "", max_points: int = MAX_POINTS, numbers: bool = False, bounds: Bounds | None = None
) -> Shape:
    """Return a sensor_msgs/PointCloud2.

    Args:
        cloud: the message.
        by: the field that colours the points, `RED_GREEN_BLUE` or `MONO`; empty for the first existing one of "rgb",
            "intensity" and "z".
        max_points: maximum number of points that are sent; of larger clouds every second, third ... point is sent.
        numbers: whether to send the points' indices in the message and their values as well.
        bounds: bounds of the values; None for their minimum and maximum.

    Returns:
        "count", "every" (one in this many points is sent), "fields" (those that can colour), "by", and "colour":

        - "rgb": four bytes per point: blue, green, red, unused; "rgba": the last is the opacity
        - "value": one byte per point, from the field's "least" (0) to its "most" (255)
        - "x", "y", "z": nothing; the page knows the positions

        with the positions as float32 x, y, z, followed by the colours. Points without a position are left out. With
        "numbers", the index of each point in the message as uint32, and for "value" its float32, precede the colours.

    Raises:
        ShapeError: the sizes in the message are inconsistent, or it lacks x, y or z.
    """
    points = _points(cloud)
    fields = _offered(list(points.dtype.names or ()))
    stride = -(-len(points) // max_points) or 1
    points = points[::stride]
    positions = np.empty((len(points), 3), np.float32)
    with np.errstate(all="ignore"):
        for index, name in enumerate("xyz"):
            positions[:, index] = points[name]
    if by not in fields:
        by = next((name for name in _BEST if name in fields), "z")
    colours = _colours(by, points.dtype.names or (), lambda name: points[name]).copy()
    indices = np.arange(len(points), dtype=np.uint32) * np.uint32(stride) if numbers else None
    with np.errstate(all="ignore"):
        all_finite = np.isfinite(positions.sum())  # most clouds; checking each point takes five times as long
    if not all_finite:
        valid = np.isfinite(positions).all(axis=1)
        positions, colours = positions[valid], colours[valid]
        indices = None if indices is None else indices[valid]
    facts = {"kind": "cloud", "count": len(positions), "every": stride, "fields": fields}
    return _coloured(facts, positions, colours, by, indices, bounds)


def point_cloud(
    cloud: Any, by: str = "", max_points: int = MAX_POINTS, numbers: bool = False, bounds: Bounds | None = None
) -> Shape:
    """Return a sensor_msgs/PointCloud; like `point_cloud2`. Its channels are fields."""
    stride = -(-len(cloud.points) // max_points) or 1
    channels = {
        "intensity" if each.name == "intensities" else each.name: each.values  # as in rviz
        for each in cloud.channels
        if len(each.values) == len(cloud.points) and each.name not in _XYZ
    }
    fields = _offered([*_XYZ, *channels])
    if by not in fields:
        by = next((name for name in _BEST if name in fields), "z")

    def channel(name: str) -> NDArray[Any]:
        return np.asarray(channels[name], np.float32)[::stride]

    with np.errstate(all="ignore"):
        positions = np.array([(each.x, each.y, each.z) for each in cloud.points[::stride]], np.float32).reshape(-1, 3)
        values = positions[:, "xyz".index(by)] if by in _XYZ else _colours(by, [*channels], channel)
    valid = np.isfinite(positions).all(axis=1)
    facts = {"kind": "cloud", "count": int(valid.sum()), "every": stride, "fields": fields}
    indices = (np.flatnonzero(valid) * stride).astype(np.uint32) if numbers else None
    return _coloured(facts, positions[valid], values[valid], by, indices, bounds)


def _points(cloud: Any) -> NDArray[Any]:
    width, height, step, row = cloud.width, cloud.height, cloud.point_step, cloud.row_step
    names = [field.name for field in cloud.fields]
    if not {"x", "y", "z"} <= {*names}:
        raise ShapeError(f"a cloud without x, y and z; it has {', '.join(names) or 'no fields'}"[:300])
    if row < width * step and len(cloud.data) >= width * height * step:
        row = width * step  # many publishers leave row_step at 0; rviz ignores it
    if step < 1 or row < width * step or len(cloud.data) < (row * (height - 1) + width * step if height else 0):
        raise ShapeError(f"{width} x {height} points of {step} bytes do not fit into {len(cloud.data)} bytes")
    order = ">" if cloud.is_bigendian else "<"
    known = {
        field.name: (order + _DATATYPES[field.datatype], field.offset) for field in cloud.fields if _is_usable(field)
    }
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
    """Return the choices to colour a cloud with these fields."""
    several = [RED_GREEN_BLUE] if {"r", "g", "b"} <= {*fields} else []
    return [*fields, *several, *([MONO] if {*_PACKED} & {*fields} else [])]


def _colours(by: str, fields: Sequence[str], column: Callable[[str], NDArray[Any]]) -> NDArray[Any]:
    """Return the values of a field, or packed colours from one or three fields."""
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
    """Return the bits of four-byte values as integers."""
    order = ">" if values.dtype.byteorder == ">" else "<"
    return np.ascontiguousarray(values).view(f"{order}u4").astype("<u4", copy=False)


def _is_usable(field: Any) -> bool:
    return field.datatype in _DATATYPES and bool(field.name)


def _coloured(
    facts: dict[str, Any],
    positions: _Floats,
    values: NDArray[Any],
    by: str,
    indices: NDArray[np.uint32] | None,
    bounds: Bounds | None,
) -> Shape:
    facts["by"] = by
    blob = positions.tobytes()
    if indices is not None:
        facts["numbers"] = True
        blob += indices.tobytes()
    if by in (*_PACKED, *_MADE) and values.dtype.itemsize == 4:
        return {**facts, "colour": "rgba" if by == "rgba" else "rgb"}, blob + _numbers(values).tobytes()
    if by in _XYZ:
        return {**facts, "colour": by}, blob
    with np.errstate(all="ignore"):
        floats = values.astype(np.float32)
        finite = floats[np.isfinite(floats)]
        low, high = bounds or ((float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0))
        facts |= {"least": low, "most": high}
        share = (floats - low) * np.float32(255 / (high - low) if high != low else 0)
        if len(finite) < len(floats):
            share = np.nan_to_num(share, nan=0.0, posinf=255.0, neginf=0.0)
        levels = share.clip(0, 255).astype(np.uint8)
    if indices is not None:
        blob += floats.tobytes()
    return {**facts, "colour": "value"}, blob + levels.tobytes()
