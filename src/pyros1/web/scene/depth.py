"""Converts depth images to point clouds (no I/O; compressed images need Pillow)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.bag.export.images import pixels, to_8_bits
from pyros1.ground.errors import MessageError
from pyros1.observe.compressed_depth import decode_depth
from pyros1.observe.image_files import decode
from pyros1.web.scene.camera import Camera
from pyros1.web.scene.shape import Shape, ShapeError
from pyros1.web.transforms.image_size import MAX_PIXELS

_COMPRESSED_TYPE = "sensor_msgs/CompressedImage"


def depths(message: Any) -> NDArray[np.float32]:
    """Return the depth at each pixel of an image, in metres; 0, NaN or infinity where the depth is unknown.

    Args:
        message: a sensor_msgs/Image in integer millimetres (16UC1) or in metres (32FC1); or a
            sensor_msgs/CompressedImage from compressed_depth_image_transport that contains a PNG file.

    Raises:
        ShapeError: the message is not a depth image in one of these forms, or is damaged.
    """
    try:
        if message._type == _COMPRESSED_TYPE:
            image = decode_depth(message.format, bytes(message.data), MAX_PIXELS)
        else:
            image = pixels(message)
    except MessageError as error:
        raise ShapeError(str(error)) from None
    if image.ndim == 2 and image.dtype == np.uint16:
        return _to_metres(image)
    if image.ndim == 2 and image.dtype.kind == "f":
        with np.errstate(over="ignore"):
            return image.astype(np.float32)
    raise ShapeError(f"depth images must be 16UC1 or 32FC1, but this one is {message.encoding}"[:200])


def colours(message: Any) -> NDArray[np.uint8]:
    """Return the colour of each pixel of an image, as the four bytes blue, green, red and 0.

    Raises:
        ShapeError: the image cannot be read.
    """
    try:
        if message._type == _COMPRESSED_TYPE:
            image = to_8_bits(decode(bytes(message.data), MAX_PIXELS))
        else:
            image = to_8_bits(pixels(message))
    except MessageError as error:
        raise ShapeError(f"colours: {error}") from None
    if image.ndim == 2:
        image = image[:, :, None]
    packed = np.zeros((*image.shape[:2], 4), np.uint8)
    packed[:, :, :3] = image[:, :, 2::-1] if image.shape[2] > 2 else image[:, :, :1]
    return packed


def depth_cloud(
    depth: NDArray[np.float32],
    camera: Camera,
    colour_image: NDArray[np.uint8] | None,
    max_points: int,
    with_indices: bool = False,
) -> Shape:
    """Return the shape for the points seen in a depth image, in the camera's frame; see
    `pyros1.web.scene.clouds.point_cloud2`.

    Args:
        depth: see `depths`.
        camera: the depth camera.
        colour_image: the colours seen from the same viewpoint, from `colours`; None to colour the points by depth.
        max_points: approximate maximum number of points; if there are more, only every second, third ... row and column
            is used.
        with_indices: whether to also send the points' indices in the image, counted row by row.
    """
    height, width = depth.shape
    camera = camera.resized(width, height)
    with np.errstate(all="ignore"):
        measured = (depth > 0) & (depth < np.inf)
        step = max(1, math.ceil(math.sqrt(np.count_nonzero(measured) / max_points)))
        z, measured = depth[::step, ::step], measured[::step, ::step]
        columns, rows = np.arange(0, width, step), np.arange(0, height, step)
        distances = z[measured]
        positions = np.empty((len(distances), 3), np.float32)
        positions[:, 0] = (z * ((columns - camera.cx) / camera.fx).astype(np.float32))[measured] + camera.tx
        positions[:, 1] = (z * ((rows - camera.cy) / camera.fy).astype(np.float32)[:, None])[measured] + camera.ty
        positions[:, 2] = distances
        valid = np.isfinite(positions).all(axis=1)
    if not valid.all():  # some depths or camera parameters are so large that a position is not finite
        measured[measured] = valid
        distances, positions = distances[valid], positions[valid]
    description: dict[str, Any] = {"kind": "cloud", "count": len(distances), "every": step * step, "fields": ["z"]}
    blob = positions.tobytes()
    if with_indices:
        description["numbers"] = True
        blob += (rows[:, None] * width + columns)[measured].astype(np.uint32).tobytes()
    if colour_image is not None:
        image_height, image_width = colour_image.shape[:2]
        packed_pixels = colour_image.view(np.uint32)[:, :, 0]  # one integer per pixel
        sampled = packed_pixels[np.ix_(rows * image_height // height, columns * image_width // width)][measured]
        return {**description, "by": "rgb", "colour": "rgb", "least": 0.0, "most": 1.0}, blob + sampled.tobytes()
    nearest, farthest = (float(distances.min()), float(distances.max())) if len(distances) else (0.0, 1.0)
    return {**description, "by": "z", "colour": "z", "least": nearest, "most": farthest}, blob


def _to_metres(millimetres: NDArray[Any]) -> NDArray[np.float32]:
    metres: NDArray[np.float32] = (millimetres * np.float32(0.001)).astype(np.float32, copy=False)
    return metres
