"""Converts PyKDL.Frame to and from messages, tf's tuples and matrices. This needs PyKDL, a compiled library."""

from __future__ import annotations

from typing import Any

import numpy
import rospy
from tf import transformations

from pyros1.msgs.geometry_msgs.msg import Point, Pose, Quaternion


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    try:
        return getattr(_import_kdl(), name)  # stock's module has all of PyKDL's names
    except ImportError as error:
        raise AttributeError(f"pyros1 has no tf_conversions.{name}: {error}") from None


def _import_kdl() -> Any:
    try:
        import PyKDL  # type: ignore[import-not-found]
    except ImportError:
        raise ImportError("tf_conversions.posemath converts types of PyKDL, which is not installed") from None
    return PyKDL


def _make_frame(position: Any, orientation: Any) -> Any:
    kdl = _import_kdl()
    return kdl.Frame(kdl.Rotation.Quaternion(*map(float, orientation)), kdl.Vector(*map(float, position)))


def fromTf(tf: Any) -> Any:
    """Return the frame for a translation (3,) and a quaternion (4,), a pair as `lookupTransform` returns it."""
    return _make_frame(*tf)


def toTf(f: Any) -> Any:
    """Return translation (x, y, z) and quaternion (x, y, z, w) of a frame."""
    return (f.p[0], f.p[1], f.p[2]), tuple(f.M.GetQuaternion())


def fromMsg(p: Any) -> Any:
    """Return the frame for a geometry_msgs/Pose."""
    position, orientation = p.position, p.orientation
    return _make_frame(
        (position.x, position.y, position.z), (orientation.x, orientation.y, orientation.z, orientation.w)
    )


def toMsg(f: Any) -> Any:
    """Return a frame as a geometry_msgs/Pose."""
    position, orientation = toTf(f)
    return Pose(Point(*position), Quaternion(*orientation))


def fromMatrix(m: Any) -> Any:
    """Return the frame for a matrix (4, 4)."""
    kdl = _import_kdl()
    m = numpy.asarray(m, numpy.float64)
    return kdl.Frame(kdl.Rotation(*m[:3, :3].ravel().tolist()), kdl.Vector(*m[:3, 3].tolist()))


def toMatrix(f: Any) -> Any:
    """Return a frame as a matrix (4, 4)."""
    return numpy.array([[f[row, column] for column in range(4)] for row in range(3)] + [[0.0, 0.0, 0.0, 1.0]])


def fromCameraParams(cv: Any, rvec: Any, tvec: Any) -> Any:
    """Return the frame for the vectors (3,) that OpenCV's calibration returns; ``cv`` is the module cv2."""
    rotation, _ = cv.Rodrigues(numpy.asarray(rvec, numpy.float64).reshape(3))
    matrix = numpy.identity(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = numpy.asarray(tvec, numpy.float64).reshape(3)
    return fromMatrix(matrix)
