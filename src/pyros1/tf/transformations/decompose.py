"""Extracts parameters of homogeneous matrices, such as the axis of a rotation; see `pyros1.tf.transformations`."""

from __future__ import annotations

from math import atan, atan2

import numpy as np
from numpy.typing import ArrayLike

from pyros1.tf.rotation import EPS
from pyros1.tf.transformations.angles import euler_from_matrix
from pyros1.tf.transformations.vectors import Array, unit_vector

_TOLERANCE = 1e-8
_MIN_ANGLE = 1e-12  # a smaller rotation or shear is a rounding error


def translation_from_matrix(matrix: ArrayLike) -> Array:
    """Return the translation vector (3,) of a matrix (4, 4)."""
    m = np.asarray(matrix, np.float64)
    return np.array(m[:3, 3])


def rotation_from_matrix(matrix: ArrayLike) -> tuple[float, Array, Array]:
    """Return the angle by which a matrix (4, 4) rotates, and the direction (3,) and a point (x, y, z, 1) of the axis.

    The point is the axis's nearest point to the origin, even if the matrix also translates along the axis.

    Raises:
        ValueError: the matrix is not a rotation.
    """
    m = np.asarray(matrix, np.float64)
    point, rotation = _fixed_point(m), m[:3, :3]
    direction = _eigenvector(rotation.T, 1.0)
    double_sine = direction @ (
        rotation[2, 1] - rotation[1, 2],
        rotation[0, 2] - rotation[2, 0],
        rotation[1, 0] - rotation[0, 1],
    )
    return atan2(double_sine, rotation.trace() - 1.0), direction, point


def reflection_from_matrix(matrix: ArrayLike) -> tuple[Array, Array]:
    """Return a point (x, y, z, 1) and the normal (3,) of the plane in which a matrix (4, 4) reflects.

    The point is the one on the plane that is nearest to the origin.

    Raises:
        ValueError: the matrix is not a reflection.
    """
    m = np.asarray(matrix, np.float64)
    normal = _eigenvector(m[:3, :3], -1.0)
    return _fixed_point(m), normal


def scale_from_matrix(matrix: ArrayLike) -> tuple[float, Array, Array | None]:
    """Return the factor, origin (x, y, z, 1) and direction (3,) of a matrix (4, 4) that scales; the direction is None
    if the matrix scales equally in all directions.

    Raises:
        ValueError: the last row of the matrix is not 0, 0, 0, 1, or the matrix contains infinite numbers or nan.
    """
    m = np.asarray(matrix, np.float64)
    origin, trace = _fixed_point(m), float(m[:3, :3].trace())
    try:
        return trace - 2.0, origin, _eigenvector(m[:3, :3], trace - 2.0)
    except ValueError:
        return trace / 3.0, origin, None


def shear_from_matrix(matrix: ArrayLike) -> tuple[float, Array, Array, Array]:
    """Return the angle and direction (3,) in which a matrix (4, 4) shears, and a point (x, y, z, 1) and the normal (3,)
    of the plane.

    The point is the one on the plane that is nearest to the origin.

    Raises:
        ValueError: the matrix is not a shear.
    """
    m = np.asarray(matrix, np.float64)
    point = _fixed_point(m)
    directions, (size, *others), normals = np.linalg.svd(m[:3, :3] - np.identity(3))
    direction, normal = directions[:, 0], normals[0]
    if size < _TOLERANCE or max(*others, abs(direction @ normal)) > _TOLERANCE:
        raise ValueError("the matrix is not a shear")
    return atan(size), direction, point, normal


