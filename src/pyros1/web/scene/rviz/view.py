"""Converts rviz's views to the panel's views, which `page/lib/scene/stage.js` defines (no I/O)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from pyros1.ground.terminal_text import one_line
from pyros1.web.scene.rviz.values import class_of, number, point, text

FIXED_FRAME_NAME = "<Fixed Frame>"
"""The name that stands for the fixed frame in rviz files."""
_ORBIT_VIEWS = {"Orbit": "orbit", "XYOrbit": "ground", "ThirdPersonFollower": "third"}
_FLAT_HEIGHT = 16.0
"""Height in metres that the flat view shows, as in stage.js."""
_FLAT_DISTANCE = 100.0
_EYE_OFFSET = 0.05
"""Offset in metres of the flat view's eye from the centre; its direction determines which direction is up."""
_DEFAULT_SCALE = 50.0


def view_settings(view: Mapping[Any, Any], height: float) -> tuple[dict[str, Any], str]:
    """Return the panel's settings ``view`` and ``target`` as far as the file specifies them, and a note if the view is
    not supported.

    Args:
        view: the properties of rviz's current view.
        height: height of rviz's window in pixels.
    """
    class_name = class_of(view)
    frame = text(view, "Target Frame").lstrip("/")
    target = {"target": frame} if frame not in ("", FIXED_FRAME_NAME) else {}
    if class_name == "FrameAligned":
        return {"view": {"name": "frame"}, **target}, ""
    pitch, yaw = (number(view, key, -1e3, 1e3) or 0.0 for key in ("Pitch", "Yaw"))
    forward, sideways, up = math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), math.sin(pitch)
    if class_name in _ORBIT_VIEWS:
        focus = point(view.get("Focal Point"))
        distance = number(view, "Distance", 0.01, 1e5) or 10.0
        eye = [value + distance * part for value, part in zip(focus, (forward, sideways, up), strict=True)]
        is_off_centre = target and any(abs(value) > 0.01 for value in focus)
        note = "the view looks at the origin of its frame, not at another point in it" if is_off_centre else ""
        return {"view": _viewpoint(_ORBIT_VIEWS[class_name], eye, focus), **target}, note
    if class_name == "FPS":
        eye = point(view.get("Position"))
        looks_at = [value + part for value, part in zip(eye, (forward, sideways, -up), strict=True)]
        return {"view": _viewpoint("walk", eye, looks_at), **target}, ""
    if class_name == "TopDownOrtho":
        x, y = (number(view, key, -1e6, 1e6) or 0.0 for key in "XY")
        angle = number(view, "Angle", -1e3, 1e3) or 0.0
        scale = abs(number(view, "Scale", -1e5, 1e5) or 0.0) or _DEFAULT_SCALE  # pixels per metre
        viewpoint = _viewpoint(
            "flat", [x + _EYE_OFFSET * math.sin(angle), y - _EYE_OFFSET * math.cos(angle), _FLAT_DISTANCE], [x, y, 0.0]
        )
        return {"view": {**viewpoint, "zoom": round(scale * _FLAT_HEIGHT / height, 4)}, **target}, ""
    note = f"unsupported view {one_line(text(view, 'Class')) or 'without a class'}: the default view is used"
    return dict(target), note if view else ""


def _viewpoint(name: str, eye: Sequence[float], target: Sequence[float]) -> dict[str, Any]:
    return {
        "name": name,
        "position": [round(value, 3) for value in eye],
        "target": [round(value, 3) for value in target],
    }
