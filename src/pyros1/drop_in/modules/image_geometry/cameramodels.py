"""Models of pinhole cameras and stereo pairs (https://wiki.ros.org/image_geometry), from sensor_msgs/CameraInfo (REP
104).

K, D, R and P are defined as in that message: D distorts a ray (x, y, 1) of the camera, and K converts it to a pixel of
the raw image; R rotates the ray, and P converts it to a pixel of the rectified image.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr("image_geometry.cameramodels", cv2="it uses numpy instead")

_UNDISTORTION_STEPS = 5
"""Number of iterations to undistort a ray, as in stock's library."""
_SUBPIXEL_STEPS = 32
"""Number of steps per pixel when interpolating colours."""
_CUBIC_COEFFICIENT = -0.75
"""Coefficient of cubic interpolation, as in stock's library."""


def mkmat(rows: int, cols: int, L: Sequence[float]) -> Any:
    """Return a numpy matrix from numbers listed row by row; raises ValueError if there are too few or too many."""
    return np.matrix(L, dtype="float64").reshape(rows, cols)


class PinholeCameraModel:
    """A pinhole camera, with conversions between raw images, rectified images and 3D.

    Attributes:
        K, R, P, D: matrices of float64, [3, 3], [3, 3], [3, 4] and [n, 1], as in CameraInfo, but adjusted for the
            region of interest and the binning; D is None without coefficients.
        full_K, full_P: K and P of the whole image.
        width, height, resolution: size of the whole image, in pixels.
        binning_x, binning_y, raw_roi: binning and region of interest of the raw image.
        tf_frame, stamp: frame and time stamp of the message.
    """

    def __init__(self) -> None:
        self.K: Any = None
        self.D: Any = None
        self.R: Any = None
        self.P: Any = None
        self.full_K: Any = None
        self.full_P: Any = None
        self.width: Any = None
        self.height: Any = None
        self.binning_x: Any = None
        self.binning_y: Any = None
        self.raw_roi: Any = None
        self.tf_frame: Any = None
        self.stamp: Any = None

    def fromCameraInfo(self, msg: Any) -> None:
        """Set all values from a sensor_msgs/CameraInfo."""
        self.K = mkmat(3, 3, msg.K)
        self.D = mkmat(len(msg.D), 1, msg.D) if msg.D else None
        self.R = mkmat(3, 3, msg.R)
        self.P = mkmat(3, 4, msg.P)
        self.full_K, self.full_P = self.K.copy(), self.P.copy()
        self.width, self.height = self.resolution = msg.width, msg.height
        self.binning_x, self.binning_y = max(1, msg.binning_x), max(1, msg.binning_y)
        self.raw_roi = roi = copy.copy(msg.roi)
        if not (roi.x_offset or roi.y_offset or roi.width or roi.height):
            roi.width, roi.height = msg.width, msg.height
        self.tf_frame, self.stamp = msg.header.frame_id, msg.header.stamp
        for row, offset, binning in ((0, roi.x_offset, self.binning_x), (1, roi.y_offset, self.binning_y)):
            for matrix in (self.K, self.P):
                matrix[row, 2] -= offset
                matrix[row] /= binning

    # Pixels and rays --------------------------------------------------------------------------------------------------

    def rectifyImage(self, raw: Any, rectified: Any) -> None:
        """Rectify an image.

        Args:
            raw: the raw image: an array [height, width] or [height, width, channels].
            rectified: an array of the same shape and type for the result; pixels outside the raw image become 0.
        """
        v, u = np.mgrid[: self.height, : self.width].astype(float)
        pixel_to_ray = np.linalg.inv(np.asarray(self.P)[:, :3] @ np.asarray(self.R))
        x, y, w = np.tensordot(pixel_to_ray, np.stack([u, v, np.ones_like(u)]), 1)
        x, y = self._distort(x / w, y / w)
        K = np.asarray(self.K)
        _sample(raw, K[0, 0] * x + K[0, 2], K[1, 1] * y + K[1, 2], rectified)

    def rectifyPoint(self, uv_raw: Sequence[float]) -> Any:
        """Return the rectified pixel, an array [2], for a raw pixel (u, v)."""
        K, R, P = (np.asarray(matrix) for matrix in (self.K, self.R, self.P))
        with np.errstate(all="ignore"):
            x0 = (uv_raw[0] - K[0, 2]) / K[0, 0]
            y0 = (uv_raw[1] - K[1, 2]) / K[1, 1]
            x, y = self._undistort(x0, y0)
            ray = R @ (x, y, 1.0)
            pixel = P[:, :3] @ (ray / ray[2])
            return pixel[:2] / pixel[2]

    def project3dToPixel(self, point: Sequence[float]) -> tuple[float, float]:
        """Return the rectified pixel (u, v) of a point (x, y, z), in metres in the camera's frame; NaN if z is 0."""
        u, v, w = np.asarray(self.P) @ (point[0], point[1], point[2], 1.0)
        return (u / w, v / w) if w != 0 else (math.nan, math.nan)

    def projectPixelTo3dRay(self, uv: Sequence[float]) -> tuple[float, float, float]:
        """Return the unit vector (x, y, z) from the camera towards a rectified pixel (u, v)."""
        x, y = (uv[0] - self.cx()) / self.fx(), (uv[1] - self.cy()) / self.fy()
        length = math.sqrt(x * x + y * y + 1.0)
        return x / length, y / length, 1.0 / length

    def getDeltaU(self, deltaX: float, Z: float) -> float:
        """Convert ``deltaX``, in metres to the right at a distance of ``Z`` metres, to pixels; infinite if ``Z``
        is 0.
        """
        return math.inf if Z == 0 else self.fx() * deltaX / Z

    def getDeltaV(self, deltaY: float, Z: float) -> float:
        """Convert ``deltaY``, in metres down at a distance of ``Z`` metres, to pixels; infinite if ``Z`` is 0."""
        return math.inf if Z == 0 else self.fy() * deltaY / Z

    def getDeltaX(self, deltaU: float, Z: float) -> float:
        """Convert ``deltaU``, in pixels to the right, to metres at a distance of ``Z`` metres."""
        return Z * deltaU / self.fx()

    def getDeltaY(self, deltaV: float, Z: float) -> float:
        """Convert ``deltaV``, in pixels down, to metres at a distance of ``Z`` metres."""
        return Z * deltaV / self.fy()

    def _coefficients(self) -> list[float]:
        """Return k1, k2, p1, p2, k3, k4, k5, k6 of the models plumb_bob and rational_polynomial."""
        coefficients = [] if self.D is None else np.asarray(self.D).ravel().tolist()
        return (coefficients + [0.0] * 8)[:8]

    def _distortion(self, x: Any, y: Any) -> tuple[Any, Any, Any]:
        """Return a ray's radial distortion, as a factor, and its tangential distortion, to the right and down."""
        k1, k2, p1, p2, k3, k4, k5, k6 = self._coefficients()
        r2 = x * x + y * y
        factor = (1 + ((k3 * r2 + k2) * r2 + k1) * r2) / (1 + ((k6 * r2 + k5) * r2 + k4) * r2)
        right = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        down = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return factor, right, down

    def _distort(self, x: Any, y: Any) -> tuple[Any, Any]:
        factor, right, down = self._distortion(x, y)
        return x * factor + right, y * factor + down

    def _undistort(self, x0: Any, y0: Any) -> tuple[Any, Any]:
        """Return the ray that is distorted to (x0, y0), by iteration since there is no closed formula."""
        x, y = x0, y0
        if self.D is None:
            return x, y
        for _ in range(_UNDISTORTION_STEPS):
            factor, right, down = self._distortion(x, y)
            if factor < 0:  # far outside the image
                return x0, y0
            x, y = (x0 - right) / factor, (y0 - down) / factor
        return x, y

    # Values -----------------------------------------------------------------------------------------------------------

    def fullResolution(self) -> tuple[int, int]:
        """Return width and height of the whole image."""
        return self.resolution

    def intrinsicMatrix(self) -> Any:
        """Return K, [3, 3]."""
        return self.K

    def distortionCoeffs(self) -> Any:
        """Return D, [n, 1], or None."""
        return self.D

    def rotationMatrix(self) -> Any:
        """Return R, [3, 3]."""
        return self.R

    def projectionMatrix(self) -> Any:
        """Return P, [3, 4]."""
        return self.P

    def fullIntrinsicMatrix(self) -> Any:
        """Return K of the whole image, [3, 3]."""
        return self.full_K

    def fullProjectionMatrix(self) -> Any:
        """Return P of the whole image, [3, 4]."""
        return self.full_P

    def cx(self) -> float:
        """Return the column of the optical axis."""
        return self.P[0, 2]

    def cy(self) -> float:
        """Return the row of the optical axis."""
        return self.P[1, 2]

    def fx(self) -> float:
        """Return the horizontal focal length in pixels."""
        return self.P[0, 0]

    def fy(self) -> float:
        """Return the vertical focal length in pixels."""
        return self.P[1, 1]

    def Tx(self) -> float:
        """Return P[0, 3]: minus the focal length times the horizontal distance to a stereo pair's other camera."""
        return self.P[0, 3]

    def Ty(self) -> float:
        """Return P[1, 3]: minus the focal length times the vertical distance to a stereo pair's other camera."""
        return self.P[1, 3]

    def fovX(self) -> float:
        """Return the horizontal angle of view in radians."""
        return 2 * math.atan(self.width / (2 * self.fx()))

    def fovY(self) -> float:
        """Return the vertical angle of view in radians."""
        return 2 * math.atan(self.height / (2 * self.fy()))

    def tfFrame(self) -> Any:
        """Return the camera's frame."""
        return self.tf_frame


