"""Points, vectors, orientations, poses and transforms."""

from __future__ import annotations

from typing import Any

import numpy as np

from pyros1.drop_in.missing import missing
from pyros1.msgs.geometry_msgs.msg import Point, Pose, Quaternion, Transform, Vector3
from pyros1.tf import transformations
from ros_numpy.registry import converts_from_numpy, converts_to_numpy

__getattr__ = missing(__name__)


def _many(array: Any, size: int, make: Any) -> Any:
    """Return a list with a message for each row of an array, or just the message for a single row."""
    array = np.asarray(array)
    if array.ndim == size:
        return make(array)
    result = np.empty(array.shape[:-size], object)
    for place in np.ndindex(*result.shape):
        result[place] = make(array[place])
    return result


def _plain(array: Any, last: float, what: str) -> Any:
    """Return the first three coordinates of three or four."""
    array = np.asarray(array)
    if array.shape[-1] == 4:
        if not np.all(array[..., -1] == last):
            raise AssertionError(f"the last of four coordinates of a {what} must be {last:g}")
        return array[..., :-1]
    return array


@converts_to_numpy(Vector3)
def vector3_to_numpy(msg: Any, hom: bool = False) -> Any:
    """Return a vector: shape (3,), or (4,) with 0 at the end if ``hom``."""
    return np.array([msg.x, msg.y, msg.z, 0] if hom else [msg.x, msg.y, msg.z])


@converts_from_numpy(Vector3)
def numpy_to_vector3(arr: Any) -> Any:
    """Return vectors: of shape (..., 3), or (..., 4) with 0 at the end."""
    return _many(_plain(arr, 0, "vector"), 1, lambda row: Vector3(*map(float, row)))


@converts_to_numpy(Point)
def point_to_numpy(msg: Any, hom: bool = False) -> Any:
    """Return a point: shape (3,), or (4,) with 1 at the end if ``hom``."""
    return np.array([msg.x, msg.y, msg.z, 1] if hom else [msg.x, msg.y, msg.z])


@converts_from_numpy(Point)
def numpy_to_point(arr: Any) -> Any:
    """Return points: of shape (..., 3), or (..., 4) in homogeneous coordinates."""
    arr = np.asarray(arr)
    if arr.shape[-1] == 4:
        arr = arr[..., :-1] / arr[..., -1:]
    return _many(arr, 1, lambda row: Point(*map(float, row)))


@converts_to_numpy(Quaternion)
def quat_to_numpy(msg: Any) -> Any:
    """Return an orientation: x, y, z, w."""
    return np.array([msg.x, msg.y, msg.z, msg.w])


@converts_from_numpy(Quaternion)
def numpy_to_quat(arr: Any) -> Any:
    """Return orientations: of shape (..., 4)."""
    return _many(arr, 1, lambda row: Quaternion(*map(float, row)))


def _matrix(place: Any, orientation: Any) -> Any:
    matrix = transformations.quaternion_matrix(quat_to_numpy(orientation))
    matrix[:3, 3] = [place.x, place.y, place.z]
    return matrix


@converts_to_numpy(Transform)
def transform_to_numpy(msg: Any) -> Any:
    """Return a transform as a matrix of shape (4, 4)."""
    return _matrix(msg.translation, msg.rotation)


@converts_from_numpy(Transform)
def numpy_to_transform(arr: Any) -> Any:
    """Return transforms: of shape (..., 4, 4)."""
    return _many(
        arr,
        2,
        lambda matrix: Transform(
            translation=numpy_to_vector3(matrix[:3, 3]),
            rotation=numpy_to_quat(transformations.quaternion_from_matrix(matrix)),
        ),
    )


@converts_to_numpy(Pose)
def pose_to_numpy(msg: Any) -> Any:
    """Return a pose as a matrix of shape (4, 4)."""
    return _matrix(msg.position, msg.orientation)


@converts_from_numpy(Pose)
def numpy_to_pose(arr: Any) -> Any:
    """Return poses: of shape (..., 4, 4)."""
    return _many(
        arr,
        2,
        lambda matrix: Pose(
            position=numpy_to_point(matrix[:3, 3]),
            orientation=numpy_to_quat(transformations.quaternion_from_matrix(matrix)),
        ),
    )
