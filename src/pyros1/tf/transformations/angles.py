"""Converts Euler angles in all 24 conventions; see `pyros1.tf.transformations`."""

from __future__ import annotations

from itertools import product
from math import atan2, cos, hypot, sin

import numpy as np
from numpy.typing import ArrayLike

from pyros1.tf.rotation import EPS
from pyros1.tf.transformations.quaternions import quaternion_matrix
from pyros1.tf.transformations.vectors import Array

Axes = str | tuple[int, int, int, int]


def _axes_name(first: int, is_odd: int, repeats_first: int, is_rotating: int) -> str:
    """Return the name, such as ``sxyz``, of the Euler axis sequence that four integers encode."""
    j = (first + 1 + is_odd) % 3
    letters = "".join("xyz"[axis] for axis in (first, j, first if repeats_first else 3 - first - j))
    return "r" + letters[::-1] if is_rotating else "s" + letters


_AXES_CODES = {
    key: code for code in product(range(3), range(2), range(2), range(2)) for key in (_axes_name(*code), code)
}


def _axes_code(axes: Axes) -> tuple[int, int, int, int]:
    key = axes.lower() if isinstance(axes, str) else axes
    if key not in _AXES_CODES:
        raise KeyError(f"axes must be s or r and three of x, y, z, without repetition of neighbours, not {axes!r}")
    return _AXES_CODES[key]


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: Axes = "sxyz") -> Array:
    """Return the quaternion (4,) of three rotations, by default roll, pitch and yaw.

    Raises:
        KeyError: the axes are unknown.
    """
    i, is_odd, repeats_first, is_rotating = _axes_code(axes)
    if is_rotating:  # rotations about rotating axes equal those about static axes in reverse order
        ai, ak = ak, ai
    half = -0.5 if is_odd else 0.5  # left-handed axes rotate in the opposite direction
    a, b, c = half * ai, half * aj, half * ak
    if repeats_first:
        x, y, z, w = cos(b) * sin(c + a), sin(b) * cos(c - a), sin(b) * sin(c - a), cos(b) * cos(c + a)
    else:
        ca, sa, cb, sb, cc, sc = cos(a), sin(a), cos(b), sin(b), cos(c), sin(c)
        x, y = cc * cb * sa - sc * sb * ca, cc * sb * ca + sc * cb * sa
        z, w = sc * cb * ca - cc * sb * sa, cc * cb * ca + sc * sb * sa
    if is_odd:
        x, y, z = -x, -y, -z
    parts = [0.0, 0.0, 0.0, w]
    parts[i], parts[(i + 1 + is_odd) % 3], parts[(i + 2 - is_odd) % 3] = x, y, z
    return np.array(parts)


def euler_from_quaternion(quaternion: ArrayLike, axes: Axes = "sxyz") -> tuple[float, float, float]:
    """Return the angles of a rotation (4,), by default (roll, pitch, yaw); see `euler_from_matrix`."""
    return euler_from_matrix(quaternion_matrix(quaternion), axes)


def euler_matrix(ai: float, aj: float, ak: float, axes: Axes = "sxyz") -> Array:
    """Return the matrix (4, 4) of three rotations, by default roll, pitch and yaw; see `quaternion_from_euler`."""
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes))


def euler_from_matrix(matrix: ArrayLike, axes: Axes = "sxyz") -> tuple[float, float, float]:
    """Return the angles of the rotation in a matrix (3, 3) or (4, 4), by default (roll, pitch, yaw).

    If only the sum or the difference of two angles is determined (at a pitch of 90 degrees), one of them is 0.

    Raises:
        KeyError: the axes are unknown.
    """
    i, is_odd, repeats_first, is_rotating = _axes_code(axes)
    j, k = (i + 1 + is_odd) % 3, (i + 2 - is_odd) % 3
    m = np.asarray(matrix, np.float64).tolist()
    if repeats_first:
        size = hypot(m[i][j], m[i][k])
        middle = atan2(size, m[i][i])
        first, last = atan2(m[i][j], m[i][k]), atan2(m[j][i], -m[k][i])
    else:
        size = hypot(m[i][i], m[j][i])
        middle = atan2(-m[k][i], size)
        first, last = atan2(m[k][j], m[k][k]), atan2(m[j][i], m[i][i])
    if not size > EPS:  # or nan
        first, last = atan2(-m[j][k], m[j][j]), 0.0
    if is_rotating:
        first, last = last, first
    return (-first, -middle, -last) if is_odd else (first, middle, last)
