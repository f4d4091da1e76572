"""The marker that users drag, and the velocity commands for its poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import atan2, hypot, sqrt
from typing import Any

from pyros1.msgs.geometry_msgs.msg import Quaternion, Twist
from pyros1.msgs.visualization_msgs.msg import InteractiveMarker, InteractiveMarkerControl
from pyros1.robot_nodes.shared.parameters import PrivateParameters

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 0.0, 1.0), "z": (0.0, 1.0, 0.0)}
"""Direction -> x, y, z of the quaternion (x, y, z, 1), before normalization, that rotates a control to it."""


@dataclass(frozen=True)
class Scale:
    """Converts a distance or an angle to a speed.

    Attributes:
        factor: the speed for 1 m or 1 rad, in m/s or rad/s.
        minimum, maximum: the limits of the speed.
    """

    factor: float
    minimum: float
    maximum: float

    def speed(self, distance: float) -> float:
        """Return the speed for a distance or an angle."""
        return max(self.minimum, min(self.maximum, self.factor * distance))


@dataclass(frozen=True)
class Settings:
    """The marker's parameters, and the scales for the speeds.

    Attributes:
        link: the frame of the marker.
        robot: the name of the robot, for display.
        size: the size of the marker in metres.
        linear: the scale for each direction, "x", "y" or "z".
        angular: the scale for the rotation about z.
    """

    link: str
    robot: str
    size: float
    linear: Mapping[str, Scale]
    angular: Scale

    @property
    def marker_name(self) -> str:
        """The name of the marker."""
        return f"{self.robot}_twist_marker"


def read_settings(values: PrivateParameters) -> Settings:
    """Read the settings from a node's parameters.

    The parameters for linear velocities are numbers, which apply to x, or mappings such as ``{x: 1.0, y: 0.5}``.
    """
    scales = values.value("linear_scale")
    if isinstance(scales, Mapping):
        for name in scales:
            if name not in _AXES:
                values.report_invalid(f"linear_scale/{name}", scales[name], "for x, y or z", "none")
        linear = {name: _read_scale(values, f"/{name}", 0.0, 0.0) for name in _AXES if name in scales}
    else:
        linear = {"x": _read_scale(values, "", 1.0, 1.0)}
    limit = values.number("max_angular_velocity", 2.2, 0.0)
    return Settings(
        link=values.text("link_name", "base_link"),
        robot=values.text("robot_name", "robot"),
        size=values.number("marker_size_scale", 1.0, 0.0),
        linear=linear,
        angular=Scale(values.number("angular_scale", 2.2), -limit, limit),
    )


def _read_scale(values: PrivateParameters, end: str, factor: float, limit: float) -> Scale:
    return Scale(
        values.number(f"linear_scale{end}", factor),
        values.number(f"max_negative_linear_velocity{end}", -limit, maximum=0.0),
        values.number(f"max_positive_linear_velocity{end}", limit, 0.0),
    )


def make_marker(settings: Settings) -> Any:
    """Return an InteractiveMarker with controls that move and turn it."""
    marker = InteractiveMarker(
        name=settings.marker_name, description=f"twist controller for {settings.robot}", scale=settings.size
    )
    marker.header.frame_id = settings.link
    marker.pose.orientation.w = 1.0
    marker.controls = [
        *(_make_control(f"move_{axis}", axis, InteractiveMarkerControl.MOVE_AXIS) for axis in settings.linear),
        _make_control("rotate_z", "z", InteractiveMarkerControl.ROTATE_AXIS),
    ]
    return marker


def _make_control(name: str, axis: str, mode: int) -> Any:
    x, y, z = _AXES[axis]
    half = sqrt(0.5)
    turn = Quaternion(half * x, half * y, half * z, half)
    return InteractiveMarkerControl(name=name, orientation=turn, interaction_mode=mode)


def twist_for(pose: Any, settings: Settings) -> Any:
    """Return the Twist for a pose of the marker; the robot only turns about z."""
    twist = Twist()
    for axis, scale in settings.linear.items():
        setattr(twist.linear, axis, scale.speed(getattr(pose.position, axis)))
    twist.angular.z = settings.angular.speed(_yaw(pose.orientation))
    return twist


def _yaw(turn: Any) -> float:
    parts = turn.x, turn.y, turn.z, turn.w
    length = hypot(*parts) or 1.0  # programs that are not rviz send quaternions of any length
    x, y, z, w = (part / length for part in parts)
    return atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)
