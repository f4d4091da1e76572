"""The speeds that a joystick commands; they are raised and lowered in steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.twists import components

_MAX_STEPS = 1000


@dataclass(frozen=True)
class Range:
    """The speeds in m/s or rad/s when the stick is pushed to its end, for the first and the last step."""

    first: float
    last: float

    def speed(self, step: int, steps: int) -> float:
        """Return the speed for step ``step`` of ``steps``, counted from 1; with one step, it is the first speed."""
        return self.first + (self.last - self.first) * (step - 1) / max(1, steps - 1)


@dataclass(frozen=True)
class Ranges:
    """The ranges of all speeds, and the number of steps."""

    forward: Range
    backward: Range
    sideways: Range
    turning: Range
    steps: int
    initial_step: int


class Turbo:
    """Scales commands from -1 to 1 to speeds; driving and turning have separate steps.

    Args:
        ranges: the speeds.
    """

    def __init__(self, ranges: Ranges) -> None:
        self._ranges = ranges
        self.reset()

    def reset(self) -> None:
        """Return to the initial steps."""
        self._step = self._turning_step = self._ranges.initial_step

    def change(self, steps: int) -> None:
        """Raise the speeds by a number of steps; a negative one lowers them."""
        self._step = self._limited(self._step + steps)
        self.change_turning(steps)

    def change_turning(self, steps: int) -> None:
        """Raise only the turning speed by a number of steps."""
        self._turning_step = self._limited(self._turning_step + steps)

    def scale(self, command: Any) -> Any:
        """Return the twist for a command; None if it is not one from -1 to 1 for x, y and turning about z only."""
        x, y, z, roll, pitch, yaw = components(command)
        if z or roll or pitch or not all(abs(value) <= 1 for value in (x, y, yaw)):
            return None
        ranges, twist = self._ranges, Twist()
        ahead = ranges.forward if x >= 0 else ranges.backward
        twist.linear.x = x * ahead.speed(self._step, ranges.steps)
        twist.linear.y = y * ranges.sideways.speed(self._step, ranges.steps)
        twist.angular.z = yaw * ranges.turning.speed(self._turning_step, ranges.steps)
        return twist

    def _limited(self, step: int) -> int:
        return max(1, min(self._ranges.steps, step))


def read_ranges(values: PrivateParameters) -> Ranges:
    """Read the ranges from a node's private parameters in the namespace ``~turbo``."""
    steps = values.integer("turbo/steps", 1, 1, _MAX_STEPS)
    forward = _read_range(values, "linear_forward", Range(1.0, 1.0))
    return Ranges(
        forward=forward,
        backward=_read_range(values, "linear_backward", forward),
        sideways=_read_range(values, "linear_lateral", Range(1.0, 1.0)),
        turning=_read_range(values, "angular", Range(1.0, 1.0)),
        steps=steps,
        initial_step=values.integer("turbo/init_step", (steps + 1) // 2, 1, steps),
    )


def _read_range(values: PrivateParameters, name: str, default: Range) -> Range:
    first, last = (
        values.number(f"turbo/{name}_{end}", number, 0.0)
        for end, number in (("min", default.first), ("max", default.last))
    )
    return Range(first, last)
