"""Vectors, quaternions and Euler angles, on lists of floats: see `pyros1.tf.transformations`."""

from __future__ import annotations

import random
from collections.abc import Sequence
from math import acos, atan2, cos, hypot, pi, sin, sqrt
from typing import Any

Vector = Sequence[float]
Matrix = list[list[float]]
Rows = Sequence[Sequence[float]]
Axes = str | tuple[int, int, int, int]

EPS = 4 * 2.0**-52
"""Below this a length is none."""

_EVEN = ("xyz", "yzx", "zxy")


# Vectors --------------------------------------------------------------------------------------------------------------


def dot(one: Vector, other: Vector) -> float:
    """Return the scalar product."""
    return sum(a * b for a, b in zip(one, other, strict=True))


def cross(one: Vector, other: Vector) -> list[float]:
    """Return the vector product."""
    (a, b, c), (x, y, z) = one, other
    return [b * z - c * y, c * x - a * z, a * y - b * x]


def normalized(vector: Vector) -> list[float]:
    """Return the vector of length 1 in the same direction."""
    length = hypot(*vector)
    return [part / length for part in vector]


def vector_norm(data: Any, axis: int | None = None) -> Any:
    """Return a vector's length.

    Args:
        data: numbers, or rows of numbers.
        axis: of rows, 1 for the length of each row and 0 for that of each column; None takes all numbers as one vector.
    """
    if axis is None:
        return hypot(*(hypot(*row) if _has_length(row) else row for row in data))
    return [hypot(*vector) for vector in _along(data, axis)] if _is_rows(data) else hypot(*data)


def unit_vector(data: Any, axis: int | None = None) -> Any:
    """Return the vector of length 1 in the same direction; of rows, see `vector_norm`, each along the axis."""
    if not _is_rows(data):
        return normalized(data)
    if axis is None:
        length = vector_norm(data)
        return [[part / length for part in row] for row in data]
    found = [normalized(vector) for vector in _along(data, axis)]
    return found if axis in (1, -1) else [list(row) for row in zip(*found, strict=True)]


def random_vector(size: int) -> list[float]:
    """Return so many random numbers from 0 to 1."""
    return [random.random() for _ in range(size)]


def _has_length(value: Any) -> bool:
    return hasattr(value, "__len__")


def _is_rows(data: Any) -> bool:
    return len(data) > 0 and _has_length(data[0])


def _along(rows: Rows, axis: int) -> Rows:
    if axis not in (-2, -1, 0, 1):
        raise ValueError(f"rows of numbers have the axes 0 and 1, not {axis}")
    return rows if axis in (1, -1) else list(zip(*rows, strict=True))


# Quaternions ----------------------------------------------------------------------------------------------------------


def quaternion_multiply(quaternion1: Vector, quaternion0: Vector) -> list[float]:
    """Return the rotation that is ``quaternion0`` first and ``quaternion1`` then."""
    x1, y1, z1, w1 = map(float, quaternion1)
    x0, y0, z0, w0 = map(float, quaternion0)
    return [
        w1 * x0 + x1 * w0 + y1 * z0 - z1 * y0,
        w1 * y0 + y1 * w0 + z1 * x0 - x1 * z0,
        w1 * z0 + z1 * w0 + x1 * y0 - y1 * x0,
        w1 * w0 - x1 * x0 - y1 * y0 - z1 * z0,
    ]


def quaternion_conjugate(quaternion: Vector) -> list[float]:
    """Return the quaternion with the opposite axis; of a unit quaternion that is the inverse."""
    x, y, z, w = map(float, quaternion)
    return [-x, -y, -z, w]


def quaternion_inverse(quaternion: Vector) -> list[float]:
    """Return the quaternion that multiplied with this one gives [0, 0, 0, 1]."""
    square = sum(float(part) * float(part) for part in quaternion)
    return [part / square for part in quaternion_conjugate(quaternion)]


def quaternion_about_axis(angle: float, axis: Vector) -> list[float]:
    """Return the rotation by ``angle`` about ``axis``, of any length."""
    length = hypot(*axis)
    scale = sin(angle / 2.0) / length if length > EPS else 1.0
    x, y, z = (float(part) * scale for part in axis)
    return [x, y, z, cos(angle / 2.0)]


def quaternion_slerp(
    quat0: Vector, quat1: Vector, fraction: float, spin: int = 0, shortestpath: bool = True
) -> list[float]:
    """Return the rotation on the way from one to another, at constant angular velocity.

    Args:
        fraction: 0 for ``quat0``, 1 for ``quat1``.
        spin: half turns to make in addition.
        shortestpath: take the nearer of ``quat1`` and its negative, which is the same rotation.
    """
    start, end = normalized(quat0), normalized(quat1)
    if fraction in (0.0, 1.0):
        return end if fraction else start
    cosine = dot(start, end)
    if abs(abs(cosine) - 1.0) < EPS:
        return start
    if shortestpath and cosine < 0.0:
        cosine, end = -cosine, [-part for part in end]
    angle = acos(cosine) + spin * pi
    if abs(angle) < EPS:
        return start
    a, b = sin((1.0 - fraction) * angle) / sin(angle), sin(fraction * angle) / sin(angle)
    return [a * p + b * q for p, q in zip(start, end, strict=True)]


def random_quaternion(rand: Sequence[float] | None = None) -> list[float]:
    """Return a rotation, all being equally likely.

    Args:
        rand: three numbers from 0 to 1 that decide; None takes random ones.
    """
    a, b, c = (random.random() for _ in range(3)) if rand is None else rand
    near, far = sqrt(1.0 - a), sqrt(a)
    return [sin(2 * pi * b) * near, cos(2 * pi * b) * near, sin(2 * pi * c) * far, cos(2 * pi * c) * far]


