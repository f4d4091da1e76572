"""rviz's defaults for properties that the panel does not support: only values that differ are reported (no I/O)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

INVISIBLE_PROPERTIES = frozenset({"Class", "Name", "Enabled", "Value", "Queue Size", "Unreliable"})
"""Properties without a visible effect: names, network options, and ``Value``, which duplicates ``Enabled``."""
_DEFAULTS: Mapping[str, Any] = {
    "Angle": 0,
    "Background Color": "48; 48; 48",
    "Color Transformer": "",
    "Default Light": True,
    "Enable Stereo Rendering/Stereo Eye Separation": 0.06,
    "Enable Stereo Rendering/Stereo Focal Distance": 1,
    "Enable Stereo Rendering/Swap Stereo Eyes": False,
    "Enable Stereo Rendering/Value": False,
    "Enable Transparency": True,
    "Field of View": math.pi / 4,
    "Focal Shape Fixed Size": True,
    "Focal Shape Size": 0.05,
    "Frame Rate": 30,
    "Frame Timeout": 15,
    "Hide Inactive Objects": True,
    "History Length": 1,
    "Invert Z Axis": False,
    "Marker Alpha": 1,
    "Max Value": 1,
    "Median window": 5,
    "Min Value": 0,
    "Near Clip Distance": 0.01,
    "Normal Cell Count": 0,
    "Normalize Range": True,
    "Occlusion Compensation/Occlusion Time-Out": 30,
    "Occlusion Compensation/Value": False,
    "Plane": "XY",
    "Position Transformer": ("", "XYZ"),
    "Roll": 0,
    "Selectable": True,
    "Show Axes": False,
    "Show Trail": False,
    "Show Visual Aids": False,
    "Single click": True,
    "Theta std deviation": math.pi / 12,
    "Topic Filter": True,
    "Update Interval": 0,
    "Use Timestamp": False,
    "Width": 0.02,
    "X std deviation": 0.5,
    "Y std deviation": 0.5,
    "Auto Size/Auto Size Factor": 1,
    "Auto Size/Value": True,
    "Color Transport Hint": "raw",
    "Depth Map Transport Hint": "raw",
    "Covariance/Orientation/Color Style": "Unique",
    "Covariance/Orientation/Frame": "Local",
    "Covariance/Orientation/Offset": 1,
    "Covariance/Orientation/Scale": 1,
}
_SCALAR_DEFAULTS: Mapping[str, Any] = {  # for displays of a single number, which the panel draws as balls
    "Alpha": 1,
    "Autocompute Intensity Bounds": False,
    "Autocompute Value Bounds/Max Value": 10,
    "Autocompute Value Bounds/Min Value": -10,
    "Autocompute Value Bounds/Value": True,
    "Axis": "Z",
    "Color": "255; 255; 255",
    "Decay Time": 0,
    "Invert Rainbow": False,
    "Max Color": "255; 255; 255",
    "Min Color": "0; 0; 0",
    "Size (Pixels)": 3,
    "Size (m)": 0.01,
    "Style": "Flat Squares",
    "Use Fixed Frame": True,
    "Use rainbow": True,
}
_DEFAULTS_BY_CLASS: Mapping[str, Mapping[str, Any]] = {
    "FluidPressure": {
        **_SCALAR_DEFAULTS,
        "Channel Name": "fluid_pressure",
        "Max Intensity": 105_000,
        "Min Intensity": 98_000,
    },
    "Illuminance": {**_SCALAR_DEFAULTS, "Channel Name": "illuminance", "Max Intensity": 1000, "Min Intensity": 0},
    "RelativeHumidity": {
        **_SCALAR_DEFAULTS,
        "Channel Name": "relative_humidity",
        "Max Intensity": 1,
        "Min Intensity": 0,
    },
    "FrameAligned": {
        "Lock Camera": False,
        "Pitch": math.pi / 2,
        "Point towards": "-z axis",
        "Position/X": 0,
        "Position/Y": 0,
        "Position/Z": 0,
        "Yaw": 0,
    },
    "Temperature": {
        **_SCALAR_DEFAULTS,
        "Channel Name": "temperature",
        "Invert Rainbow": True,
        "Max Intensity": 100,
        "Min Intensity": 0,
    },
}


def differs_from_default(class_name: str, name: str, value: Any) -> bool:
    """Return whether a property of an rviz file differs from rviz's default in a visible way.

    Args:
        class_name: the class of the object that has the property, without "rviz/".
        name: the property's name; for a nested property, all names joined by ``/``.
        value: the property's value in the file.
    """
    if name in INVISIBLE_PROPERTIES:
        return False
    if name.startswith("Visibility/"):
        return value is not True
    defaults = _DEFAULTS_BY_CLASS.get(class_name, _DEFAULTS)
    if name not in defaults:
        defaults = _DEFAULTS
    if name not in defaults:
        return True
    default = defaults[name]
    return not any(_is_same(value, each) for each in (default if isinstance(default, tuple) else (default,)))


def _is_same(value: Any, default: Any) -> bool:
    if isinstance(default, (bool, str)) or isinstance(value, (bool, str)):
        return value is default if isinstance(default, bool) else bool(value == default)
    return isinstance(value, (int, float)) and math.isclose(value, default, rel_tol=1e-5, abs_tol=1e-9)
