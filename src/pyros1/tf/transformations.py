"""Rotations and homogeneous matrices: the functions of ``tf.transformations`` that programs use, on lists of floats.

A quaternion is [x, y, z, w], a matrix a list of four rows. Results are new lists; arguments may be any sequences, numpy
arrays included. Angles are radians.

Euler angles are named by four letters: ``s`` (about the axes that stand still) or ``r`` (about the axes that turn with
it), and three axes in the order of rotation. ``sxyz`` is ROS's roll, pitch, yaw; ``rzyx`` the same from yaw to roll.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from math import acos, atan2, cos, hypot, pi, sin, sqrt

Vector = Sequence[float]
Matrix = list[list[float]]
Rows = Sequence[Sequence[float]]

_EPS = 4 * 2.0**-52
_EVEN = ("xyz", "yzx", "zxy")


# Vectors --------------------------------------------------------------------------------------------------------------


def vector_norm(vector: Vector) -> float:
    """Return a vector's length."""
    return hypot(*vector)


def unit_vector(vector: Vector) -> list[float]:
    """Return the vector of length 1 in the same direction."""
    length = hypot(*vector)
    return [part / length for part in vector]


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
    scale = sin(angle / 2.0) / length if length > _EPS else 1.0
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
    start, end = unit_vector(quat0), unit_vector(quat1)
    if fraction in (0.0, 1.0):
        return end if fraction else start
    dot = sum(a * b for a, b in zip(start, end, strict=True))
    if abs(abs(dot) - 1.0) < _EPS:
        return start
    if shortestpath and dot < 0.0:
        dot, end = -dot, [-part for part in end]
    angle = acos(dot) + spin * pi
    if abs(angle) < _EPS:
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


def _axes(axes: str) -> tuple[bool, str]:
    """Return whether the axes turn, and their letters."""
    frame, letters = axes[:1], axes[1:]
    if frame not in ("s", "r") or len(letters) != 3 or set(letters) - set("xyz") or letters[1] in letters[::2]:
        raise ValueError(f"axes must be s or r and three of x, y, z, no two alike in a row, not {axes!r}")
    return frame == "r", letters


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = "sxyz") -> list[float]:
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


def euler_from_quaternion(quaternion: Vector, axes: str = "sxyz") -> tuple[float, float, float]:
    """Return the angles of a rotation, by default (roll, pitch, yaw)."""
    return euler_from_matrix(quaternion_matrix(quaternion), axes)


def euler_matrix(ai: float, aj: float, ak: float, axes: str = "sxyz") -> Matrix:
    """Return the matrix of three rotations, by default roll, pitch and yaw."""
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes))


def euler_from_matrix(matrix: Rows, axes: str = "sxyz") -> tuple[float, float, float]:
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
    if size <= _EPS:
        first, last = atan2(-m[j][k], m[j][j]), 0.0
    if turning:
        first, last = last, first
    return sign * first, sign * middle, sign * last


# Matrices -------------------------------------------------------------------------------------------------------------


def identity_matrix() -> Matrix:
    """Return the matrix that changes nothing."""
    return [[float(row == column) for column in range(4)] for row in range(4)]


def translation_matrix(direction: Vector) -> Matrix:
    """Return the matrix that moves by a vector."""
    matrix = identity_matrix()
    for row, part in zip(matrix, direction, strict=False):
        row[3] = float(part)
    return matrix


def translation_from_matrix(matrix: Rows) -> list[float]:
    """Return the vector by which a matrix moves."""
    return [float(row[3]) for row in matrix[:3]]


def quaternion_matrix(quaternion: Vector) -> Matrix:
    """Return the matrix of a rotation; the quaternion may have any length but 0, which gives the identity."""
    x, y, z, w = map(float, quaternion)
    square = x * x + y * y + z * z + w * w
    if square < _EPS:
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


def rotation_matrix(angle: float, direction: Vector, point: Vector | None = None) -> Matrix:
    """Return the matrix that rotates about an axis in a direction, through a point or the origin."""
    rotation = quaternion_matrix(quaternion_about_axis(angle, direction[:3]))
    return rotation if point is None else _about(rotation, point)


def scale_matrix(factor: float, origin: Vector | None = None, direction: Vector | None = None) -> Matrix:
    """Return the matrix that scales about a point or the origin, everywhere or in one direction only."""
    if direction is None:
        return _about(_linear(lambda row, column: factor * (row == column)), origin or (0.0, 0.0, 0.0))
    u = unit_vector(direction[:3])
    stretched = _linear(lambda row, column: (row == column) + (factor - 1.0) * u[row] * u[column])
    return _about(stretched, origin or (0.0, 0.0, 0.0))


def reflection_matrix(point: Vector, normal: Vector) -> Matrix:
    """Return the matrix that mirrors at the plane through a point, perpendicular to ``normal``."""
    return scale_matrix(-1.0, point, normal)


def random_rotation_matrix(rand: Sequence[float] | None = None) -> Matrix:
    """Return the matrix of `random_quaternion`."""
    return quaternion_matrix(random_quaternion(rand))


def concatenate_matrices(*matrices: Rows) -> Matrix:
    """Return the product of matrices: the last is applied first."""
    result = identity_matrix()
    for matrix in matrices:
        result = [[sum(row[n] * matrix[n][column] for n in range(4)) for column in range(4)] for row in result]
    return result


def inverse_matrix(matrix: Rows) -> Matrix:
    """Return the matrix that undoes what this one does.

    Raises:
        ValueError: there is none.
    """
    size = len(matrix)
    work = [[*map(float, row), *(float(number == n) for n in range(size))] for number, row in enumerate(matrix)]
    for column in range(size):  # Gauss and Jordan, with the largest pivot
        pivot = max(range(column, size), key=lambda row: abs(work[row][column]))
        if work[pivot][column] == 0.0:
            raise ValueError("the matrix has no inverse")
        work[column], work[pivot] = work[pivot], work[column]
        leader = [part / work[column][column] for part in work[column]]
        work[column] = leader
        for number, row in enumerate(work):
            if number != column and row[column]:
                work[number] = [part - row[column] * other for part, other in zip(row, leader, strict=True)]
    return [row[size:] for row in work]


def is_same_transform(matrix0: Rows, matrix1: Rows) -> bool:
    """Tell whether two matrices do the same; a common factor does not matter."""
    return all(
        abs(a / matrix0[3][3] - b / matrix1[3][3]) <= 1e-8 + 1e-5 * abs(b / matrix1[3][3])
        for row0, row1 in zip(matrix0, matrix1, strict=True)
        for a, b in zip(row0, row1, strict=True)
    )


def _linear(element: Callable[[int, int], float]) -> Matrix:
    rows = [[float(element(row, column)) for column in range(3)] + [0.0] for row in range(3)]
    return [*rows, [0.0, 0.0, 0.0, 1.0]]


def _about(matrix: Matrix, point: Vector) -> Matrix:
    """Return what does the same about a point that ``matrix`` does about the origin."""
    p = [float(part) for part in point[:3]]
    for number, row in enumerate(matrix[:3]):
        row[3] = p[number] - sum(row[n] * p[n] for n in range(3))
    return matrix
