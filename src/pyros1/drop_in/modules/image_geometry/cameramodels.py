"""What a camera sees of points, and where pixels look, by sensor_msgs/CameraInfo.

Matrices are numpy matrices, as programs for this library expect. Only `rectifyImage` needs OpenCV.
"""

from __future__ import annotations

import math
from copy import copy
from typing import Any

import numpy as np

from pyros1.drop_in.missing import missing

_STEPS = 5
"""Steps of the search for a point without distortion, as OpenCV makes them."""

__getattr__ = missing(__name__)


def mkmat(rows: int, cols: int, L: Any) -> Any:
    """Return a matrix of float64 with these values, row by row."""
    return np.asmatrix(np.array(L, dtype="float64").reshape(rows, cols))


class PinholeCameraModel:
    """A camera; `fromCameraInfo` fills it.

    Attributes:
        K, D, R, P: intrinsic matrix, distortion, rectification and projection, of the image as it comes.
        full_K, full_P: of the full resolution.
        width, height, resolution: of the full resolution, in pixels.
        binning_x, binning_y, raw_roi: what of it comes.
        tf_frame, stamp: frame and time of the message.
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
        self.resolution: Any = None
        self.binning_x: Any = None
        self.binning_y: Any = None
        self.raw_roi: Any = None
        self.tf_frame: Any = None
        self.stamp: Any = None

    def fromCameraInfo(self, msg: Any) -> None:
        """Take the values of a sensor_msgs/CameraInfo."""
        self.K, self.R, self.P = mkmat(3, 3, msg.K), mkmat(3, 3, msg.R), mkmat(3, 4, msg.P)
        self.D = mkmat(len(msg.D), 1, msg.D) if len(msg.D) else None
        self.full_K, self.full_P = mkmat(3, 3, msg.K), mkmat(3, 4, msg.P)
        self.binning_x, self.binning_y = max(1, msg.binning_x), max(1, msg.binning_y)
        self.width, self.height = msg.width, msg.height
        self.resolution = (msg.width, msg.height)
        roi = self.raw_roi = copy(msg.roi)
        if (roi.x_offset, roi.y_offset, roi.width, roi.height) == (0, 0, 0, 0):
            roi.width, roi.height = msg.width, msg.height
        self.tf_frame, self.stamp = msg.header.frame_id, msg.header.stamp
        for row, (offset, binning) in enumerate(
            ((msg.roi.x_offset, self.binning_x), (msg.roi.y_offset, self.binning_y))
        ):
            for matrix in (self.K, self.P):
                matrix[row, row] /= binning
                matrix[row, 2] = (matrix[row, 2] - offset) / binning
            self.P[row, 3] /= binning

    def rectifyImage(self, raw: Any, rectified: Any) -> None:
        """Write the image without distortion into another array of its shape; raises ImportError without OpenCV."""
        import cv2  # type: ignore[import-not-found, import-untyped, unused-ignore]

        maps = cv2.initUndistortRectifyMap(self.K, self.D, self.R, self.P, self.resolution, cv2.CV_32FC1)
        cv2.remap(raw, maps[0], maps[1], cv2.INTER_CUBIC, rectified)

    def rectifyPoint(self, uv_raw: Any) -> Any:
        """Return the pixel of a raw pixel in the image without distortion: array of shape (2,)."""
        x0 = x = (uv_raw[0] - self.K[0, 2]) / self.K[0, 0]
        y0 = y = (uv_raw[1] - self.K[1, 2]) / self.K[1, 1]
        k = np.zeros(8)
        if self.D is not None:
            k[: min(8, self.D.size)] = np.asarray(self.D).ravel()[:8]
        for _ in range(_STEPS if k.any() else 0):
            r2 = x * x + y * y
            scale = (1 + ((k[7] * r2 + k[6]) * r2 + k[5]) * r2) / (1 + ((k[4] * r2 + k[1]) * r2 + k[0]) * r2)
            if scale < 0:
                x, y = x0, y0
                break
            shift = 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x), k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y
            x, y = (x0 - shift[0]) * scale, (y0 - shift[1]) * scale
        place = np.asarray(self.P[:, :3] @ self.R @ np.array([[x], [y], [1.0]])).ravel()
        return place[:2] / place[2]

    def project3dToPixel(self, point: Any) -> tuple[float, float]:
        """Return the pixel of a point (x, y, z) in the camera's frame; (nan, nan) if it has none."""
        u, v, w = np.asarray(self.P @ np.array([[point[0]], [point[1]], [point[2]], [1.0]])).ravel()
        return (u / w, v / w) if w != 0 else (float("nan"), float("nan"))

    def projectPixelTo3dRay(self, uv: Any) -> tuple[float, float, float]:
        """Return the unit vector from the camera through a pixel of the image without distortion."""
        x = (uv[0] - self.cx()) / self.fx()
        y = (uv[1] - self.cy()) / self.fy()
        length = math.sqrt(x * x + y * y + 1)
        return x / length, y / length, 1 / length

    def getDeltaU(self, deltaX: float, Z: float) -> float:
        """Return the pixels, across, of a length at a depth; infinite at depth 0."""
        return float("inf") if Z == 0 else self.fx() * deltaX / Z

    def getDeltaV(self, deltaY: float, Z: float) -> float:
        """Return the pixels, down, of a length at a depth; infinite at depth 0."""
        return float("inf") if Z == 0 else self.fy() * deltaY / Z

    def getDeltaX(self, deltaU: float, Z: float) -> float:
        """Return the length of pixels, across, at a depth."""
        return Z * deltaU / self.fx()

    def getDeltaY(self, deltaV: float, Z: float) -> float:
        """Return the length of pixels, down, at a depth."""
        return Z * deltaV / self.fy()

    def fullResolution(self) -> Any:
        """Return the full resolution: width and height."""
        return self.resolution

    def intrinsicMatrix(self) -> Any:
        """Return K, of shape (3, 3)."""
        return self.K

    def distortionCoeffs(self) -> Any:
        """Return D, of shape (number, 1); None if there is none."""
        return self.D

    def rotationMatrix(self) -> Any:
        """Return R, of shape (3, 3)."""
        return self.R

    def projectionMatrix(self) -> Any:
        """Return P, of shape (3, 4)."""
        return self.P

    def fullIntrinsicMatrix(self) -> Any:
        """Return K of the full resolution."""
        return self.full_K

    def fullProjectionMatrix(self) -> Any:
        """Return P of the full resolution."""
        return self.full_P

    def cx(self) -> Any:
        """Return the middle of the image, across."""
        return self.P[0, 2]

    def cy(self) -> Any:
        """Return the middle of the image, down."""
        return self.P[1, 2]

    def fx(self) -> Any:
        """Return the focal length, across, in pixels."""
        return self.P[0, 0]

    def fy(self) -> Any:
        """Return the focal length, down, in pixels."""
        return self.P[1, 1]

    def Tx(self) -> Any:
        """Return the first value of the projection's last column."""
        return self.P[0, 3]

    def Ty(self) -> Any:
        """Return the second value of the projection's last column."""
        return self.P[1, 3]

    def fovX(self) -> float:
        """Return the angle of view, across, in radians."""
        return 2 * math.atan(self.width / (2 * self.fx()))

    def fovY(self) -> float:
        """Return the angle of view, down, in radians."""
        return 2 * math.atan(self.height / (2 * self.fy()))

    def tfFrame(self) -> Any:
        """Return the camera's frame."""
        return self.tf_frame


