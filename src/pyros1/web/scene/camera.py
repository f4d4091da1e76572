"""Reads camera models from sensor_msgs/CameraInfo, see https://wiki.ros.org/image_pipeline/CameraInfo (no I/O)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pyros1.web.scene.shape import ShapeError

_MIN_FOCAL_LENGTH, _MAX_FOCAL_LENGTH = 1e-6, 1e12
"""Range of focal lengths in pixels; a camera with a focal length outside this range is not calibrated."""


@dataclass(frozen=True)
class Camera:
    """A pinhole camera without distortion, which looks along z, with x to the right and y down.

    Attributes:
        fx, fy: the focal lengths in pixels.
        cx, cy: the principal point, in pixels from the centre of the first pixel.
        tx, ty: offset of the optical centre from the frame's origin in metres, for the right camera of a stereo pair.
        width, height: size of the image in pixels; 0 if unknown.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    tx: float
    ty: float
    width: int
    height: int

    def resized(self, width: int, height: int) -> Camera:
        """Return the same camera for an image that is scaled to another size."""
        if (width, height) == (self.width, self.height):
            return self
        scale_x, scale_y = width / (self.width or width), height / (self.height or height)
        cx, cy = (self.cx + 0.5) * scale_x - 0.5, (self.cy + 0.5) * scale_y - 0.5
        return Camera(self.fx * scale_x, self.fy * scale_y, cx, cy, self.tx, self.ty, width, height)


def pinhole_camera(info: Any) -> Camera:
    """Return the camera that a sensor_msgs/CameraInfo describes: by its matrix P, or by K if it has no P.

    P is for rectified images. The message's region of interest and binning are taken into account.

    Raises:
        ShapeError: the message does not describe a camera.
    """
    matrix = [*info.P] if info.P[0] else [*info.K[:3], 0.0, *info.K[3:6], 0.0]
    fx, cx, fy, cy = matrix[0], matrix[2], matrix[5], matrix[6]
    if not all(abs(value) < _MAX_FOCAL_LENGTH for value in matrix) or fx < _MIN_FOCAL_LENGTH or fy < _MIN_FOCAL_LENGTH:
        raise ShapeError("the CameraInfo has no focal lengths (P and K): the camera is not calibrated")
    offset = (-matrix[3] / fx, -matrix[7] / fy)
    roi = info.roi
    scale_x, scale_y = max(1, info.binning_x), max(1, info.binning_y)
    width, height = roi.width or info.width, roi.height or info.height
    centre = ((cx - roi.x_offset) / scale_x, (cy - roi.y_offset) / scale_y)
    return Camera(fx / scale_x, fy / scale_y, *centre, *offset, width // scale_x, height // scale_y)


def camera_info_topic(topic: str, compressed: bool = False) -> str:
    """Return the CameraInfo topic that belongs to an image topic: as in image_transport, in the same namespace.

    Args:
        topic: the full name of the image topic.
        compressed: whether the last part of the topic's name is the name of a compressed transport.
    """
    base = topic.rpartition("/")[0] if compressed else topic
    return f"{base.rpartition('/')[0]}/camera_info"
