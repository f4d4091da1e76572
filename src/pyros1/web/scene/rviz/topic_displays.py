"""Converts the properties of rviz's topic displays to options of the panel's displays (no I/O).

The panel's options are defined in `page/lib/scene/displays.js`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pyros1.web.scene.clouds import MONO, RED_GREEN_BLUE
from pyros1.web.scene.rviz.values import (
    boolean,
    colour,
    drop_none,
    mapped_choice,
    mapping_or_empty,
    number,
    point,
    text,
)

Options = dict[str, Any]
_MAX_NAMESPACES = 200
_MAX_KEPT_MESSAGES = 1000


_STYLES = {"Points": "pixels", "Squares": "squares", "Flat Squares": "squares", "Spheres": "spheres", "Boxes": "boxes"}
_COLOUR_MODES = {
    "Intensity": "intensity",
    "AxisColor": "axis",
    "FlatColor": "flat",
    "RGB8": "rgb",
    "RGBF32": RED_GREEN_BLUE,
    "MONO8": MONO,
}
_MAX_BOUND = 1e9


def _point_options(values: Mapping[Any, Any]) -> Options:
    """Return the options for displays that draw points."""
    transformer = mapped_choice(values, _COLOUR_MODES, "Color Transformer")
    axes = mapping_or_empty(values.get("Autocompute Value Bounds"))
    by_axis = (
        boolean(axes, "Value"),
        *(number(axes, key, -_MAX_BOUND, _MAX_BOUND) for key in ("Min Value", "Max Value")),
    )
    by_value = (
        boolean(values, "Autocompute Intensity Bounds"),
        *(number(values, key, -_MAX_BOUND, _MAX_BOUND) for key in ("Min Intensity", "Max Intensity")),
    )
    auto, low, high = by_axis if transformer == "axis" else by_value
    has_fixed_bounds = auto is False
    axis = mapped_choice(values, {"X": "x", "Y": "y", "Z": "z"}, "Axis")
    channel = text(values, "Channel Name")
    tint = colour(values)
    in_fixed_frame = boolean(values, "Use Fixed Frame")
    ramp = drop_none(
        rainbow=boolean(values, "Use rainbow"),
        inverted=boolean(values, "Invert Rainbow"),
        first=colour(values, "Min Color"),
        last=colour(values, "Max Color"),
    )
    return drop_none(
        style=mapped_choice(values, _STYLES, "Style"),
        size=number(values, "Size (Pixels)", 1, 30),
        metres=number(values, "Size (m)", 0.0001, 100),
        alpha=number(values, "Alpha", 0, 1),
        by={"axis": axis or "z", "intensity": channel or "intensity", "flat": None}.get(transformer, transformer),
        flat=True if transformer == "flat" else None,
        tint=tint if transformer == "flat" else None,
        auto=False if has_fixed_bounds else None,
        low=low if has_fixed_bounds else None,
        high=high if has_fixed_bounds else None,
        **({} if transformer == "axis" else ramp),  # the colour ramp is only for intensities
        local=None if in_fixed_frame is None else not in_fixed_frame,
        decay=number(values, "Decay Time", 0, 3600),
    )


_SHAPES = {"Arrow": "arrow", "Axes": "axes", "Arrow (3D)": "arrow", "Arrow (Flat)": "lines"}


def _arrow_options(values: Mapping[Any, Any]) -> Options:
    shape_properties = mapping_or_empty(values.get("Shape"))
    shape = (
        mapped_choice(shape_properties, _SHAPES, "Value")
        if shape_properties
        else mapped_choice(values, _SHAPES, "Shape")
    )
    properties = shape_properties or values
    return drop_none(
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


def _arrow_array_options(values: Mapping[Any, Any]) -> Options:
    shape = mapped_choice(values, _SHAPES, "Shape")
    lines = None if shape is None else shape == "lines"
    return {**_arrow_options(values), **drop_none(lines=lines, arrow=number(values, "Arrow Length", 0, 1000))}


def _covariance_options(values: Mapping[Any, Any]) -> Options:
    covariance = mapping_or_empty(values.get("Covariance"))
    position = mapping_or_empty(covariance.get("Position"))
    orientation = mapping_or_empty(covariance.get("Orientation"))
    return {
        **_arrow_options(values),
        **drop_none(
            covariance=boolean(covariance, "Value"),
            place=boolean(position, "Value"),
            placeTint=colour(position),
            placeAlpha=number(position, "Alpha", 0, 1),
            placeScale=number(position, "Scale", 0, 1000),
            turn=boolean(orientation, "Value"),
            turnTint=colour(orientation),
            turnAlpha=number(orientation, "Alpha", 0, 1),
        ),
    }


def _odometry_options(values: Mapping[Any, Any]) -> Options:
    keep = number(values, "Keep", 0, _MAX_KEPT_MESSAGES)
    return {
        **_covariance_options(values),
        **drop_none(
            keep=_MAX_KEPT_MESSAGES if keep == 0 else keep,  # 0 means that all messages are kept
            step=number(values, "Position Tolerance", 0, 1000),
            angle=number(values, "Angle Tolerance", 0, 7),
        ),
    }


def _path_options(values: Mapping[Any, Any]) -> Options:
    offset = values.get("Offset")
    return {
        **_history_options(values),
        **drop_none(
            line=mapped_choice(values, {"Lines": "pixel", "Billboards": "metres"}, "Line Style"),
            width=number(values, "Line Width", 0, 1000),
            poses=mapped_choice(values, {"None": "none", "Axes": "axes", "Arrows": "arrows"}, "Pose Style"),
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


def _map_options(values: Mapping[Any, Any]) -> Options:
    return drop_none(
        alpha=number(values, "Alpha", 0, 1),
        scheme=mapped_choice(values, {name: name for name in ("map", "costmap", "raw")}, "Color Scheme"),
        behind=boolean(values, "Draw Behind"),
    )


def _colour_options(values: Mapping[Any, Any]) -> Options:
    return drop_none(tint=colour(values), alpha=number(values, "Alpha", 0, 1))


def _box_options(values: Mapping[Any, Any]) -> Options:
    return drop_none(tint=colour(values))


def _history_options(values: Mapping[Any, Any]) -> Options:
    lengths = [number(values, key, 1, _MAX_KEPT_MESSAGES) for key in ("Buffer Length", "History Length")]
    keep = next((length for length in lengths if length is not None), None)
    return {**_colour_options(values), **drop_none(keep=keep)}


def _point_stamped_options(values: Mapping[Any, Any]) -> Options:
    return {**_history_options(values), **drop_none(radius=number(values, "Radius", 0, 1000))}


def _arrow_pair_options(values: Mapping[Any, Any]) -> Options:
    linear, angular = ("Force", "Torque") if "Force Arrow Scale" in values else ("Linear", "Angular")
    return {
        **_history_options(values),
        **drop_none(
            scale=number(values, f"{linear} Arrow Scale", 0.001, 1000),
            scaleAround=number(values, f"{angular} Arrow Scale", 0.001, 1000),
            tint=colour(values, f"{linear} Color"),
            tintAround=colour(values, f"{angular} Color"),
            width=number(values, "Arrow Width", 0, 1000),
            small=boolean(values, "Hide Small Values"),
        ),
    }


def _camera_options(values: Mapping[Any, Any]) -> Options:
    rendering = ("background", "overlay", "background and overlay")
    image_rendering = mapped_choice(values, {name: name for name in rendering}, "Image Rendering")
    overlay_alpha = number(values, "Overlay Alpha", 0, 1)
    return drop_none(
        behind="background" in image_rendering if image_rendering else None,
        alpha=0.0 if image_rendering == "background" else overlay_alpha,
        zoom=number(values, "Zoom Factor", 0.1, 20),
    )


def _namespace_options(values: Mapping[Any, Any]) -> Options:
    namespaces = mapping_or_empty(values.get("Namespaces"))
    return {
        f"ns:{name}": value
        for name, value in list(namespaces.items())[:_MAX_NAMESPACES]
        if isinstance(name, str) and isinstance(value, bool)
    }


def _effort_options(values: Mapping[Any, Any]) -> Options:
    return drop_none(
        alpha=number(values, "Alpha", 0, 1),
        scale=number(values, "Scale", 0.01, 100),
        prefix=text(values, "TF Prefix") or None,
    )


def _interactive_marker_options(values: Mapping[Any, Any]) -> Options:
    return drop_none(names=boolean(values, "Show Descriptions"))


def _no_options(values: Mapping[Any, Any]) -> Options:
    return {}


class TopicDisplay(NamedTuple):
    """The rules for converting displays of one rviz class.

    Attributes:
        options: converts a display's properties to the panel's options.
        topics: names of the properties that may contain the topic; the first that exists is used.
        prefix: prefix of the topic in the display's key (`page/lib/scene/display_kinds.js`).
        shows_images: whether the display shows images, which may also be published compressed, on another topic.
    """

    options: Callable[[Mapping[Any, Any]], Options] = _no_options
    topics: tuple[str, ...] = ("Topic",)
    prefix: str = ""
    shows_images: bool = False


_IMAGE_TOPIC_KEYS = ("Image Topic", "Topic")
_MARKER_TOPIC_KEYS = ("Marker Topic", "Topic")
TOPIC_DISPLAYS: Mapping[str, TopicDisplay] = {
    "AccelStamped": TopicDisplay(_arrow_pair_options),
    "Camera": TopicDisplay(_camera_options, _IMAGE_TOPIC_KEYS, "camera:", shows_images=True),
    "DepthCloud": TopicDisplay(_point_options, ("Depth Map Topic",), "depth:"),
    "Effort": TopicDisplay(_effort_options),
    "FluidPressure": TopicDisplay(),
    "GridCells": TopicDisplay(_colour_options),
    "Illuminance": TopicDisplay(),
    "Image": TopicDisplay(_no_options, _IMAGE_TOPIC_KEYS, shows_images=True),
    "Imu": TopicDisplay(_box_options),
    "InteractiveMarkers": TopicDisplay(_interactive_marker_options, ("Update Topic",)),
    "LaserScan": TopicDisplay(_point_options),
    "Map": TopicDisplay(_map_options),
    "Marker": TopicDisplay(_namespace_options, _MARKER_TOPIC_KEYS),
    "MarkerArray": TopicDisplay(_namespace_options, _MARKER_TOPIC_KEYS),
    "Odometry": TopicDisplay(_odometry_options),
    "Path": TopicDisplay(_path_options),
    "PointCloud": TopicDisplay(_point_options),
    "PointCloud2": TopicDisplay(_point_options),
    "PointStamped": TopicDisplay(_point_stamped_options),
    "Polygon": TopicDisplay(_colour_options),
    "Pose": TopicDisplay(_arrow_options),
    "PoseArray": TopicDisplay(_arrow_array_options),
    "PoseWithCovariance": TopicDisplay(_covariance_options),
    "Range": TopicDisplay(_history_options),
    "RelativeHumidity": TopicDisplay(),
    "Temperature": TopicDisplay(),
    "TwistStamped": TopicDisplay(_arrow_pair_options),
    "Wrench": TopicDisplay(_arrow_pair_options),
    "WrenchStamped": TopicDisplay(_arrow_pair_options),
}
"""Last part of the class of an rviz topic display -> the rules for converting the display."""
