"""Converts depth images to the ranges of a laser scan (no I/O)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import MessageError
from pyros1.ground.terminal_text import one_line

_METRES_PER_UNIT = {"16UC1": 0.001, "mono16": 0.001, "32FC1": 1.0}
"""Encoding of a depth image -> the unit of its pixels in metres."""


@dataclass(frozen=True)
class Camera:
    """The geometry of a camera's pixels.

    Attributes:
        width, height: the size of the image in pixels.
        focal_length: the horizontal focal length in pixels.
        center_x, center_y: the pixel that looks straight ahead.
    """

    width: int
    height: int
    focal_length: float
    center_x: float
    center_y: float

    @classmethod
    def of(cls, info: Any, width: int, height: int) -> Camera:
        """Return the camera that a sensor_msgs/CameraInfo describes.

        Args:
            info: the message. It describes the sensor's whole image; the published image may be a part of it.
            width, height: the size of the published image.

        Raises:
            MessageError: the camera is not calibrated.
        """
        matrix, row_length = (info.P, 4) if info.P[0] else (info.K, 3)
        focal_length, center_x, center_y = matrix[0], matrix[2], matrix[row_length + 2]
        if not focal_length > 0 or not math.isfinite(focal_length + center_x + center_y):
            raise MessageError("camera_info has no calibration: its P[0] and K[0] are 0")
        binning_x, binning_y = max(info.binning_x, 1), max(info.binning_y, 1)
        return cls(
            width,
            height,
            focal_length / binning_x,
            (center_x - info.roi.x_offset) / binning_x,
            (center_y - info.roi.y_offset) / binning_y,
        )

    @property
    def slopes(self) -> NDArray[np.float64]:
        """The tangent of each column's angle from straight ahead, positive to the right."""
        return (np.arange(self.width, dtype=np.float64) - self.center_x) / self.focal_length

    @property
    def angles(self) -> tuple[float, float, float]:
        """The angles of the first and the last ray, and the angle between rays, in radians.

        There are as many rays as columns; the first one looks to the right.
        """
        left = math.atan2(self.center_x, self.focal_length)
        right = -math.atan2(self.width - 1 - self.center_x, self.focal_length)
        return right, left, (left - right) / max(self.width - 1, 1)


def read_depths(image: Any) -> tuple[NDArray[Any], float]:
    """Return the pixels of a sensor_msgs/Image, of shape (height, width), and their unit in metres.

    Raises:
        MessageError: the image is not a depth image, or has too few bytes for its size.
    """
    unit = _METRES_PER_UNIT.get(image.encoding)
    if unit is None:
        encodings = ", ".join(_METRES_PER_UNIT)
        raise MessageError(f"{one_line(image.encoding, 40)!r} is not the encoding of a depth image: {encodings}")
    dtype = np.dtype((">" if image.is_bigendian else "<") + ("f4" if image.encoding == "32FC1" else "u2"))
    height, width, step = image.height, image.width, image.step
    data = np.frombuffer(image.data, np.uint8)
    if (
        not height
        or not width
        or step < width * dtype.itemsize
        or len(data) < step * (height - 1) + width * dtype.itemsize
    ):
        raise MessageError(f"{len(data)} bytes in rows of {step} are too few for {width} x {height} {image.encoding}")
    return np.ndarray((height, width), dtype, data, 0, (step, dtype.itemsize)), unit


def convert(
    depths: NDArray[Any], unit: float, camera: Camera, scan_height: int, range_min: float, range_max: float
) -> NDArray[np.float32]:
    """Return the ranges of a scan, one for each column of the image: the distance to the nearest point.

    If a direction has no point from `range_min` to `range_max`, its range is infinity if a pixel is infinite, otherwise
    NaN (REP 117).

    Args:
        depths: the image, of shape (height, width): floats, or integers, where 0 means unknown.
        unit: the unit of the depths in metres.
        camera: the camera.
        scan_height: the number of rows to use, around the row that looks straight ahead.
        range_min, range_max: the limits in metres.

    Raises:
        MessageError: some of the rows to use are outside the image.
    """
    top = int(camera.center_y - scan_height // 2)
    if top < 0 or top + scan_height > camera.height:
        rows = f"{scan_height} rows around row {camera.center_y:g}"
        raise MessageError(f"{rows} are not within the image, which has {camera.height}: set a smaller scan_height")
    band = depths[top : top + scan_height]
    slopes = camera.slopes
    columns, is_infinite = _nearest(band, unit, np.hypot(slopes, 1.0), range_min, range_max)
    first, _, step = camera.angles
    with np.errstate(invalid="ignore"):
        rays = ((-np.arctan(slopes) - first) / step).astype(np.int64) if step else np.zeros(camera.width, np.int64)
    np.clip(rays, 0, camera.width - 1, out=rays)
    ranges = np.full(camera.width, np.inf)
    np.minimum.at(ranges, rays, columns)
    known = np.zeros(camera.width, bool)
    known[rays[is_infinite]] = True
    ranges[~known & np.isinf(ranges)] = np.nan
    return ranges.astype(np.float32)


def _nearest(
    band: NDArray[Any], unit: float, stretch: NDArray[np.float64], range_min: float, range_max: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return each column's minimum distance within the limits, or infinity, and whether it has an infinite pixel."""
    distances = band * (unit * stretch)
    with np.errstate(invalid="ignore"):
        counts = (distances >= range_min) & (distances <= range_max) & (band > 0)
    nearest: NDArray[np.float64] = np.where(counts, distances, np.inf).min(axis=0)
    is_infinite: NDArray[np.bool_] = (band == np.inf).any(axis=0)
    return nearest, is_infinite
