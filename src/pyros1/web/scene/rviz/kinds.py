"""Converts options of rviz's topic displays to those of the panel (`page/lib/scene/displays.js`) (pure)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pyros1.web.scene.clouds import MONO, RED_GREEN_BLUE
from pyros1.web.scene.rviz.values import chosen, colour, flag, given, mapping, number, point, text

Options = dict[str, Any]
_MAX_NAMESPACES = 200
_MAX_KEPT = 1000


_STYLES = {"Points": "pixels", "Squares": "squares", "Flat Squares": "squares", "Spheres": "spheres", "Boxes": "boxes"}
_COLOURS = {
    "Intensity": "intensity",
    "AxisColor": "axis",
    "FlatColor": "flat",
    "RGB8": "rgb",
    "RGBF32": RED_GREEN_BLUE,
    "MONO8": MONO,
}
_MAX_BOUND = 1e9


def _point_options(values: Mapping[Any, Any]) -> Options:
    """Return the options of displays that draw points."""
    transformer = chosen(values, _COLOURS, "Color Transformer")
    axes = mapping(values.get("Autocompute Value Bounds"))
    by_axis = (
        flag(axes, "Value"),
        *(number(axes, key, -_MAX_BOUND, _MAX_BOUND) for key in ("Min Value", "Max Value")),
    )
    by_value = (
        flag(values, "Autocompute Intensity Bounds"),
        *(number(values, key, -_MAX_BOUND, _MAX_BOUND) for key in ("Min Intensity", "Max Intensity")),
    )
    auto, low, high = by_axis if transformer == "axis" else by_value
    fixed = auto is False
    axis = chosen(values, {"X": "x", "Y": "y", "Z": "z"}, "Axis")
    channel = text(values, "Channel Name")
    tint = colour(values)
    in_fixed_frame = flag(values, "Use Fixed Frame")
    ramp = given(
        rainbow=flag(values, "Use rainbow"),
        inverted=flag(values, "Invert Rainbow"),
        first=colour(values, "Min Color"),
        last=colour(values, "Max Color"),
    )
    return given(
        style=chosen(values, _STYLES, "Style"),
        size=number(values, "Size (Pixels)", 1, 30),
        metres=number(values, "Size (m)", 0.0001, 100),
        alpha=number(values, "Alpha", 0, 1),
        by={"axis": axis or "z", "intensity": channel or "intensity", "flat": None}.get(transformer, transformer),
        flat=True if transformer == "flat" else None,
        tint=tint if transformer == "flat" else None,
        auto=False if fixed else None,
        low=low if fixed else None,
        high=high if fixed else None,
        **({} if transformer == "axis" else ramp),  # the ramp is for intensities
        local=None if in_fixed_frame is None else not in_fixed_frame,
        decay=number(values, "Decay Time", 0, 3600),
    )


_SHAPES = {"Arrow": "arrow", "Axes": "axes", "Arrow (3D)": "arrow", "Arrow (Flat)": "lines"}


def _arrows(values: Mapping[Any, Any]) -> Options:
    shape_properties = mapping(values.get("Shape"))
    shape = chosen(shape_properties, _SHAPES, "Value") if shape_properties else chosen(values, _SHAPES, "Shape")
    properties = shape_properties or values
    return given(
        axes=None if shape is None else shape == "axes",
        tint=colour(properties),
        alpha=number(properties, "Alpha", 0, 1),
        shaft=number(properties, "Shaft Length", 0, 1000),
        shaftWidth=number(properties, "Shaft Radius", 0, 1000),
        head=number(properties, "Head Length", 0, 1000),
        headWidth=number(properties, "Head Radius", 0, 1000),
        axesLength=number(properties, "Axes Length", 0, 1000),
        axesWidth=number(properties, "Axes Radius", 0, 1000),
    )


def _arrow_array(values: Mapping[Any, Any]) -> Options:
    shape = chosen(values, _SHAPES, "Shape")
    lines = None if shape is None else shape == "lines"
    return {**_arrows(values), **given(lines=lines, arrow=number(values, "Arrow Length", 0, 1000))}


def _covariance(values: Mapping[Any, Any]) -> Options:
    covariance = mapping(values.get("Covariance"))
    place, turn = mapping(covariance.get("Position")), mapping(covariance.get("Orientation"))
    return {
        **_arrows(values),
        **given(
            covariance=flag(covariance, "Value"),
            place=flag(place, "Value"),
            placeTint=colour(place),
            placeAlpha=number(place, "Alpha", 0, 1),
            placeScale=number(place, "Scale", 0, 1000),
            turn=flag(turn, "Value"),
            turnTint=colour(turn),
            turnAlpha=number(turn, "Alpha", 0, 1),
        ),
    }


def _odometry(values: Mapping[Any, Any]) -> Options:
    keep = number(values, "Keep", 0, _MAX_KEPT)
    return {
        **_covariance(values),
        **given(
            keep=_MAX_KEPT if keep == 0 else keep,  # 0 means all
            step=number(values, "Position Tolerance", 0, 1000),
            angle=number(values, "Angle Tolerance", 0, 7),
        ),
    }


def _path(values: Mapping[Any, Any]) -> Options:
    offset = values.get("Offset")
    return {
        **_with_history(values),
        **given(
            line=chosen(values, {"Lines": "pixel", "Billboards": "metres"}, "Line Style"),
            width=number(values, "Line Width", 0, 1000),
            poses=chosen(values, {"None": "none", "Axes": "axes", "Arrows": "arrows"}, "Pose Style"),
            poseTint=colour(values, "Pose Color"),
            shaft=number(values, "Shaft Length", 0, 1000),
            shaftWidth=number(values, "Shaft Diameter", 0, 1000),
            head=number(values, "Head Length", 0, 1000),
            headWidth=number(values, "Head Diameter", 0, 1000),
            axesLength=number(values, "Length", 0, 1000),
            axesWidth=number(values, "Radius", 0, 1000),
        ),
        **(dict(zip("xyz", point(offset), strict=True)) if offset else {}),
    }


def _map(values: Mapping[Any, Any]) -> Options:
    return given(
        alpha=number(values, "Alpha", 0, 1),
        scheme=chosen(values, {name: name for name in ("map", "costmap", "raw")}, "Color Scheme"),
        behind=flag(values, "Draw Behind"),
    )


def _colour_and_alpha(values: Mapping[Any, Any]) -> Options:
    return given(tint=colour(values), alpha=number(values, "Alpha", 0, 1))


def _box(values: Mapping[Any, Any]) -> Options:
    return given(tint=colour(values))


def _with_history(values: Mapping[Any, Any]) -> Options:
    lengths = [number(values, key, 1, _MAX_KEPT) for key in ("Buffer Length", "History Length")]
    keep = next((length for length in lengths if length is not None), None)
    return {**_colour_and_alpha(values), **given(keep=keep)}


def _point_stamped(values: Mapping[Any, Any]) -> Options:
    return {**_with_history(values), **given(radius=number(values, "Radius", 0, 1000))}


def _twist_and_wrench(values: Mapping[Any, Any]) -> Options:
    linear, angular = ("Force", "Torque") if "Force Arrow Scale" in values else ("Linear", "Angular")
    return {
        **_with_history(values),
        **given(
            scale=number(values, f"{linear} Arrow Scale", 0.001, 1000),
            scaleAround=number(values, f"{angular} Arrow Scale", 0.001, 1000),
            tint=colour(values, f"{linear} Color"),
            tintAround=colour(values, f"{angular} Color"),
            width=number(values, "Arrow Width", 0, 1000),
            small=flag(values, "Hide Small Values"),
        ),
    }


def _camera(values: Mapping[Any, Any]) -> Options:
    rendering = ("background", "overlay", "background and overlay")
    where = chosen(values, {name: name for name in rendering}, "Image Rendering")
    overlay_alpha = number(values, "Overlay Alpha", 0, 1)
    return given(
        behind="background" in where if where else None,
        alpha=0.0 if where == "background" else overlay_alpha,
        zoom=number(values, "Zoom Factor", 0.1, 20),
    )


def _namespaces(values: Mapping[Any, Any]) -> Options:
    namespaces = mapping(values.get("Namespaces"))
    return {
        f"ns:{name}": value
        for name, value in list(namespaces.items())[:_MAX_NAMESPACES]
        if isinstance(name, str) and isinstance(value, bool)
    }


def _effort(values: Mapping[Any, Any]) -> Options:
    return given(
        alpha=number(values, "Alpha", 0, 1),
        scale=number(values, "Scale", 0.01, 100),
        prefix=text(values, "TF Prefix") or None,
    )


def _interactive_markers(values: Mapping[Any, Any]) -> Options:
    return given(names=flag(values, "Show Descriptions"))


def _no_options(values: Mapping[Any, Any]) -> Options:
    return {}


class Kind(NamedTuple):
    """A class of rviz's topic displays.

    Attributes:
        options: returns the panel's options for a display.
        topics: names of the properties that may contain the topic; the first existing one is used.
        prefix: prefix of the topic in the display's key (`page/lib/scene/display_kinds.js`).
        transport: whether it displays images, which may be available compressed on another topic.
    """

    options: Callable[[Mapping[Any, Any]], Options] = _no_options
    topics: tuple[str, ...] = ("Topic",)
    prefix: str = ""
    transport: bool = False


_PICTURES = ("Image Topic", "Topic")
_MARKERS = ("Marker Topic", "Topic")
KINDS: Mapping[str, Kind] = {
    "AccelStamped": Kind(_twist_and_wrench),
    "Camera": Kind(_camera, _PICTURES, "camera:", transport=True),
    "DepthCloud": Kind(_point_options, ("Depth Map Topic",), "depth:"),
    "Effort": Kind(_effort),
    "FluidPressure": Kind(),
    "GridCells": Kind(_colour_and_alpha),
    "Illuminance": Kind(),
    "Image": Kind(_no_options, _PICTURES, transport=True),
    "Imu": Kind(_box),
    "InteractiveMarkers": Kind(_interactive_markers, ("Update Topic",)),
    "LaserScan": Kind(_point_options),
    "Map": Kind(_map),
    "Marker": Kind(_namespaces, _MARKERS),
    "MarkerArray": Kind(_namespaces, _MARKERS),
    "Odometry": Kind(_odometry),
    "Path": Kind(_path),
    "PointCloud": Kind(_point_options),
    "PointCloud2": Kind(_point_options),
    "PointStamped": Kind(_point_stamped),
    "Polygon": Kind(_colour_and_alpha),
    "Pose": Kind(_arrows),
    "PoseArray": Kind(_arrow_array),
    "PoseWithCovariance": Kind(_covariance),
    "Range": Kind(_with_history),
    "RelativeHumidity": Kind(),
    "Temperature": Kind(),
    "TwistStamped": Kind(_twist_and_wrench),
    "Wrench": Kind(_twist_and_wrench),
    "WrenchStamped": Kind(_twist_and_wrench),
}
"""rviz's topic displays, by the last part of their class."""
