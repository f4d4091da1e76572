"""Converts point clouds to blocks of numbers that a page can pass directly to its graphics card (no I/O)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.web.scene.shape import Shape, ShapeError

MAX_POINTS = 1_500_000
"""Maximum number of points sent per cloud."""
_NUMPY_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""Datatype in a sensor_msgs/PointField -> numpy's name for it."""
_PACKED_COLOUR_FIELDS = ("rgb", "rgba")
_XYZ = ("x", "y", "z")
RED_GREEN_BLUE = "r, g, b"
"""Colour points by their fields r, g and b, with values from 0 to 1 (RGBF32 in rviz)."""
MONO = "rgb as grey"
"""Colour points grey, with the brightness of their "rgb" or "rgba" (MONO8 in rviz)."""
_COMPUTED_COLOURS = (RED_GREEN_BLUE, MONO)
_PREFERRED_COLOUR_FIELDS = (*_PACKED_COLOUR_FIELDS, RED_GREEN_BLUE, "intensity")
Bounds = tuple[float, float]
"""The values at the lower and the upper end of the colour scale."""
_Floats = NDArray[np.float32]


def point_cloud2(
    cloud: Any,
    colour_field: str = "",
    max_points: int = MAX_POINTS,
    with_indices: bool = False,
    bounds: Bounds | None = None,
) -> Shape:
    """Return the shape for a sensor_msgs/PointCloud2.

    Args:
        cloud: the message.
        colour_field: what colours the points: the name of a field, `RED_GREEN_BLUE` or `MONO`; if the cloud lacks it,
            the first available of "rgb", "rgba", `RED_GREEN_BLUE`, "intensity" and "z".
        max_points: maximum number of points sent; larger clouds are thinned to every n-th point.
        with_indices: whether to also send the points' indices in the message, and their values.
        bounds: the values at the two ends of the colour scale; None for the points' minimum and maximum.

    Returns:
        A description, and a block of numbers. The description contains "count", "every" (one in this many points is
        sent), "fields" (the possible values of `colour_field`), "by" (the value that was used), and "colour":

        - "rgb": four bytes per point: blue, green, red, unused; "rgba": the same, but the last byte is alpha
        - "value": one byte per point: 0 for the value "least", 255 for "most"
        - "x", "y", "z": no data, since the page knows the positions

        The block contains the positions as float32 x, y, z, and then the colours. Points without a position are
        omitted. If the description contains "numbers", the points' indices as uint32 precede the colours, and for
        "value" also their values as float32.

    Raises:
        ShapeError: the sizes in the message are inconsistent, or the cloud lacks x, y or z.
    """
    points = _read_points(cloud)
    fields = _colour_choices(list(points.dtype.names or ()))
    stride = -(-len(points) // max_points) or 1
    points = points[::stride]
    positions = np.empty((len(points), 3), np.float32)
    with np.errstate(all="ignore"):
        for index, name in enumerate("xyz"):
            positions[:, index] = points[name]
    if colour_field not in fields:
        colour_field = next((name for name in _PREFERRED_COLOUR_FIELDS if name in fields), "z")
    colours = _colour_values(colour_field, points.dtype.names or (), lambda name: points[name]).copy()
    indices = np.arange(len(points), dtype=np.uint32) * np.uint32(stride) if with_indices else None
    with np.errstate(all="ignore"):
        all_finite = np.isfinite(positions.sum())  # true of most clouds; checking each point takes five times as long
    if not all_finite:
        valid = np.isfinite(positions).all(axis=1)
        positions, colours = positions[valid], colours[valid]
        indices = None if indices is None else indices[valid]
    description = {"kind": "cloud", "count": len(positions), "every": stride, "fields": fields}
    return _add_colours(description, positions, colours, colour_field, indices, bounds)


def point_cloud(
    cloud: Any,
    colour_field: str = "",
    max_points: int = MAX_POINTS,
    with_indices: bool = False,
    bounds: Bounds | None = None,
) -> Shape:
    """Return the shape for a sensor_msgs/PointCloud; see `point_cloud2`. The cloud's channels count as fields."""
    stride = -(-len(cloud.points) // max_points) or 1
    channels = {
        "intensity" if cloud_channel.name == "intensities" else cloud_channel.name: cloud_channel.values  # as in rviz
        for cloud_channel in cloud.channels
        if len(cloud_channel.values) == len(cloud.points) and cloud_channel.name not in _XYZ
    }
    fields = _colour_choices([*_XYZ, *channels])
    if colour_field not in fields:
        colour_field = next((name for name in _PREFERRED_COLOUR_FIELDS if name in fields), "z")

    def channel(name: str) -> NDArray[Any]:
        return np.asarray(channels[name], np.float32)[::stride]

    with np.errstate(all="ignore"):
        positions = np.array([(point.x, point.y, point.z) for point in cloud.points[::stride]], np.float32).reshape(
            -1, 3
        )
        if colour_field in _XYZ:
            values = positions[:, "xyz".index(colour_field)]
        else:
            values = _colour_values(colour_field, [*channels], channel)
    valid = np.isfinite(positions).all(axis=1)
    description = {"kind": "cloud", "count": int(valid.sum()), "every": stride, "fields": fields}
    indices = (np.flatnonzero(valid) * stride).astype(np.uint32) if with_indices else None
    return _add_colours(description, positions[valid], values[valid], colour_field, indices, bounds)


def _read_points(cloud: Any) -> NDArray[Any]:
    width, height, step, row_step = cloud.width, cloud.height, cloud.point_step, cloud.row_step
    names = [field.name for field in cloud.fields]
    if not {"x", "y", "z"} <= {*names}:
        raise ShapeError(f"the cloud lacks x, y or z; it has {', '.join(names) or 'no fields'}"[:300])
    if row_step < width * step and len(cloud.data) >= width * height * step:
        row_step = width * step  # many publishers leave row_step at 0, since rviz ignores it
    if (
        step < 1
        or row_step < width * step
        or len(cloud.data) < (row_step * (height - 1) + width * step if height else 0)
    ):
        raise ShapeError(f"{width} x {height} points of {step} bytes do not fit into {len(cloud.data)} bytes")
    order = ">" if cloud.is_bigendian else "<"
    fields = {
        field.name: (order + _NUMPY_TYPES[field.datatype], field.offset) for field in cloud.fields if _is_usable(field)
    }
    if any(offset + np.dtype(dtype).itemsize > step for dtype, offset in fields.values()):
        raise ShapeError(f"a field extends beyond its point, which has {step} bytes")
    if not {"x", "y", "z"} <= fields.keys():
        raise ShapeError("x, y and z of the points are not of a known numeric type")
    if not width or not height:
        return np.empty(0, [(name, dtype) for name, (dtype, _) in fields.items()])
    layout = np.dtype(
        {
            "names": [*fields],
            "formats": [dtype for dtype, _ in fields.values()],
            "offsets": [offset for _, offset in fields.values()],
            "itemsize": step,
        }
    )
    if height == 1 or row_step == width * step:
        return np.frombuffer(cloud.data, layout, width * height)
    rows: NDArray[Any] = np.ndarray((height, width), layout, cloud.data, strides=(row_step, step))
    return rows.reshape(-1)


def _colour_choices(fields: list[str]) -> list[str]:
    """Return the possible values of `colour_field` for a cloud with these fields."""
    combined = [RED_GREEN_BLUE] if {"r", "g", "b"} <= {*fields} else []
    return [*fields, *combined, *([MONO] if {*_PACKED_COLOUR_FIELDS} & {*fields} else [])]


def _colour_values(colour_field: str, fields: Sequence[str], column: Callable[[str], NDArray[Any]]) -> NDArray[Any]:
    """Return the values of a field; for `RED_GREEN_BLUE` and `MONO`, packed colours computed from other fields."""
    if colour_field in fields:
        return column(colour_field)
    if colour_field == RED_GREEN_BLUE:
        levels = [255 * column(name).astype(np.float32) for name in "rgb"]
    else:
        numbers = _as_integers(column(next(name for name in _PACKED_COLOUR_FIELDS if name in fields)))
        parts = [(numbers >> shift & 255).astype(np.float32) for shift in (16, 8, 0)]
        levels = [0.299 * parts[0] + 0.587 * parts[1] + 0.114 * parts[2]] * 3
    red, green, blue = (np.nan_to_num(level).clip(0, 255).round().astype(np.uint32) for level in levels)
    packed: NDArray[np.uint32] = red << 16 | green << 8 | blue
    return packed


def _as_integers(values: NDArray[Any]) -> NDArray[np.uint32]:
    """Reinterpret the bits of four-byte values as integers."""
    order = ">" if values.dtype.byteorder == ">" else "<"
    return np.ascontiguousarray(values).view(f"{order}u4").astype("<u4", copy=False)


def _is_usable(field: Any) -> bool:
    return field.datatype in _NUMPY_TYPES and bool(field.name)


def _add_colours(
    description: dict[str, Any],
    positions: _Floats,
    values: NDArray[Any],
    colour_field: str,
    indices: NDArray[np.uint32] | None,
    bounds: Bounds | None,
) -> Shape:
    description["by"] = colour_field
    blob = positions.tobytes()
    if indices is not None:
        description["numbers"] = True
        blob += indices.tobytes()
    if colour_field in (*_PACKED_COLOUR_FIELDS, *_COMPUTED_COLOURS) and values.dtype.itemsize == 4:
        return {**description, "colour": "rgba" if colour_field == "rgba" else "rgb"}, blob + _as_integers(
            values
        ).tobytes()
    if colour_field in _XYZ:
        return {**description, "colour": colour_field}, blob
    with np.errstate(all="ignore"):
        floats = values.astype(np.float32)
        finite = floats[np.isfinite(floats)]
        low, high = bounds or ((float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0))
        description |= {"least": low, "most": high}
        scaled = (floats - low) * np.float32(255 / (high - low) if high != low else 0)
        if len(finite) < len(floats):
            scaled = np.nan_to_num(scaled, nan=0.0, posinf=255.0, neginf=0.0)
        levels = scaled.clip(0, 255).astype(np.uint8)
    if indices is not None:
        blob += floats.tobytes()
    return {**description, "colour": "value"}, blob + levels.tobytes()
