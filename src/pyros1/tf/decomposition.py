"""What a homogeneous matrix does, found out from its numbers: see `pyros1.tf.transformations`."""

from __future__ import annotations

from math import atan, atan2, cos, hypot, pi, sin, sqrt

from pyros1.tf.matrices import inverse_matrix, translation_from_matrix
from pyros1.tf.quaternions import (
    EPS,
    Matrix,
    Rows,
    Vector,
    cross,
    dot,
    euler_from_matrix,
    identity_matrix,
    normalized,
    quaternion_from_matrix,
    quaternion_matrix,
)

_CLOSE = 1e-8
_SWEEPS = 60


def _affine(matrix: Rows) -> tuple[Matrix, list[float]]:
    """The upper left nine numbers, and the vector by which the matrix moves; a common factor is taken out."""
    scale = float(matrix[3][3])
    if abs(scale) < EPS or hypot(*matrix[3][:3]) > _CLOSE * abs(scale):
        raise ValueError("the matrix projects by perspective")
    return [[part / scale for part in row[:3]] for row in matrix[:3]], [row[3] / scale for row in matrix[:3]]


def _without_identity(linear: Matrix) -> Matrix:
    return [[part - (row == column) for column, part in enumerate(parts)] for row, parts in enumerate(linear)]


def _outer_parts(product: Matrix, problem: str) -> tuple[list[float], list[float]]:
    """Unit vectors u and v of a matrix that is a number times u vT.

    Raises:
        ValueError: it is none.
    """
    columns = [list(column) for column in zip(*product, strict=True)]
    row, column = max(product, key=lambda part: hypot(*part)), max(columns, key=lambda part: hypot(*part))
    size = hypot(*row)
    if size < _CLOSE:
        raise ValueError(problem)
    u, v = normalized(column), normalized(row)
    factor = dot(u, [dot(parts, v) for parts in product])
    if any(abs(product[i][j] - factor * u[i] * v[j]) > _CLOSE * max(1.0, size) for i in range(3) for j in range(3)):
        raise ValueError(problem)
    return u, v


def _homogeneous(point: Vector) -> list[float]:
    return [*point, 1.0]


def rotation_from_matrix(matrix: Rows) -> tuple[float, list[float], list[float]]:
    """Return angle, direction and a point (x, y, z, 1) of the axis about which a matrix rotates.

    Raises:
        ValueError: it does something else, too.
    """
    linear, moved = _affine(matrix)
    quaternion = quaternion_from_matrix(matrix)
    again = quaternion_matrix(quaternion)
    if any(abs(linear[i][j] - again[i][j]) > _CLOSE for i in range(3) for j in range(3)):
        raise ValueError("the matrix is no rotation")
    size = hypot(*quaternion[:3])
    if size < EPS:
        if hypot(*moved) > _CLOSE:
            raise ValueError("the matrix moves, and does not rotate")
        return 0.0, [0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]
    direction = [part / size for part in quaternion[:3]]
    if abs(dot(direction, moved)) > _CLOSE * max(1.0, hypot(*moved)):
        raise ValueError("the matrix rotates about an axis, and moves along it")
    angle = 2.0 * atan2(size, quaternion[3])
    # Perpendicular to the axis it is a rotation in a plane; its fixed point follows from half the way moved.
    aside = cross(direction, moved)
    point = [(along + quaternion[3] / size * across) / 2.0 for along, across in zip(moved, aside, strict=True)]
    return (angle if angle <= pi else angle - 2.0 * pi), direction, _homogeneous(point)


def reflection_from_matrix(matrix: Rows) -> tuple[list[float], list[float]]:
    """Return a point (x, y, z, 1) and the normal of the plane at which a matrix mirrors.

    Raises:
        ValueError: it does something else.
    """
    factor, origin, direction = scale_from_matrix(matrix)
    if direction is None or abs(factor + 1.0) > _CLOSE:
        raise ValueError("the matrix is no reflection")
    return origin, direction


