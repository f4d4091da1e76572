"""Pictures of depths as clouds of points. Pure but for numpy, and Pillow for compressed pictures."""

from __future__ import annotations

import math
import struct
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.bag.export.extras import extra
from pyros1.bag.export.images import pixels, to_8_bits
from pyros1.ground.errors import MessageError
from pyros1.web.scene.camera import Camera
from pyros1.web.scene.shape import Shape, ShapeError
from pyros1.web.shown.picture_size import MOST_PIXELS

_HEAD = struct.Struct("<iff")
"""What is before the file in pictures of compressedDepth: the format, and two numbers that say what depths mean."""
_COMPRESSED = "sensor_msgs/CompressedImage"


def depths(message: Any) -> NDArray[np.float32]:
    """Return the depths of a picture in metres, one for each pixel; 0, NaN or infinite where there is none.

    Args:
        message: a sensor_msgs/Image of whole millimetres (16UC1) or of metres (32FC1); or a sensor_msgs/CompressedImage
            of compressed_depth_image_transport with a PNG file.

    Raises:
        ShapeError: it is neither, or damaged.
    """
    try:
        if message._type == _COMPRESSED:
            return _unpacked(message)
        found = pixels(message)
    except MessageError as error:
        raise ShapeError(str(error)) from None
    if found.ndim == 2 and found.dtype == np.uint16:
        return _metres(found)
    if found.ndim == 2 and found.dtype.kind == "f":
        with np.errstate(over="ignore"):
            return found.astype(np.float32)
    raise ShapeError(f"depths are pictures of 16UC1 or 32FC1, but these are {message.encoding}"[:200])


def colours(message: Any) -> NDArray[np.uint8]:
    """Return the colours of a picture: blue, green, red and 0 for each pixel.

    Raises:
        ShapeError: it cannot be read.
    """
    try:
        if message._type == _COMPRESSED:
            found = np.asarray(_opened(bytes(message.data)).convert("RGB"))
        else:
            found = to_8_bits(pixels(message))
    except MessageError as error:
        raise ShapeError(f"colours: {error}") from None
    if found.ndim == 2:
        found = found[:, :, None]
    packed = np.zeros((*found.shape[:2], 4), np.uint8)
    packed[:, :, :3] = found[:, :, 2::-1] if found.shape[2] > 2 else found[:, :, :1]
    return packed


def depth_cloud(
    depth: NDArray[np.float32], camera: Camera, picture: NDArray[np.uint8] | None, most: int, numbers: bool = False
) -> Shape:
    """Return a cloud in the camera's frame, as `pyros1.web.scene.clouds.point_cloud2` does.

    Args:
        depth: see `depths`.
        camera: what saw them.
        picture: colours from where the depths were seen; see `colours`. None colours by depth.
        most: about the number of points; if there are more, only every second, third ... row and column counts.
        numbers: whether to send the points' places in the picture, too, counted row by row.
    """
    height, width = depth.shape
    camera = camera.resized(width, height)
    with np.errstate(all="ignore"):
        known = (depth > 0) & (depth < np.inf)
        step = max(1, math.ceil(math.sqrt(np.count_nonzero(known) / most)))
        z, known = depth[::step, ::step], known[::step, ::step]
        across, down = np.arange(0, width, step), np.arange(0, height, step)
        far = z[known]
        places = np.empty((len(far), 3), np.float32)
        places[:, 0] = (z * ((across - camera.cx) / camera.fx).astype(np.float32))[known] + camera.tx
        places[:, 1] = (z * ((down - camera.cy) / camera.fy).astype(np.float32)[:, None])[known] + camera.ty
        places[:, 2] = far
        there = np.isfinite(places).all(axis=1)
    if not there.all():  # absurd depths, or an absurd camera
        known[known] = there
        far, places = far[there], places[there]
    facts: dict[str, Any] = {"kind": "cloud", "count": len(far), "every": step * step, "fields": ["z"]}
    blob = places.tobytes()
    if numbers:
        facts["numbers"] = True
        blob += (down[:, None] * width + across)[known].astype(np.uint32).tobytes()
    if picture is not None:
        high, wide = picture.shape[:2]
        whole = picture.view(np.uint32)[:, :, 0]  # a pixel is one number
        seen = whole[np.ix_(down * high // height, across * wide // width)][known]
        return {**facts, "by": "rgb", "colour": "rgb", "least": 0.0, "most": 1.0}, blob + seen.tobytes()
    least, greatest = (float(far.min()), float(far.max())) if len(far) else (0.0, 1.0)
    return {**facts, "by": "z", "colour": "z", "least": least, "most": greatest}, blob


def _unpacked(message: Any) -> NDArray[np.float32]:
    kind, data = message.format.partition(";")[0].strip(), bytes(message.data)
    if "compressedDepth" not in message.format or kind not in ("16UC1", "32FC1") or len(data) < _HEAD.size:
        raise ShapeError(f"no depths, but a picture of the format {message.format}"[:200])
    if data[_HEAD.size :][:4] != b"\x89PNG":
        raise ShapeError("of compressed depths only PNG files are supported")
    found = np.asarray(_opened(data[_HEAD.size :]))
    if found.ndim != 2:
        raise ShapeError("compressed depths with colours")
    if kind == "16UC1":
        return _metres(found)
    _, one, other = _HEAD.unpack_from(data)
    with np.errstate(all="ignore"):
        metres: NDArray[np.float32] = np.where(found > 0, one / (found.astype(np.float32) - other), 0)
    return metres.astype(np.float32)


def _metres(millimetres: NDArray[Any]) -> NDArray[np.float32]:
    metres: NDArray[np.float32] = (millimetres * np.float32(0.001)).astype(np.float32, copy=False)
    return metres


def _opened(data: bytes) -> Any:
    """Return a picture of Pillow.

    Raises:
        MessageError: it is damaged or too large.
    """
    pil = extra("PIL.Image", "images")
    try:
        image = pil.open(BytesIO(data), formats=("JPEG", "PNG"))
        if image.size[0] * image.size[1] > MOST_PIXELS:
            raise MessageError(f"a picture of {image.size[0]} x {image.size[1]} pixels is too large to be shown")
        image.load()
    except MessageError:
        raise
    except pil.UnidentifiedImageError:
        raise MessageError("the picture cannot be read: its format is not known") from None
    except Exception as error:  # noqa: BLE001 - Pillow raises many kinds for damaged files
        raise MessageError(f"the picture cannot be read: {error}") from None
    return image
