"""Transforms points from one frame to another, using the transforms that a node receives."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.tf.buffer import Buffer, Span, When
from pyros1.tf.transformations import quaternion_matrix


def lookup_matrix(
    buffer: Buffer, target_frame: str, source_frame: str, time: When = None, timeout: Span = None
) -> NDArray[np.float64]:
    """Return the matrix, of shape (4, 4), that converts points from one frame to another.

    Takes the same arguments and raises the same errors as `Buffer.lookup_transform`, but frames may begin with a slash,
    as in old launch files.
    """
    frames = target_frame.lstrip("/"), source_frame.lstrip("/")
    transform = buffer.lookup_transform(*frames, time, timeout).transform
    matrix: NDArray[np.float64] = quaternion_matrix(components(transform.rotation, "xyzw"))
    matrix[:3, 3] = components(transform.translation, "xyz")
    return matrix


def components(message: Any, names: str) -> list[float]:
    """Return the fields of a message with the given one-letter names."""
    return [getattr(message, name) for name in names]


def transform_points(matrix: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points, of shape (n, 3), multiplied with a matrix of shape (4, 4)."""
    # Not a matrix product: for such narrow matrices, the library's threads cost ten times as much as the computation.
    x, y, z = points.T
    moved = np.empty_like(points)
    for axis, (by_x, by_y, by_z, offset) in enumerate(matrix[:3].tolist()):
        moved[:, axis] = by_x * x + by_y * y + by_z * z + offset
    return moved
