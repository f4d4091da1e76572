"""A camera's geometry, from its sensor_msgs/CameraInfo (no I/O); see https://wiki.ros.org/image_pipeline/CameraInfo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pyros1.robot_nodes.image_proc.pixels import ImageError

Array = np.ndarray[Any, Any]
MODELS = ("plumb_bob", "rational_polynomial", "equidistant")
_MAX_COEFFICIENTS = 12


class UncalibratedError(ImageError):
    """A camera has not been calibrated."""


@dataclass(frozen=True)
class Camera:
    """The properties of a camera that rectification needs. Cameras are equal if their images are rectified in the same
    way.

    Attributes:
        size: height and width of its images, in pixels.
        offset: y and x of the first pixel, in pixels of the binned full image.
        model: the distortion model.
        distortion: the distortion coefficients.
        intrinsics, rotation, projection: 3 x 3 matrices as nine numbers, row by row; intrinsics and projection are for
            the binned full image.
    """

    size: tuple[int, int]
    offset: tuple[int, int]
    model: str
    distortion: tuple[float, ...]
    intrinsics: tuple[float, ...]
    rotation: tuple[float, ...]
    projection: tuple[float, ...]

    @classmethod
    def from_info(cls, info: Any) -> Camera:
        """Return the camera that a sensor_msgs/CameraInfo describes.

        Raises:
            UncalibratedError: the camera has no calibration.
            ImageError: the distortion model is unknown, or a number is not finite.
        """
        if info.K[0] == 0.0:
            raise UncalibratedError("the camera is uncalibrated: K in its camera_info is 0")
        if info.distortion_model not in MODELS:
            raise ImageError(f"the distortion model {info.distortion_model!r:.40} is unknown: use {', '.join(MODELS)}")
        binning = max(1, info.binning_x), max(1, info.binning_y)
        roi = info.roi
        if not any((roi.x_offset, roi.y_offset, roi.width, roi.height)):
            size = info.height // binning[1], info.width // binning[0]
        else:
            size = roi.height // binning[1], roi.width // binning[0]
        rotation = tuple(info.R) if any(info.R) else (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
        projection = tuple(info.P[place] for place in (0, 1, 2, 4, 5, 6, 8, 9, 10)) if any(info.P) else tuple(info.K)
        found = cls(
            size=size,
            offset=(roi.y_offset // binning[1], roi.x_offset // binning[0]),
            model=info.distortion_model,
            distortion=tuple(info.D[:_MAX_COEFFICIENTS]),
            intrinsics=_scale(info.K, *binning),
            rotation=rotation,
            projection=_scale(projection, *binning),
        )
        if not np.isfinite([*found.distortion, *found.intrinsics, *rotation, *found.projection]).all():
            raise ImageError("the camera_info has numbers that are not finite")
        return found

    def source_positions(self) -> tuple[Array, Array]:
        """Return the position in the original image of each pixel of the rectified image.

        Returns:
            x and y in pixels, each of shape `size`; positions may be outside the image.

        Raises:
            ImageError: the matrices cannot be inverted.
        """
        rows, columns = self.size
        v, u = np.mgrid[0:rows, 0:columns].astype(np.float64)
        u += self.offset[1]
        v += self.offset[0]
        try:
            back = np.linalg.inv(_matrix(self.projection) @ _matrix(self.rotation))
        except np.linalg.LinAlgError:
            raise ImageError("the matrices P and R of the camera_info cannot be inverted") from None
        with np.errstate(all="ignore"):  # points at infinity are outside the image
            x, y, w = (row[0] * u + row[1] * v + row[2] for row in back)
            x, y = self._distort(x / w, y / w)
        k = _matrix(self.intrinsics)
        return k[0, 0] * x + k[0, 2] - self.offset[1], k[1, 1] * y + k[1, 2] - self.offset[0]

    def _distort(self, x: Array, y: Array) -> tuple[Array, Array]:
        d = [*self.distortion, *[0.0] * (_MAX_COEFFICIENTS - len(self.distortion))]
        r2 = x * x + y * y
        if self.model == "equidistant":
            r = np.sqrt(r2)
            theta = np.arctan(r)
            t2 = theta * theta
            distorted = theta * (1 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3]))))
            scale = np.where(r > 0, distorted / np.where(r > 0, r, 1.0), 1.0)
            return x * scale, y * scale
        radial = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))
        if self.model == "rational_polynomial":
            radial = radial / (1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])))
        xy2 = 2 * x * y
        return (
            x * radial + d[2] * xy2 + d[3] * (r2 + 2 * x * x) + r2 * (d[8] + r2 * d[9]),
            y * radial + d[2] * (r2 + 2 * y * y) + d[3] * xy2 + r2 * (d[10] + r2 * d[11]),
        )


def is_undistorted(info: Any) -> bool:
    """Return whether a camera's images need no rectification, since all coefficients are 0 (as in stock ROS)."""
    return not any(info.D)


def _scale(matrix: Any, binning_x: int, binning_y: int) -> tuple[float, ...]:
    """Return a 3 x 3 matrix, row by row, for an image that is smaller by these factors."""
    return (
        *(float(value) / binning_x for value in matrix[:3]),
        *(float(value) / binning_y for value in matrix[3:6]),
        *(float(value) for value in matrix[6:9]),
    )


def _matrix(values: tuple[float, ...]) -> Array:
    return np.array(values, np.float64).reshape(3, 3)
