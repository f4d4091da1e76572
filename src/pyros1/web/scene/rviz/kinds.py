"""rviz's displays of topics: their options as those of the panel's displays (`page/lib/scene/displays.js`). Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pyros1.web.scene.rviz.values import colour, flag, given, mapping, number, text

Options = dict[str, Any]
_MOST_NAMESPACES = 200


def _points(values: Mapping[Any, Any]) -> Options:
    how = text(values, "Color Transformer")
    by = {"RGB8": "rgb", "RGBF32": "rgb", "AxisColor": text(values, "Axis").lower() or "z"}.get(how, "")
    if how == "Intensity":
        by = text(values, "Channel Name") or "intensity"
    style = text(values, "Style")
    return given(
        size=number(values, "Size (Pixels)", 1, 30) if style == "Points" else None,
        alpha=number(values, "Alpha", 0, 1),
        by=by or None,
        flat=True if how == "FlatColor" else None,
        tint=colour(values) if how == "FlatColor" else None,
    )


def _scan(values: Mapping[Any, Any]) -> Options:
    options = _points(values)
    options.pop("by", None)  # scans have their intensities, or the distance
    return options


def _arrows(values: Mapping[Any, Any]) -> Options:
    shape = values.get("Shape")
    inside = mapping(shape)
    name = text(inside, "Value") if inside else text(values, "Shape")
    return given(axes=name == "Axes" if name else None, tint=colour(values) or colour(inside))


def _uncertain(values: Mapping[Any, Any]) -> Options:
    return {**_arrows(values), **given(covariance=flag(mapping(values.get("Covariance")), "Value"))}


def _odometry(values: Mapping[Any, Any]) -> Options:
    return {**_uncertain(values), **given(keep=number(values, "Keep", 1, 1000))}


def _map(values: Mapping[Any, Any]) -> Options:
    scheme = text(values, "Color Scheme")
    return given(alpha=number(values, "Alpha", 0, 1), scheme=scheme if scheme in ("map", "costmap", "raw") else None)


def _tinted(values: Mapping[Any, Any]) -> Options:
    return given(tint=colour(values))


def _screw(values: Mapping[Any, Any]) -> Options:
    keys = ("Force Arrow Scale", "Linear Arrow Scale")
    found = [number(values, key, 0.001, 1000) for key in keys]
    return given(scale=next((scale for scale in found if scale is not None), None))


def _camera(values: Mapping[Any, Any]) -> Options:
    where = text(values, "Image Rendering")
    over = number(values, "Overlay Alpha", 0, 1)
    return given(
        behind="background" in where if where else None,
        alpha=0.0 if where == "background" else over,
        zoom=number(values, "Zoom Factor", 0.1, 20),
    )


def _depth(values: Mapping[Any, Any]) -> Options:
    return given(size=number(values, "Size (Pixels)", 1, 30), alpha=number(values, "Alpha", 0, 1))


def _namespaces(values: Mapping[Any, Any]) -> Options:
    shown = mapping(values.get("Namespaces"))
    return {
        f"ns:{name}": value
        for name, value in list(shown.items())[:_MOST_NAMESPACES]
        if isinstance(name, str) and isinstance(value, bool)
    }


def _effort(values: Mapping[Any, Any]) -> Options:
    return given(
        alpha=number(values, "Alpha", 0, 1),
        scale=number(values, "Scale", 0.01, 100),
        prefix=text(values, "TF Prefix") or None,
    )


def _handles(values: Mapping[Any, Any]) -> Options:
    return given(names=flag(values, "Show Descriptions"))


def _nothing(values: Mapping[Any, Any]) -> Options:
    return {}


class Kind(NamedTuple):
    """A display of a topic.

    Attributes:
        options: returns its options.
        topics: entries that name its topic; the first that is there counts.
        made: what is before the topic in its key (`page/lib/scene/kinds.js`).
        transport: whether it is of pictures, which may come compressed on another topic.
    """

    options: Callable[[Mapping[Any, Any]], Options] = _nothing
    topics: tuple[str, ...] = ("Topic",)
    made: str = ""
    transport: bool = False


_PICTURES = ("Image Topic", "Topic")
_MARKERS = ("Marker Topic", "Topic")
KINDS: Mapping[str, Kind] = {
    "AccelStamped": Kind(_screw),
    "Camera": Kind(_camera, _PICTURES, "camera:", transport=True),
    "DepthCloud": Kind(_depth, ("Depth Map Topic",), "depth:"),
    "Effort": Kind(_effort),
    "FluidPressure": Kind(),
    "GridCells": Kind(_tinted),
    "Illuminance": Kind(),
    "Image": Kind(_nothing, _PICTURES, transport=True),
    "Imu": Kind(_tinted),
    "InteractiveMarkers": Kind(_handles, ("Update Topic",)),
    "LaserScan": Kind(_scan),
    "Map": Kind(_map),
    "Marker": Kind(_namespaces, _MARKERS),
    "MarkerArray": Kind(_namespaces, _MARKERS),
    "Odometry": Kind(_odometry),
    "Path": Kind(_tinted),
    "PointCloud": Kind(_points),
    "PointCloud2": Kind(_points),
    "PointStamped": Kind(_tinted),
    "Polygon": Kind(_tinted),
    "Pose": Kind(_arrows),
    "PoseArray": Kind(_arrows),
    "PoseWithCovariance": Kind(_uncertain),
    "Range": Kind(_tinted),
    "RelativeHumidity": Kind(),
    "Temperature": Kind(),
    "TwistStamped": Kind(_screw),
    "Wrench": Kind(_screw),
    "WrenchStamped": Kind(_screw),
}
"""rviz's displays of topics, by the last part of their class."""
