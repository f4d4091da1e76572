"""Homogeneous matrices, made and multiplied, on lists of floats: see `pyros1.tf.transformations`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import cos, radians, sin, sqrt, tan

from pyros1.tf.quaternions import (
    EPS,
    Matrix,
    Rows,
    Vector,
    dot,
    euler_matrix,
    identity_matrix,
    normalized,
    quaternion_about_axis,
    quaternion_matrix,
    random_quaternion,
)

_PERPENDICULAR = 1e-6


def translation_matrix(direction: Vector) -> Matrix:
    """Return the matrix that moves by a vector."""
    matrix = identity_matrix()
    for row, part in zip(matrix, direction, strict=False):
        row[3] = float(part)
    return matrix


def translation_from_matrix(matrix: Rows) -> list[float]:
    """Return the vector by which a matrix moves."""
    return [float(row[3]) for row in matrix[:3]]


def rotation_matrix(angle: float, direction: Vector, point: Vector | None = None) -> Matrix:
    """Return the matrix that rotates about an axis in a direction, through a point or the origin."""
    rotation = quaternion_matrix(quaternion_about_axis(angle, direction[:3]))
    return rotation if point is None else _about(rotation, point)


def scale_matrix(factor: float, origin: Vector | None = None, direction: Vector | None = None) -> Matrix:
    """Return the matrix that scales about a point or the origin, everywhere or in one direction only."""
    if direction is None:
        return _about(_linear(lambda row, column: factor * (row == column)), origin or (0.0, 0.0, 0.0))
    u = normalized(direction[:3])
    stretched = _linear(lambda row, column: (row == column) + (factor - 1.0) * u[row] * u[column])
    return _about(stretched, origin or (0.0, 0.0, 0.0))


def reflection_matrix(point: Vector, normal: Vector) -> Matrix:
    """Return the matrix that mirrors at the plane through a point, perpendicular to ``normal``."""
    return scale_matrix(-1.0, point, normal)


def shear_matrix(angle: float, direction: Vector, point: Vector, normal: Vector) -> Matrix:
    """Return the matrix that shears by an angle, in a direction, along the plane through a point.

    Args:
        normal: of the plane; perpendicular to ``direction``.

    Raises:
        ValueError: it is not.
    """
    n, d = normalized(normal[:3]), normalized(direction[:3])
    if abs(dot(n, d)) > _PERPENDICULAR:
        raise ValueError("the direction must lie in the plane: perpendicular to its normal")
    factor = tan(angle)
    return _about(_linear(lambda row, column: (row == column) + factor * d[row] * n[column]), point)


def projection_matrix(
    point: Vector,
    normal: Vector,
    direction: Vector | None = None,
    perspective: Vector | None = None,
    pseudo: bool = False,
) -> Matrix:
    """Return the matrix that projects onto the plane through a point.

    Args:
        normal: of the plane.
        direction: along which to project; None and no ``perspective`` means along the normal.
        perspective: the point through which all rays go.
        pseudo: keep the depth behind the plane, so that projecting along the normal afterwards is what is left to do.
    """
    n = normalized(normal[:3])
    height = dot(point[:3], n)
    if perspective is None:
        d = [float(part) for part in (n if direction is None else direction)[:3]]
        steep = dot(d, n)
        return _about(_linear(lambda row, column: (row == column) - d[row] * n[column] / steep), point)
    p = [float(part) for part in perspective[:3]]
    distance = dot(p, n) - height
    # Of a point x: (distance x - p n.x + height p) / (p.n - x.n); pseudo adds what is not in the plane, along n.
    q = [a + b for a, b in zip(p, n, strict=True)] if pseudo else p
    rows = _linear(lambda row, column: distance * (row == column) - q[row] * n[column])
    for row, part in zip(rows, q, strict=False):
        row[3] = height * part
    rows[3] = [-n[0], -n[1], -n[2], dot(p, n)]
    return rows


def clip_matrix(
    left: float, right: float, bottom: float, top: float, near: float, far: float, perspective: bool = False
) -> Matrix:
    """Return the matrix that takes a box, or a frustum seen from the origin, to the cube from -1 to 1.

    Raises:
        ValueError: the box has no volume, or the frustum begins behind the eye.
    """
    if left >= right or bottom >= top or near >= far:
        raise ValueError("the bounds must be: left < right, bottom < top, near < far")
    if not perspective:
        return [
            [2.0 / (right - left), 0.0, 0.0, (right + left) / (left - right)],
            [0.0, 2.0 / (top - bottom), 0.0, (top + bottom) / (bottom - top)],
            [0.0, 0.0, 2.0 / (far - near), (far + near) / (near - far)],
            [0.0, 0.0, 0.0, 1.0],
        ]
    if near <= EPS:
        raise ValueError("a frustum begins in front of the eye: near must be positive")
    return [
        [-2.0 * near / (right - left), 0.0, (right + left) / (right - left), 0.0],
        [0.0, -2.0 * near / (top - bottom), (top + bottom) / (top - bottom), 0.0],
        [0.0, 0.0, -(far + near) / (far - near), 2.0 * near * far / (far - near)],
        [0.0, 0.0, -1.0, 0.0],
    ]


def orthogonalization_matrix(lengths: Vector, angles: Vector) -> Matrix:
    """Return the matrix from a crystal cell's coordinates to perpendicular ones.

    Args:
        lengths: of the cell's edges a, b, c.
        angles: in degrees, between b and c, a and c, a and b.
    """
    a, b, c = map(float, lengths)
    alpha, beta, gamma = map(radians, angles)
    # c along z, b in the plane of y and z; the parts of a follow from its angles with them
    ay = (cos(gamma) - cos(alpha) * cos(beta)) / sin(alpha)
    ax = sqrt(sin(beta) ** 2 - ay * ay)
    return [
        [a * ax, 0.0, 0.0, 0.0],
        [a * ay, b * sin(alpha), 0.0, 0.0],
        [a * cos(beta), b * cos(alpha), c, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]


def compose_matrix(
    scale: Vector | None = None,
    shear: Vector | None = None,
    angles: Vector | None = None,
    translate: Vector | None = None,
    perspective: Vector | None = None,
) -> Matrix:
    """Return the matrix that scales, shears, rotates, moves and projects, in this order; `decompose_matrix` undoes it.

    Args:
        scale: factors of x, y, z.
        shear: of x by y, x by z, y by z.
        angles: roll, pitch and yaw.
        translate: where to move.
        perspective: the matrix's last row.
    """
    result = identity_matrix()
    if perspective is not None:
        result[3] = [float(part) for part in perspective[:4]]
    parts: list[Matrix] = []
    if translate is not None:
        parts.append(translation_matrix(translate[:3]))
    if angles is not None:
        parts.append(euler_matrix(angles[0], angles[1], angles[2]))
    if shear is not None:
        leaning = identity_matrix()
        leaning[0][1], leaning[0][2], leaning[1][2] = (float(part) for part in shear[:3])
        parts.append(leaning)
    if scale is not None:
        factors = scale
        parts.append(_linear(lambda row, column: factors[row] if row == column else 0.0))
    result = concatenate_matrices(result, *parts)
    return [[part / result[3][3] for part in row] for row in result]


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
