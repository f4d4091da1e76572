"""Converts points, vectors, orientations, poses and transforms to numpy arrays, and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.geometry_msgs.msg import Point, Pose, Quaternion, Transform, Vector3
from pyros1.tf import transformations
from ros_numpy.registry import converts_from_numpy, converts_to_numpy

__getattr__ = module_getattr(__name__)


def _convert_items(array: Any, item_ndim: int, convert: Any) -> Any:
    """Convert each item (row or matrix) of an array to a message; return an array of messages or, for a single item,
    the message.
    """
    array = np.asarray(array)
    if array.ndim == item_ndim:
        return convert(array)
    result = np.empty(array.shape[:-item_ndim], object)
    for index in np.ndindex(*result.shape):
        result[index] = convert(array[index])
    return result


def _remove_fourth(array: Any, expected_last: float, type_name: str) -> Any:
    """Remove the fourth coordinate, if there is one; raise AssertionError if it is not the expected value."""
    array = np.asarray(array)
    if array.shape[-1] == 4:
        if not np.all(array[..., -1] == expected_last):
            raise AssertionError(f"the last of four coordinates of a {type_name} must be {expected_last:g}")
        return array[..., :-1]
    return array


@converts_to_numpy(Vector3)
def vector3_to_numpy(msg: Any, hom: bool = False) -> Any:
    """Convert a vector to an array of shape (3,), or (4,) with 0 at the end if ``hom``."""
    return np.array([msg.x, msg.y, msg.z, 0] if hom else [msg.x, msg.y, msg.z])


@converts_from_numpy(Vector3)
def numpy_to_vector3(arr: Any) -> Any:
    """Convert an array of shape (..., 3), or (..., 4) with 0 at the end, to vectors."""
    return _convert_items(_remove_fourth(arr, 0, "vector"), 1, lambda row: Vector3(*map(float, row)))


@converts_to_numpy(Point)
def point_to_numpy(msg: Any, hom: bool = False) -> Any:
    """Convert a point to an array of shape (3,), or (4,) with 1 at the end if ``hom``."""
    return np.array([msg.x, msg.y, msg.z, 1] if hom else [msg.x, msg.y, msg.z])


@converts_from_numpy(Point)
def numpy_to_point(arr: Any) -> Any:
    """Convert an array of shape (..., 3), or (..., 4) in homogeneous coordinates, to points."""
    arr = np.asarray(arr)
    if arr.shape[-1] == 4:
        arr = arr[..., :-1] / arr[..., -1:]
    return _convert_items(arr, 1, lambda row: Point(*map(float, row)))


@converts_to_numpy(Quaternion)
def quat_to_numpy(msg: Any) -> Any:
    """Convert an orientation to an array: x, y, z, w."""
    return np.array([msg.x, msg.y, msg.z, msg.w])


@converts_from_numpy(Quaternion)
def numpy_to_quat(arr: Any) -> Any:
    """Convert an array of shape (..., 4) to orientations."""
    return _convert_items(arr, 1, lambda row: Quaternion(*map(float, row)))


def _pose_matrix(position: Any, orientation: Any) -> Any:
    matrix = transformations.quaternion_matrix(quat_to_numpy(orientation))
    matrix[:3, 3] = [position.x, position.y, position.z]
    return matrix


@converts_to_numpy(Transform)
def transform_to_numpy(msg: Any) -> Any:
    """Convert a transform to a matrix of shape (4, 4)."""
    return _pose_matrix(msg.translation, msg.rotation)


@converts_from_numpy(Transform)
def numpy_to_transform(arr: Any) -> Any:
    """Convert an array of shape (..., 4, 4) to transforms."""
    return _convert_items(
        arr,
        2,
        lambda matrix: Transform(
            translation=numpy_to_vector3(matrix[:3, 3]),
            rotation=numpy_to_quat(transformations.quaternion_from_matrix(matrix)),
        ),
    )


@converts_to_numpy(Pose)
def pose_to_numpy(msg: Any) -> Any:
    """Convert a pose to a matrix of shape (4, 4)."""
    return _pose_matrix(msg.position, msg.orientation)


@converts_from_numpy(Pose)
def numpy_to_pose(arr: Any) -> Any:
    """Convert an array of shape (..., 4, 4) to poses."""
    return _convert_items(
        arr,
        2,
        lambda matrix: Pose(
            position=numpy_to_point(matrix[:3, 3]),
            orientation=numpy_to_quat(transformations.quaternion_from_matrix(matrix)),
        ),
    )