# Euler angles ---------------------------------------------------------------------------------------------------------


def _axes(axes: Axes) -> tuple[bool, str]:
    """Return whether the axes turn, and their letters."""
    if not isinstance(axes, str):
        axes = _axes_of_code(*axes)
    frame, letters = axes[:1], axes[1:]
    if frame not in ("s", "r") or len(letters) != 3 or set(letters) - set("xyz") or letters[1] in letters[::2]:
        raise ValueError(f"axes must be s or r and three of x, y, z, no two alike in a row, not {axes!r}")
    return frame == "r", letters


def _axes_of_code(first: int, parity: int, repetition: int, frame: int) -> str:
    """The letters that a code of four integers stands for: those of axes that turn are in it in the opposite order."""
    i, odd = first % 3, bool(parity)
    j = (i + (2 if odd else 1)) % 3
    letters = "".join("xyz"[axis] for axis in (i, j, i if repetition else 3 - i - j))
    return "r" + letters[::-1] if frame else "s" + letters


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: Axes = "sxyz") -> list[float]:
    """Return the quaternion of three rotations, by default roll, pitch and yaw.

    Raises:
        ValueError: ``axes`` are none.
    """
    turning, letters = _axes(axes)
    result = [0.0, 0.0, 0.0, 1.0]
    for letter, angle in zip(letters, (ai, aj, ak), strict=True):
        one = [0.0, 0.0, 0.0, cos(angle / 2.0)]
        one["xyz".index(letter)] = sin(angle / 2.0)
        result = quaternion_multiply(result, one) if turning else quaternion_multiply(one, result)
    return result


def euler_from_quaternion(quaternion: Vector, axes: Axes = "sxyz") -> tuple[float, float, float]:
    """Return the angles of a rotation, by default (roll, pitch, yaw)."""
    return euler_from_matrix(quaternion_matrix(quaternion), axes)


def euler_matrix(ai: float, aj: float, ak: float, axes: Axes = "sxyz") -> Matrix:
    """Return the matrix of three rotations, by default roll, pitch and yaw."""
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes))


def euler_from_matrix(matrix: Rows, axes: Axes = "sxyz") -> tuple[float, float, float]:
    """Return the angles of the rotation in a matrix of three or four rows, by default (roll, pitch, yaw).

    Where only the sum or the difference of two angles is determined (pitch of 90 degrees), one of them is 0.

    Raises:
        ValueError: ``axes`` are none.
    """
    turning, letters = _axes(axes)
    if turning:  # about axes that turn is about axes that stand still, in the opposite order
        letters = letters[::-1]
    twice = letters[0] == letters[2]
    third = next(letter for letter in "xyz" if letter not in letters) if twice else letters[2]
    i, j, k = ("xyz".index(letter) for letter in (letters[0], letters[1], third))
    sign = 1.0 if letters[:2] + third in _EVEN else -1.0  # left-handed axes turn the other way
    m = matrix
    if twice:
        size = hypot(m[i][j], m[i][k])
        middle = atan2(size, m[i][i])
        first, last = atan2(m[i][j], m[i][k]), atan2(m[j][i], -m[k][i])
    else:
        size = hypot(m[i][i], m[j][i])
        middle = atan2(-m[k][i], size)
        first, last = atan2(m[k][j], m[k][k]), atan2(m[j][i], m[i][i])
    if size <= EPS:
        first, last = atan2(-m[j][k], m[j][j]), 0.0
    if turning:
        first, last = last, first
    return sign * first, sign * middle, sign * last


# As matrices ----------------------------------------------------------------------------------------------------------


def identity_matrix() -> Matrix:
    """Return the matrix that changes nothing."""
    return [[float(row == column) for column in range(4)] for row in range(4)]


def quaternion_matrix(quaternion: Vector) -> Matrix:
    """Return the matrix of a rotation; the quaternion may have any length but 0, which gives the identity."""
    x, y, z, w = map(float, quaternion)
    square = x * x + y * y + z * z + w * w
    if square < EPS:
        return identity_matrix()
    s = 2.0 / square
    return [
        [1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w), 0.0],
        [s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w), 0.0],
        [s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y), 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]


def quaternion_from_matrix(matrix: Rows) -> list[float]:
    """Return the unit quaternion of the rotation in a matrix of three or four rows.

    Its w is positive, or, where the rotation is more than 120 degrees, its largest other part.
    """
    trace = sum(matrix[row][row] for row in range(3))
    if trace > 0.0:
        root = sqrt(trace + 1.0)
        parts = [(matrix[(i + 2) % 3][(i + 1) % 3] - matrix[(i + 1) % 3][(i + 2) % 3]) / (2.0 * root) for i in range(3)]
        return [*parts, root / 2.0]
    i = max(range(3), key=lambda row: matrix[row][row])
    j, k = (i + 1) % 3, (i + 2) % 3
    root = sqrt(matrix[i][i] - matrix[j][j] - matrix[k][k] + 1.0)
    result = [0.0, 0.0, 0.0, (matrix[k][j] - matrix[j][k]) / (2.0 * root)]
    result[i] = root / 2.0
    result[j] = (matrix[i][j] + matrix[j][i]) / (2.0 * root)
    result[k] = (matrix[i][k] + matrix[k][i]) / (2.0 * root)
    return result
