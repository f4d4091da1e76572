"""How cameras see the scene: sensor_msgs/CameraInfo (https://wiki.ros.org/image_pipeline/CameraInfo). Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pyros1.web.scene.shape import ShapeError

_MIN_FOCAL_LENGTH, _MAX_FOCAL_LENGTH = 1e-6, 1e12
"""Pixels: a camera with values outside this range is not calibrated."""


@dataclass(frozen=True)
class Camera:
    """A camera without distortion, looking along z with x to the right and y down.

    Attributes:
        fx, fy: its focal lengths in pixels.
        cx, cy: the principal point of the picture, in pixels from the centre of the first one.
        tx, ty: metres from the origin of its frame to its optical centre, for the right camera of a stereo pair.
        width, height: size of its picture in pixels; 0 for unknown.
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
        """Return the same camera with a picture of another size."""
        if (width, height) == (self.width, self.height):
            return self
        across, down = width / (self.width or width), height / (self.height or height)
        cx, cy = (self.cx + 0.5) * across - 0.5, (self.cy + 0.5) * down - 0.5
        return Camera(self.fx * across, self.fy * down, cx, cy, self.tx, self.ty, width, height)


def pinhole(info: Any) -> Camera:
    """Return the camera described by a sensor_msgs/CameraInfo: from P, or from K if there is no P.

    P is for rectified pictures. The region of interest and the binning in the message are considered.

    Raises:
        ShapeError: it does not describe a camera.
    """
    rows = [*info.P] if info.P[0] else [*info.K[:3], 0.0, *info.K[3:6], 0.0]
    fx, cx, fy, cy = rows[0], rows[2], rows[5], rows[6]
    if not all(abs(each) < _MAX_FOCAL_LENGTH for each in rows) or fx < _MIN_FOCAL_LENGTH or fy < _MIN_FOCAL_LENGTH:
        raise ShapeError("the CameraInfo has no focal lengths (P and K): the camera is not calibrated")
    eye = (-rows[3] / fx, -rows[7] / fy)
    part = info.roi
    across, down = max(1, info.binning_x), max(1, info.binning_y)
    width, height = part.width or info.width, part.height or info.height
    middle = ((cx - part.x_offset) / across, (cy - part.y_offset) / down)
    return Camera(fx / across, fy / down, *middle, *eye, width // across, height // down)


def info_topic(topic: str, compressed: bool = False) -> str:
    """Return the topic of the CameraInfo of an image topic: next to it, as in image_transport.

    Args:
        topic: the full name.
        compressed: whether its last part is the name of a compressed transport.
    """
    base = topic.rpartition("/")[0] if compressed else topic
    return f"{base.rpartition('/')[0]}/camera_info"