class StereoCameraModel:
    """Two cameras with parallel optical axes.

    Attributes:
        left, right: each a `PinholeCameraModel`.
        Q: array [4, 4] that converts (u, v, disparity, 1) to a point.
    """

    def __init__(self) -> None:
        self.left = PinholeCameraModel()
        self.right = PinholeCameraModel()

    def fromCameraInfo(self, left_msg: Any, right_msg: Any) -> None:
        """Set all values from two sensor_msgs/CameraInfo."""
        self.left.fromCameraInfo(left_msg)
        self.right.fromCameraInfo(right_msg)
        self.Q = np.zeros((4, 4))
        self.Q[0, 0] = self.Q[1, 1] = 1.0
        self.Q[0, 3], self.Q[1, 3], self.Q[2, 3] = -self.right.cx(), -self.right.cy(), self.right.fx()
        with np.errstate(divide="ignore"):
            self.Q[3, 2] = -1.0 / (self.right.Tx() / self.right.fx())

    def tfFrame(self) -> Any:
        """Return the frame of the left camera, in which points are given."""
        return self.left.tfFrame()

    def project3dToPixel(self, point: Sequence[float]) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the rectified pixels of a point (x, y, z), in metres, in the left and in the right image."""
        return self.left.project3dToPixel(point), self.right.project3dToPixel(point)

    def projectPixelTo3d(self, left_uv: Sequence[float], disparity: float) -> tuple[float, float, float]:
        """Return the point (x, y, z), in metres, of a rectified pixel of the left image; zeros without a disparity."""
        x, y, z, w = self.Q @ (left_uv[0], left_uv[1], disparity, 1.0)
        return (x / w, y / w, z / w) if w != 0 else (0.0, 0.0, 0.0)

    def getZ(self, disparity: float) -> float:
        """Return the distance, in metres, of points with a disparity in pixels; infinite for 0."""
        return math.inf if disparity == 0 else -self.right.Tx() / disparity

    def getDisparity(self, Z: float) -> float:
        """Return the disparity, in pixels, of points at a distance in metres; infinite for 0."""
        return math.inf if Z == 0 else -self.right.Tx() / Z


def _sample(raw: Any, u: Any, v: Any, out: Any) -> None:
    """Set ``out`` to the colours at positions (u, v) in an image, by cubic interpolation, or to 0 outside the image."""
    columns, rows = (
        np.rint(np.clip(coordinates, -1e6, 1e6) * _SUBPIXEL_STEPS).astype(np.int64) for coordinates in (u, v)
    )
    height, width = raw.shape[:2]
    padded = np.zeros((height + 8, width + 8, *raw.shape[2:]))
    padded[4:-4, 4:-4] = raw
    left, top = (np.clip(columns // _SUBPIXEL_STEPS, -3, width + 1), np.clip(rows // _SUBPIXEL_STEPS, -3, height + 1))
    total = np.zeros((*u.shape, *raw.shape[2:]))
    across, along = (_weights((positions % _SUBPIXEL_STEPS) / _SUBPIXEL_STEPS) for positions in (columns, rows))
    for j in range(4):
        for i in range(4):
            weight = along[j] * across[i]
            total += padded[top + j + 3, left + i + 3] * weight.reshape(weight.shape + (1,) * (raw.ndim - 2))
    if np.issubdtype(out.dtype, np.integer):
        limits = np.iinfo(out.dtype)
        total = np.clip(np.rint(total), limits.min, limits.max)
    out[...] = total


def _weights(fraction: Any) -> tuple[Any, Any, Any, Any]:
    """Return the weights of the four pixels around a position that is ``fraction`` of the way from the second to the
    third.
    """
    a = _CUBIC_COEFFICIENT

    def near(x: Any) -> Any:
        return ((a + 2) * x - (a + 3)) * x * x + 1

    def far(x: Any) -> Any:
        return ((a * x - 5 * a) * x + 8 * a) * x - 4 * a

    return far(fraction + 1), near(fraction), near(1 - fraction), far(2 - fraction)