def projection_from_matrix(
    matrix: ArrayLike, pseudo: bool = False
) -> tuple[Array, Array, Array | None, Array | None, bool]:
    """Return the arguments with which `projection_matrix` creates a matrix (4, 4).

    Args:
        matrix: a projection matrix (4, 4).
        pseudo: whether the projection keeps the depth, which cannot be inferred from the matrix.

    Returns:
        The plane's point nearest to the origin (x, y, z, 1), its normal (3,), direction (3,) and perspective (3,) (one
        of these two is None), and pseudo.

    Raises:
        ValueError: the matrix is not a projection.
    """
    m = np.asarray(matrix, np.float64)
    size = np.linalg.norm(m[3, :3])
    if size < _TOLERANCE and not pseudo:
        return _fixed_point(m), _eigenvector(m[:3, :3].T, 0.0), _eigenvector(m[:3, :3], 0.0), None, False
    if size < EPS:
        raise ValueError("the matrix is not a projection")
    linear, normal, eye = m[:3, :3] / size, -m[3, :3] / size, m[3, 3] / size
    # As in projection_matrix, the 3x3 part is distance times the identity minus q nT, where the trace of q nT is q.n.
    distance = (linear.trace() + eye + pseudo) / 3.0
    perspective = distance * normal - linear @ normal - pseudo * normal
    return np.append((eye - distance) * normal, 1.0), normal, None, perspective, pseudo


def decompose_matrix(matrix: ArrayLike) -> tuple[Array, list[float], list[float], Array, Array]:
    """Return scale (3,), shear, angles, translation (3,) and perspective (4,), the arguments of `compose_matrix`.

    Raises:
        ValueError: the matrix (4, 4) is singular, or its last element is 0.
    """
    m = np.asarray(matrix, np.float64)
    if abs(m[3, 3]) < EPS:
        raise ValueError("the last element of the matrix is 0")
    m = m / m[3, 3]
    affine = m.copy()
    affine[3] = 0.0, 0.0, 0.0, 1.0
    if not np.linalg.det(affine):
        raise ValueError("the matrix is singular")
    rotation, upper = np.linalg.qr(m[:3, :3])
    signs = np.copysign(1.0, upper.diagonal())
    signs *= np.sign(np.linalg.det(rotation * signs))  # a rotation has right-handed axes
    rotation, upper = rotation * signs, (upper.T * signs).T
    scale = upper.diagonal().copy()
    shear: list[float] = (upper / scale)[[0, 0, 1], [1, 2, 2]].tolist()
    return scale, shear, list(euler_from_matrix(rotation)), m[:3, 3].copy(), m[3] @ np.linalg.inv(affine)


def _eigenvector(matrix: Array, eigenvalue: float) -> Array:
    """Return the unit eigenvector (3,) of a matrix (3, 3) for an eigenvalue; the last one if there are several.

    Raises:
        ValueError: the matrix does not have the eigenvalue.
    """
    eigenvalues, vectors = np.linalg.eig(matrix)
    differences = abs(eigenvalues - eigenvalue)[::-1]
    nearest = differences.argmin()
    if not differences[nearest] < _TOLERANCE:
        raise ValueError(f"the matrix has no eigenvalue {eigenvalue:g}, so it is not of the expected kind")
    return unit_vector(vectors[:, 2 - nearest].real)


def _fixed_point(matrix: Array) -> Array:
    """Return the point (x, y, z, 1) that a 4x4 matrix moves the least; of several, the one nearest to the origin.

    Raises:
        ValueError: the matrix's last row is not 0, 0, 0, 1, or the matrix contains infinite numbers or nan.
    """
    if not np.isfinite(matrix).all():  # LAPACK can hang on inf and nan
        raise ValueError("the matrix contains infinite numbers or nan")
    if not abs(matrix[3] - (0.0, 0.0, 0.0, 1.0)).max() < _TOLERANCE:
        raise ValueError("the last row of the matrix must be 0, 0, 0, 1")
    displacement = np.identity(3) - matrix[:3, :3]
    displacement[abs(displacement) < _MIN_ANGLE] = 0.0
    return np.append(np.linalg.lstsq(displacement, matrix[:3, 3], _TOLERANCE)[0], 1.0)
