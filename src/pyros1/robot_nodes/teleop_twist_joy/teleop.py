"""Converts the state of a joystick to a velocity command."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number

_LINEAR = {"x": "x", "y": "y", "z": "z"}
_ANGULAR = {"yaw": "z", "pitch": "y", "roll": "x"}
MAX_INDEX = 2**31 - 1


@dataclass(frozen=True)
class Axis:
    """An axis of the joystick, and the component of the twist that it controls.

    Attributes:
        vector: "linear" or "angular".
        component: "x", "y" or "z".
        index: the index of the axis; if it is negative, or the joystick has no such axis, the component is 0.
        scale: the speed in m/s or rad/s when the axis is pushed to its end.
        turbo_scale: the scale while the turbo button is pressed.
    """

    vector: str
    component: str
    index: int
    scale: float
    turbo_scale: float


@dataclass(frozen=True)
class Controls:
    """The functions of a joystick's buttons and axes.

    Attributes:
        enable_button: the button that must be pressed to drive; negative for none.
        turbo_button: the button that must be pressed to drive fast; negative if there is none.
        axes: the functions of the axes.
    """

    enable_button: int
    turbo_button: int
    axes: tuple[Axis, ...]


class Teleop:
    """Drives a robot while a button is pressed, and stops it once when the button is released.

    Args:
        controls: the functions of the joystick's buttons and axes.
    """

    def __init__(self, controls: Controls) -> None:
        self._controls = controls
        self._is_stopped = False

    def handle(self, axes: Sequence[float], buttons: Sequence[int]) -> Any:
        """Return the command for a new state of the joystick as a Twist; None if there is none to publish."""
        controls = self._controls
        is_turbo = _is_pressed(controls.turbo_button, buttons)
        if not is_turbo and controls.enable_button >= 0 and not _is_pressed(controls.enable_button, buttons):
            was_stopped, self._is_stopped = self._is_stopped, True
            return None if was_stopped else Twist()
        self._is_stopped = False
        twist = Twist()
        for axis in controls.axes:
            value = axes[axis.index] if 0 <= axis.index < len(axes) else 0.0
            speed = value * (axis.turbo_scale if is_turbo else axis.scale)
            if isfinite(speed):
                setattr(getattr(twist, axis.vector), axis.component, speed)
        return twist


def _is_pressed(button: int, buttons: Sequence[int]) -> bool:
    return 0 <= button < len(buttons) and buttons[button] != 0


def read_controls(values: PrivateParameters) -> Controls:
    """Read the controls from a node's parameters.

    An axis is a number, which then controls x or yaw, or a mapping such as ``{x: 1, y: 0}``; its scales have the same
    form.
    """
    linear = _read_axes(values, "linear", _LINEAR, "x", 1, 1.0)
    angular = _read_axes(values, "angular", _ANGULAR, "yaw", 0, None)
    return Controls(
        enable_button=values.integer("enable_button", 0, -MAX_INDEX, MAX_INDEX),
        turbo_button=values.integer("enable_turbo_button", -1, -MAX_INDEX, MAX_INDEX),
        axes=(*linear, *angular),
    )


def _read_axes(
    values: PrivateParameters, vector: str, names: dict[str, str], main: str, index: int, turbo_scale: float | None
) -> list[Axis]:
    """Read the axes of one vector.

    Args:
        values: the parameters.
        vector: "linear" or "angular".
        names: the components by their names in parameters.
        main: the name of the component that is controlled if ``axis_VECTOR`` is not a mapping.
        index: the default axis for this component.
        turbo_scale: the default scale with turbo; None for the same as without.
    """
    mapping = values.value(f"axis_{vector}")
    if not isinstance(mapping, dict):
        scale = values.number(f"scale_{vector}", 0.5)
        turbo = values.number(f"scale_{vector}_turbo", scale if turbo_scale is None else turbo_scale)
        return [Axis(vector, names[main], values.integer(f"axis_{vector}", index, -1, MAX_INDEX), scale, turbo)]
    axes = []
    for name, number in mapping.items():
        if name not in names or not is_number(number):
            values.report_invalid(
                f"axis_{vector}/{name}", number, f"the number of an axis for {', '.join(names)}", "no axis"
            )
            continue
        scales = [_read_scale(values, f"scale_{vector}{end}", name) for end in ("", "_turbo")]
        axes.append(Axis(vector, names[name], round(number), *scales))
    return axes


def _read_scale(values: PrivateParameters, parameter: str, name: str) -> float:
    """Return the scale of one component; 0 if it has none, as in stock ROS."""
    scales = values.value(parameter)
    if scales is not None and not isinstance(scales, dict):
        return values.report_invalid(parameter, scales, "a mapping, as the axes are", 0.0)
    return values.number(f"{parameter}/{name}", 0.0)