def scale_from_matrix(matrix: Rows) -> tuple[float, list[float], list[float] | None]:
    """Return factor, origin (x, y, z, 1) and direction of a matrix that scales; the direction is None for all.

    Raises:
        ValueError: it does something else.
    """
    linear, moved = _affine(matrix)
    factor = sum(linear[i][i] for i in range(3)) / 3.0
    direction = None
    if any(abs(linear[i][j] - factor * (i == j)) > _CLOSE for i in range(3) for j in range(3)):
        problem = "the matrix scales neither uniformly nor in one direction"
        u, v = _outer_parts(_without_identity(linear), problem)
        if abs(abs(dot(u, v)) - 1.0) > _CLOSE:
            raise ValueError(problem)
        factor, direction = 3.0 * factor - 2.0, u
        if hypot(*cross(u, moved)) > _CLOSE * max(1.0, hypot(*moved)):
            raise ValueError("the matrix also moves, across the direction in which it scales")
    elif abs(factor - 1.0) < _CLOSE:
        if hypot(*moved) > _CLOSE:
            raise ValueError("the matrix moves, and does not scale")
        return 1.0, [0.0, 0.0, 0.0, 1.0], None
    return factor, _homogeneous([part / (1.0 - factor) for part in moved]), direction


def shear_from_matrix(matrix: Rows) -> tuple[float, list[float], list[float], list[float]]:
    """Return angle, direction, a point (x, y, z, 1) and the normal of the plane of a matrix that shears.

    Raises:
        ValueError: it does something else, or nothing.
    """
    linear, moved = _affine(matrix)
    rest = _without_identity(linear)
    direction, normal = _outer_parts(rest, "the matrix is no shear")
    if abs(dot(direction, normal)) > _CLOSE:
        raise ValueError("the matrix is no shear")
    factor = dot(direction, [dot(row, normal) for row in rest])
    if factor < 0:
        factor, direction = -factor, [-part for part in direction]
    height = -dot(direction, moved) / factor
    return atan(factor), direction, _homogeneous([part * height for part in normal]), normal


def projection_from_matrix(
    matrix: Rows, pseudo: bool = False
) -> tuple[list[float], list[float], list[float] | None, list[float] | None, bool]:
    """Return what `projection_matrix` makes the matrix of: point, normal, direction, perspective and pseudo.

    Args:
        pseudo: whether the matrix keeps the depth, which its numbers do not show.

    Raises:
        ValueError: it is no projection.
    """
    size = hypot(*matrix[3][:3])
    if size < _CLOSE and not pseudo:
        linear, moved = _affine(matrix)
        direction, normal = _outer_parts([[-part for part in row] for row in _without_identity(linear)], _NO_PROJECTION)
        if dot(direction, normal) < 0:
            direction = [-part for part in direction]
        return _homogeneous(moved), normal, direction, None, False
    if size < EPS:
        raise ValueError(_NO_PROJECTION)
    normal = [-part / size for part in matrix[3][:3]]
    linear = [[part / size for part in row[:3]] for row in matrix[:3]]
    eye = matrix[3][3] / size
    # See projection_matrix: the numbers are distance - q nT, where the trace of q nT is q.n.
    distance = (sum(linear[i][i] for i in range(3)) + eye + pseudo) / 3.0
    q = [distance * n - dot(row, normal) for n, row in zip(normal, linear, strict=True)]
    perspective = [part - n for part, n in zip(q, normal, strict=True)] if pseudo else q
    return _homogeneous([(eye - distance) * n for n in normal]), normal, None, perspective, pseudo


_NO_PROJECTION = "the matrix is no projection"


def decompose_matrix(
    matrix: Rows,
) -> tuple[list[float], list[float], list[float], list[float], list[float]]:
    """Return scale, shear, angles, translation and perspective: what `compose_matrix` makes the matrix of.

    Raises:
        ValueError: the matrix is singular, or its last number is 0.
    """
    last = float(matrix[3][3])
    if abs(last) < EPS:
        raise ValueError("the last number of the matrix is 0")
    rows = [[part / last for part in row] for row in matrix]
    perspective = [0.0, 0.0, 0.0, 1.0]
    if max(map(abs, rows[3][:3])) > EPS:
        flat = inverse_matrix([*rows[:3], [0.0, 0.0, 0.0, 1.0]])
        perspective = [dot(rows[3], column) for column in zip(*flat, strict=True)]
    # The columns are scaled and leaning axes: made perpendicular from the first to the last (Gram and Schmidt).
    axes: list[list[float]] = []
    scale, lean = [], [[0.0] * 3 for _ in range(3)]
    for number in range(3):
        axis = [row[number] for row in rows[:3]]
        for former, other in enumerate(axes):
            lean[former][number] = dot(axis, other)
            axis = [a - lean[former][number] * b for a, b in zip(axis, other, strict=True)]
        scale.append(hypot(*axis))
        if scale[-1] < EPS:
            raise ValueError("the matrix is singular")
        axes.append(normalized(axis))
    shear = [lean[0][1] / scale[1], lean[0][2] / scale[2], lean[1][2] / scale[2]]
    if dot(axes[0], cross(axes[1], axes[2])) < 0:  # left-handed axes are no rotation
        scale, axes = [-part for part in scale], [[-part for part in axis] for axis in axes]
    angles = euler_from_matrix([list(row) for row in zip(*axes, strict=True)])
    return scale, shear, list(angles), translation_from_matrix(rows), perspective


