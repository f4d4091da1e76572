"""The motion model of ekf_localization_node: predicts how a robot's state changes with time. Pure.

A state is an array (15,): x, y, z, roll, pitch, yaw in the world frame; the velocities vx, vy, vz, vroll, vpitch, vyaw
and the accelerations ax, ay, az in the robot's frame. Units are metres, radians and seconds; rotations are as in
REP 103 (about the fixed axes x, y, z). Angular velocities and accelerations are assumed to be constant.
"""

from __future__ import annotations

from math import copysign, cos, isfinite, nan, pi, remainder, sin, tau
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SIZE = 15
Z, ROLL, PITCH, YAW, VZ, VROLL, VPITCH, AZ = 2, 3, 4, 5, 8, 9, 10, 14
POSITION, ANGLES = slice(0, 3), slice(3, 6)
LINEAR, ANGULAR = slice(6, 9), slice(9, 12)
ACCELERATION = slice(12, 15)

IDENTITY = np.eye(SIZE)
IDENTITY.setflags(write=False)

_DERIVATIVES = np.array(
    [
        SIZE * row + column
        for rows, columns in (
            (range(3), (ROLL,)),
            (range(3), (PITCH,)),
            (range(2), (YAW,)),
            (range(3), range(6, 9)),
            (range(3), range(12, 15)),
            (range(3, 6), (ROLL,)),
            ((ROLL, YAW), (PITCH,)),
            (range(3, 6), range(9, 12)),
        )
        for row in rows
        for column in columns
    ]
    + [SIZE * row + row + 6 for row in range(6, 9)]
)
"""Flat indices of the Jacobian's elements that `predict` computes."""
_DERIVATIVES.setflags(write=False)
MIN_COSINE = 1e-6
"""Limit for the cosine of the pitch: near 90 degrees, the rates of roll and yaw would grow without bound."""


def rotation_matrix(roll: float, pitch: float, yaw: float) -> Array:
    """Return the matrix (3, 3) that rotates from the robot's frame to the world frame."""
    return np.array(_rotation(roll, pitch, yaw)).reshape(3, 3)


def _rotation(roll: float, pitch: float, yaw: float) -> tuple[float, ...]:
    """Return the elements of `rotation_matrix`, row by row."""
    cr, sr, cp, sp, cy, sy = cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    return (
        *(cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        *(sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        *(-sp, cp * sr, cp * cr),
    )


def wrap_angles(angles: Any) -> Any:
    """Return angles in radians, each wrapped to the range from -pi to pi."""
    return angles - tau * np.rint(angles / tau)


def predict(state: Array, seconds: float) -> tuple[Array, Array]:
    """Return the state (15,) after ``seconds``, and its Jacobian (15, 15) with respect to the given state.

    Args:
        state: the state (15,).
        seconds: the duration of the prediction.
    """
    # Plain floats, since numpy takes longer for each of many small arrays than for one matrix (15, 15).
    x, y, z, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, ax, ay, az = state.tolist()
    sr, cr, sy, cy, sp = sin(roll), cos(roll), sin(yaw), cos(yaw), sin(pitch)
    cp = cos(pitch)
    cp = copysign(max(abs(cp), MIN_COSINE), cp)
    tp = sp / cp
    half_square = 0.5 * seconds * seconds

    rotation = _rotation(roll, pitch, yaw)
    xx, xy, xz, yx, yy, yz, zx, zy, zz = rotation
    # The path, in the robot's frame and in the world.
    px, py, pz = seconds * vx + half_square * ax, seconds * vy + half_square * ay, seconds * vz + half_square * az
    dx, dy, dz = xx * px + xy * py + xz * pz, yx * px + yy * py + yz * pz, zx * px + zy * py + zz * pz

    across, along = sr * wy + cr * wz, cr * wy - sr * wz  # components of the rotation in the plane of y and z
    roll, pitch, yaw = (
        _wrap(angle)
        for angle in (roll + seconds * (wx + tp * across), pitch + seconds * along, yaw + seconds * across / cp)
    )
    vx, vy, vz = vx + seconds * ax, vy + seconds * ay, vz + seconds * az
    after = np.array((x + dx, y + dy, z + dz, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, ax, ay, az))

    jacobian = IDENTITY.copy()
    jacobian.put(
        _DERIVATIVES,
        (
            *(xz * py - xy * pz, yz * py - yy * pz, zz * py - zy * pz),  # d position / d roll, pitch, yaw
            *(cy * dz, sy * dz, -sy * dy - cy * dx),
            *(-dy, dx),
            *(seconds * part for part in rotation),  # d position / d velocity
            *(half_square * part for part in rotation),  # d position / d acceleration
            *(1.0 + seconds * tp * along, -seconds * across, seconds * along / cp),  # d angles / d roll, pitch
            *(seconds * across / (cp * cp), seconds * across * tp / cp),
            *(seconds, seconds * sr * tp, seconds * cr * tp),  # d angles / d their rates
            *(0.0, seconds * cr, -seconds * sr),
            *(0.0, seconds * sr / cp, seconds * cr / cp),
            *(seconds, seconds, seconds),  # d velocity / d acceleration
        ),
    )
    return after, jacobian


def _wrap(angle: float) -> float:
    """Return an angle wrapped to the range from -pi to pi; nan if it is not finite."""
    if -pi <= angle <= pi:
        return angle
    return remainder(angle, tau) if isfinite(angle) else nan
