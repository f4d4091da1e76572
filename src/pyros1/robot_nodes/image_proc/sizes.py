"""Resizes and crops images together with their camera_info (no I/O)."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from pyros1.robot_nodes.image_proc.colours import halve_bayer
from pyros1.robot_nodes.image_proc.pixels import ImageError, parse_encoding, to_array, to_image
from pyros1.robot_nodes.image_proc.resample import AREA, CUBIC, LANCZOS, LINEAR, NEAREST, decimate, resize

MAX_PIXELS = 1 << 27
"""Maximum number of pixels of an enlarged image."""
CROP_METHODS = {"NN": NEAREST, "Linear": LINEAR, "Cubic": CUBIC, "Area": AREA, "Lanczos4": LANCZOS}


@dataclass(frozen=True)
class Scaling:
    """The parameters of resize.

    Attributes:
        use_scale: whether to use the scale factors instead of the size.
        scale_width, scale_height: the scale factors.
        width, height: the new size in pixels; -1 for the image's.
        interpolation: see ``resample``.
    """

    use_scale: bool = True
    scale_width: float = 1.0
    scale_height: float = 1.0
    width: int = -1
    height: int = -1
    interpolation: int = LINEAR

    def size_of(self, height: int, width: int) -> tuple[int, int]:
        """Return the new height and width of an image.

        Raises:
            ImageError: the height or width is 0, or the image would be too large.
        """
        if self.use_scale:
            height, width = round(height * self.scale_height), round(width * self.scale_width)
        else:
            height = height if self.height == -1 else self.height
            width = width if self.width == -1 else self.width
        if height < 1 or width < 1 or height * width > MAX_PIXELS:
            raise ImageError(f"an image cannot be resized to {width} x {height} pixels: check the parameters of resize")
        return height, width

    def apply_to_image(self, image: Any) -> Any:
        """Return a sensor_msgs/Image resized.

        Raises:
            ImageError: the image cannot be resized.
        """
        encoding = parse_encoding(image.encoding)
        if encoding.bayer or encoding.is_yuv:
            raise ImageError(
                f"images with the encoding {encoding.name} cannot be resized: take image_color or image_mono"
            )
        height, width = self.size_of(image.height, image.width)
        steps = (1 / self.scale_height, 1 / self.scale_width) if self.use_scale else None
        pixels = resize(to_array(image), height, width, self.interpolation, steps)
        return to_image(image.header, pixels, image.encoding)

    def apply_to_info(self, info: Any) -> Any:
        """Return a sensor_msgs/CameraInfo for images of the new size.

        Raises:
            ImageError: the image cannot be resized.
        """
        if not info.height or not info.width:
            raise ImageError("camera_info has no size")
        result = deepcopy(info)
        result.height, result.width = self.size_of(info.height, info.width)
        if self.use_scale:
            y, x = self.scale_height, self.scale_width
        else:
            y, x = result.height / info.height, result.width / info.width
        result.K = _multiplied(info.K, (x, 1, x, 1, y, y, 1, 1, 1))
        result.P = _multiplied(info.P, (x, 1, x, x, 1, y, y, y, 1, 1, 1, 1))
        for name, factor in (("x_offset", x), ("width", x), ("y_offset", y), ("height", y)):
            setattr(result.roi, name, int(getattr(info.roi, name) * factor))
        return result


def _multiplied(values: Any, factors: tuple[float, ...]) -> list[float]:
    return [value * factor for value, factor in zip(values, factors, strict=True)]


@dataclass(frozen=True)
class Crop:
    """The parameters of crop_decimate.

    Attributes:
        decimation_x, decimation_y: how many pixels become one.
        x_offset, y_offset, width, height: the part of the image to keep, in pixels; a width or height of 0 means up to
            the image's edge.
        interpolation: see ``resample``.
    """

    decimation_x: int = 1
    decimation_y: int = 1
    x_offset: int = 0
    y_offset: int = 0
    width: int = 0
    height: int = 0
    interpolation: int = NEAREST

    def apply(self, image: Any, info: Any) -> tuple[Any, Any]:
        """Return an image cropped and decimated, and its camera_info.

        Raises:
            ImageError: the part is outside the image, or the image cannot be decimated.
        """
        encoding = parse_encoding(image.encoding)
        # In images with a Bayer pattern or YUV, pixels form pairs.
        even = -2 if encoding.bayer or encoding.is_yuv else -1
        x, y = self.x_offset & even, self.y_offset & even
        if x >= image.width or y >= image.height:
            raise ImageError(f"the offset {x}, {y} is outside of the image with {image.width} x {image.height} pixels")
        width = min(self.width & even or image.width, image.width - x)
        height = min(self.height & even or image.height, image.height - y)
        by_x, by_y = self.decimation_x, self.decimation_y
        if (by_x, by_y, x, y, width, height) == (1, 1, 0, 0, image.width, image.height):
            return image, info
        pixels = to_array(image)[y : y + height, x : x + width]
        name = image.encoding
        if (by_x, by_y) != (1, 1):
            if encoding.is_yuv:
                raise ImageError(f"images with the encoding {name} cannot be decimated")
            if encoding.bayer:
                if by_x % 2 or by_y % 2:
                    raise ImageError("decimation_x and decimation_y must be even for images with a Bayer pattern")
                pixels = halve_bayer(pixels, encoding.bayer)
                name = f"bgr{8 * encoding.dtype.itemsize}"
                by_x, by_y = by_x // 2, by_y // 2
            if pixels.shape[0] < by_y or pixels.shape[1] < by_x:
                raise ImageError("the part of the image that is kept is smaller than one pixel of the result")
            pixels = decimate(pixels, by_y, by_x, self.interpolation)
        return to_image(image.header, pixels, name), self._adjust_info(info, image, (x, y, width, height))

    def _adjust_info(self, info: Any, image: Any, part: tuple[int, int, int, int]) -> Any:
        binning_x, binning_y = max(1, info.binning_x), max(1, info.binning_y)
        x, y, width, height = part
        result = deepcopy(info)
        result.binning_x, result.binning_y = binning_x * self.decimation_x, binning_y * self.decimation_y
        result.roi.x_offset += x * binning_x
        result.roi.y_offset += y * binning_y
        result.roi.width, result.roi.height = width * binning_x, height * binning_y
        if (width, height) != (image.width, image.height):
            result.roi.do_rectify = True
        return result