def superimposition_matrix(v0: Rows, v1: Rows, scaling: bool = False, usesvd: bool = True) -> Matrix:
    """Return the matrix that brings points as near as possible to others: by rotating, moving and, if asked, scaling.

    Args:
        v0: the points' x, y and z, as three rows (more are not looked at).
        v1: where they should be.
        scaling: whether a common factor is found, too.
        usesvd: no matter here; both of stock's ways have the same result.

    Raises:
        ValueError: the rows are not alike, or there are none.
    """
    if min(len(v0), len(v1)) < 3 or len({len(row) for row in (*v0[:3], *v1[:3])}) != 1 or len(v0[0]) == 0:
        raise ValueError("the points must be three rows each, of equal lengths")
    (start, from_rows), (end, to_rows) = _centred(v0[:3]), _centred(v1[:3])
    rotation = quaternion_matrix(_nearest_rotation(from_rows, to_rows))
    factor = 1.0
    if scaling:
        sizes = [sum(part * part for row in rows for part in row) for rows in (from_rows, to_rows)]
        factor = sqrt(sizes[1] / sizes[0])
    matrix = identity_matrix()
    for number, row in enumerate(rotation[:3]):
        scaled = [factor * part for part in row[:3]]
        matrix[number] = [*scaled, end[number] - dot(scaled, start)]
    return matrix


def _centred(rows: Rows) -> tuple[list[float], Matrix]:
    means = [sum(row) / len(row) for row in rows]
    return means, [[float(part) - mean for part in row] for row, mean in zip(rows, means, strict=True)]


def _nearest_rotation(start: Matrix, end: Matrix) -> list[float]:
    """The quaternion q that makes the sum of q start . end the largest.

    That sum is a quadratic form of q (B. K. P. Horn, 1987): wanted is the eigenvector of its largest eigenvalue.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = [[dot(one, other) for other in end] for one in start]
    form = [
        [xx - yy - zz, xy + yx, xz + zx, yz - zy],
        [xy + yx, yy - xx - zz, yz + zy, zx - xz],
        [xz + zx, yz + zy, zz - xx - yy, xy - yx],
        [yz - zy, zx - xz, xy - yx, xx + yy + zz],
    ]
    values, vectors = _eigen(form)
    return vectors[max(range(4), key=values.__getitem__)]


def _eigen(symmetric: Matrix) -> tuple[list[float], Matrix]:
    """Eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's rotations."""
    size = range(len(symmetric))
    a = [list(row) for row in symmetric]
    vectors = [[float(row == column) for column in size] for row in size]
    for _ in range(_SWEEPS):
        pairs = [
            (i, j) for i in size for j in size if i < j and abs(a[i][j]) > EPS * EPS * (abs(a[i][i]) + abs(a[j][j]))
        ]
        if not pairs:
            break
        for i, j in pairs:
            _turn(a, vectors, i, j)
    return [a[i][i] for i in size], vectors


def _turn(a: Matrix, vectors: Matrix, i: int, j: int) -> None:
    """Turn the axes i and j so that a[i][j] becomes 0; the vectors are rows."""
    angle = atan2(2.0 * a[i][j], a[j][j] - a[i][i]) / 2.0
    c, s = cos(angle), sin(angle)
    for row in a:
        row[i], row[j] = c * row[i] - s * row[j], s * row[i] + c * row[j]
    for rows in (a, vectors):
        rows[i], rows[j] = (
            [c * x - s * y for x, y in zip(rows[i], rows[j], strict=True)],
            [s * x + c * y for x, y in zip(rows[i], rows[j], strict=True)],
        )
