"""How a robot's state changes with time: the motion model of ekf_localization_node. Pure.

A state is an array (15,): x, y, z, roll, pitch, yaw in the world frame; their rates vx, vy, vz, vroll, vpitch, vyaw and
the accelerations ax, ay, az in the robot's frame. Metres, radians and seconds; rotations as in REP 103 (the angles are
those of rotations about the fixed axes x, y, z). Velocities of rotation and accelerations are taken as constant.
"""

from __future__ import annotations

from math import copysign, cos, sin, tau
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SIZE = 15
Z, ROLL, PITCH, VZ, VROLL, VPITCH, AZ = 2, 3, 4, 8, 9, 10, 14
POSITION, ANGLES = slice(0, 3), slice(3, 6)
LINEAR, ANGULAR = slice(6, 9), slice(9, 12)
ACCELERATION = slice(12, 15)

IDENTITY = np.eye(SIZE)
IDENTITY.setflags(write=False)

MIN_COSINE = 1e-6
"""Nearer to a pitch of 90 degrees, rates of roll and yaw would grow without bound."""


def rotation_matrix(roll: float, pitch: float, yaw: float) -> Array:
    """Return the matrix (3, 3) that rotates from the robot's frame to the world frame."""
    cr, sr, cp, sp, cy, sy = cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def wrap_angles(angles: Any) -> Any:
    """Return angles in radians, each moved by whole turns to the range from -pi to pi."""
    return angles - tau * np.rint(angles / tau)


def predict(state: Array, seconds: float) -> tuple[Array, Array]:
    """Return the state (15,) after a time, and the matrix (15, 15) of its derivatives by the state before.

    Args:
        state: the state (15,).
        seconds: the time.
    """
    roll, pitch, yaw = state[ANGLES].tolist()
    wx, wy, wz = state[ANGULAR].tolist()
    sr, cr, sy, cy, sp = sin(roll), cos(roll), sin(yaw), cos(yaw), sin(pitch)
    cp = cos(pitch)
    cp = copysign(max(abs(cp), MIN_COSINE), cp)
    tp = sp / cp
    half_square = 0.5 * seconds * seconds

    rotation = rotation_matrix(roll, pitch, yaw)
    path = seconds * state[LINEAR] + half_square * state[ACCELERATION]  # in the robot's frame
    dx, dy, dz = (rotation @ path).tolist()
    _, py, pz = path.tolist()
    by_roll = rotation[:, 2] * py - rotation[:, 1] * pz

    across, along = sr * wy + cr * wz, cr * wy - sr * wz  # components of the rotation in the plane of y and z
    rates = (wx + tp * across, along, across / cp)  # of roll, pitch and yaw

    after = state.copy()
    after[POSITION] += (dx, dy, dz)
    after[ANGLES] = wrap_angles(after[ANGLES] + seconds * np.array(rates))
    after[LINEAR] += seconds * state[ACCELERATION]

    jacobian = IDENTITY.copy()
    jacobian[POSITION, ROLL] = by_roll
    jacobian[0, PITCH], jacobian[1, PITCH], jacobian[2, PITCH] = cy * dz, sy * dz, -sy * dy - cy * dx
    jacobian[0, 5], jacobian[1, 5] = -dy, dx
    jacobian[POSITION, LINEAR] = seconds * rotation
    jacobian[POSITION, ACCELERATION] = half_square * rotation
    jacobian[ANGLES, ROLL] += (seconds * tp * along, -seconds * across, seconds * along / cp)
    jacobian[ROLL, PITCH] = seconds * across / (cp * cp)
    jacobian[5, PITCH] = seconds * across * tp / cp
    jacobian[ANGLES, ANGULAR] = (
        (seconds, seconds * sr * tp, seconds * cr * tp),
        (0.0, seconds * cr, -seconds * sr),
        (0.0, seconds * sr / cp, seconds * cr / cp),
    )
    jacobian[6, 12] = jacobian[7, 13] = jacobian[8, 14] = seconds
    return after, jacobian
