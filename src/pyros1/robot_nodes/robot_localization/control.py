"""Predicts how a robot accelerates towards its commanded velocity (``use_control``). Pure."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pyros1.robot_nodes.robot_localization.motion import ACCELERATION, ANGULAR, Array


@dataclass
class Control:
    """The latest commanded velocity, and the limits of the robot's acceleration.

    The six directions are vx, vy, vz, vroll, vpitch, vyaw.

    Attributes:
        used: which directions are commanded: bools (6,).
        acceleration_limits, deceleration_limits: magnitudes in m/s² and rad/s² (6,).
        acceleration_gains, deceleration_gains: acceleration per velocity error, in 1/s (6,).
        timeout: seconds without a command after which the robot is assumed to stop.
        command: the latest commanded velocity (6,).
        time: when the command was received, in nanoseconds.
    """

    used: np.ndarray[tuple[int], np.dtype[np.bool_]]
    acceleration_limits: Array
    deceleration_limits: Array
    acceleration_gains: Array
    deceleration_gains: Array
    timeout: float
    command: Array = field(default_factory=lambda: np.zeros(6))
    time: int = 0

    def accelerations(self, velocity: Array, time: int) -> Array:
        """Return the accelerations (6,) of a robot with a velocity (6,) at a time in nanoseconds."""
        is_current = abs(time - self.time) * 1e-9 < self.timeout
        command = self.command if is_current else np.zeros(6)
        # A robot that moves against its command first brakes until it stops.
        brakes = (command * velocity < 0.0) | (np.abs(command) < np.abs(velocity))
        limits = np.where(brakes, self.deceleration_limits, self.acceleration_limits)
        gains = np.where(brakes, self.deceleration_gains, self.acceleration_gains)
        wanted = np.clip(gains * (command - velocity), -limits, limits)
        return np.where(self.used, wanted, 0.0)

    def apply(self, state: Array, seconds: float, time: int) -> Array:
        """Return a state (15,) that accelerates as commanded: its linear accelerations are set, and its angular
        velocities are those after ``seconds``.
        """
        accelerations = self.accelerations(state[6:12], time)
        state = state.copy()
        state[ANGULAR] += seconds * accelerations[3:]
        state[ACCELERATION] = np.where(self.used[:3], accelerations[:3], state[ACCELERATION])
        return state