class StereoCameraModel:
    """Two cameras beside each other.

    Attributes:
        left, right: the cameras.
        Q: matrix of shape (4, 4) that makes points of pixels and disparities.
    """

    def __init__(self) -> None:
        self.left = PinholeCameraModel()
        self.right = PinholeCameraModel()
        self.Q: Any = None

    def fromCameraInfo(self, left_msg: Any, right_msg: Any) -> None:
        """Take the values of both sensor_msgs/CameraInfo."""
        self.left.fromCameraInfo(left_msg)
        self.right.fromCameraInfo(right_msg)
        fx, cx, cy = self.right.fx(), self.right.cx(), self.right.cy()
        tx = -self.right.Tx() / fx
        self.Q = np.zeros((4, 4), dtype="float64")
        self.Q[0, 0], self.Q[0, 3] = 1.0, -cx
        self.Q[1, 1], self.Q[1, 3] = 1.0, -cy
        self.Q[2, 3] = fx
        self.Q[3, 2] = 1 / tx if tx else float("inf")

    def tfFrame(self) -> Any:
        """Return the frame of the left camera."""
        return self.left.tfFrame()

    def project3dToPixel(self, point: Any) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the pixels of a point in both images."""
        return self.left.project3dToPixel(point), self.right.project3dToPixel(point)

    def projectPixelTo3d(self, left_uv: Any, disparity: float) -> tuple[float, float, float]:
        """Return the point of a pixel of the left image with a disparity; (0, 0, 0) if it is infinitely far away."""
        x, y, z, w = self.Q @ np.array([left_uv[0], left_uv[1], disparity, 1.0])
        return (x / w, y / w, z / w) if w != 0 else (0.0, 0.0, 0.0)

    def getZ(self, disparity: float) -> float:
        """Return the depth of a disparity; infinite for 0."""
        return float("inf") if disparity == 0 else -self.right.Tx() / disparity

    def getDisparity(self, Z: float) -> float:
        """Return the disparity at a depth; infinite for 0."""
        return float("inf") if Z == 0 else -self.right.Tx() / Z
