"""Converts image files (JPEG, PNG and others) to arrays and back, without loss of bit depth or alpha.

Pixels are like those of OpenCV's ``imread`` with ``IMREAD_UNCHANGED``, but start with red. Needs Pillow.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from importlib import import_module
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import Error, MessageError
from pyros1.observe import png16

Pixels = NDArray[Any]
MAX_PIXELS = 1 << 27
"""Maximum number of pixels of an image to decode, unless the caller sets a lower one."""
_FORMATS = ("JPEG", "PNG", "BMP", "TIFF", "WEBP", "PPM", "JPEG2000")
_FORMATS_BY_EXTENSION = {
    "jpg": "JPEG",
    "jpe": "JPEG",
    "tif": "TIFF",
    "dib": "BMP",
    "jp2": "JPEG2000",
    "pgm": "PPM",
    "pbm": "PPM",
}
"""Pillow's formats for file extensions that differ from the format's name."""
_DEEP_MEMORY_FACTOR = 4
"""Factor by which files with 16 bits per channel need more memory per pixel than others."""
_BLOCK_PIXELS = 1 << 16
"""Number of pixels to convert at a time."""
_END_OF_JPEG = b"\xff\xd9"
_TIFF_BITS, _TIFF_EXTRA_SAMPLES, _TIFF_SAMPLE_FORMAT = 258, 338, 339
"""TIFF tags: bits of each channel; the kind of the channels after the colours (1 for premultiplied alpha, 2 for alpha
that is not premultiplied); and the sample format (1 unsigned integers, 2 signed integers, 3 floating point)."""
_TIFF_KINDS = ("u1", "u2", "i4", "f4")


class ImageFileError(MessageError):
    """An image cannot be read or cannot be written in the requested format."""


class UnsupportedFileError(ImageFileError):
    """Pillow would lose bits of the image, unlike OpenCV. The message suggests an alternative."""


def import_pillow() -> Any:
    """Import and return the module PIL.Image. Raise Error if Pillow is not installed."""
    try:
        return import_module("PIL.Image")
    except ImportError as error:
        raise Error(f"compressed images need Pillow ({error}): pip install 'pyros1[images]'") from None


def decode(data: bytes, max_pixels: int = MAX_PIXELS) -> Pixels:
    """Decode an image file.

    Args:
        data: the contents of the file. A JPEG file may be truncated; the missing part is grey, as with other readers.
        max_pixels: the maximum number of pixels.

    Returns:
        An array of shape (height, width), or (height, width, 3 or 4) with red, green, blue and alpha. The type is
        uint8, or uint16, int32 or float32 if the file contains such numbers.

    Raises:
        ImageFileError: the file is damaged or too large, or its format or depth is not supported.
        Error: Pillow is not installed.
    """
    pillow_image = import_pillow()
    _ignore_warnings()
    try:
        with pillow_image.open(BytesIO(data + _END_OF_JPEG), formats=_FORMATS) as picture:
            png_header = png16.parse_header(data)
            # If a file contains several headers, Pillow uses the last.
            width, height = map(max, picture.size, (png_header.width, png_header.height) if png_header else (0, 0))
            if width * height > (
                max_pixels // _DEEP_MEMORY_FACTOR if png_header is not None and png_header.bits == 16 else max_pixels
            ):
                raise _too_large_error(max_pixels, f" of {width} x {height} pixels")
            return _to_array(pillow_image, picture, data)
    except MessageError:
        raise
    except pillow_image.UnidentifiedImageError:
        raise ImageFileError("the image cannot be read: its format is unknown") from None
    except pillow_image.DecompressionBombError:
        raise _too_large_error(max_pixels) from None
    except Exception as error:  # noqa: BLE001 - Pillow raises many exception types for damaged files
        raise ImageFileError(f"the image cannot be read: {error}") from None


def encode(image: Pixels, requested_format: str, **options: Any) -> bytes:
    """Return the contents of an image file with the given pixels.

    Args:
        image: an array of shape (height, width), or (height, width, 1, 3 or 4) with red, green, blue and alpha. Numbers
            outside the format's range are clipped to 0 ... 255. Alpha is left out if the format does not support it.
        requested_format: the format or a file extension, such as "jpg" or "png".
        options: Pillow's options for the format, such as ``quality`` for JPEG or ``compress_level`` for PNG.

    Raises:
        ImageFileError: the format does not exist or cannot store the image.
        Error: Pillow is not installed.
    """
    format_name = _FORMATS_BY_EXTENSION.get(requested_format.lower(), requested_format.upper())
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if not image.size or image.ndim not in (2, 3) or image.shape[2:] not in ((), (3,), (4,)):
        raise ImageFileError(f"an image with the shape {image.shape} cannot be written as {requested_format}")
    dtype_code = image.dtype.str[1:]
    if format_name == "PNG" and dtype_code == "u2" and image.ndim == 3:
        return png16.write(image, options.get("compress_level", 6))
    deep_dtype_codes = {"PNG": ("u2",), "TIFF": _TIFF_KINDS, "PPM": ("u2",), "JPEG2000": ("u2",)}.get(format_name, ())
    if dtype_code not in deep_dtype_codes and format_name not in ("TIFF", "PPM", "JPEG2000"):
        image = to_uint8(image)
    elif dtype_code != "u1" and (dtype_code not in deep_dtype_codes or image.ndim == 3):
        raise UnsupportedFileError(
            f"an image of {image.dtype} with the shape {image.shape} cannot be written as {requested_format}; "
            "write 8 bits, or PNG"
        )
    if format_name in ("JPEG", "BMP", "PPM") and image.ndim == 3:
        image = image[:, :, :3]
    if format_name == "PPM" and dtype_code == "u2":
        image = image.astype(np.int32)
    file = BytesIO()
    try:
        import_pillow().fromarray(np.ascontiguousarray(image.astype(image.dtype.newbyteorder("=")))).save(
            file, format_name, **options
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ImageFileError(f"the image cannot be written as {requested_format}: {error}") from None
    return file.getvalue()


def _ignore_warnings() -> None:
    """Prevent Pillow from printing warnings, for example about damaged or large files, which are reported as errors."""
    pattern = r"PIL\."
    if not any(
        action == "ignore" and module and module.pattern == pattern for action, _, _, module, _ in warnings.filters
    ):
        warnings.filterwarnings("ignore", module=pattern)


def _too_large_error(max_pixels: int, size: str = "") -> ImageFileError:
    return ImageFileError(f"the image{size} is too large: at most {max_pixels} pixels can be read")


def to_uint8(image: Pixels) -> NDArray[np.uint8]:
    """Return numbers rounded and clipped to 0 ... 255. NaN and numbers beyond 32 bits become 0, as in OpenCV."""
    if image.dtype == np.uint8:
        return image
    if image.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            image = np.where(np.abs(image) < 1 << 31, np.rint(image), 0)
    return np.clip(image, 0, 255).astype(np.uint8)


def _to_array(pillow_image: Any, picture: Any, data: bytes) -> Pixels:
    png_header = png16.parse_header(data)
    if png_header is not None and png_header.bits == 16 and png_header.colour_type:
        pixels = png16.read(data, pillow_image)
        return np.dstack([pixels[:, :, :1]] * 3 + [pixels[:, :, 1:]]) if pixels.shape[2] == 2 else pixels
    mode, format_name = picture.mode, picture.format
    if mode in ("RGB", "RGBA", "LA", "La", "CMYK") and _exceeds_8_bits(picture, data):
        raise UnsupportedFileError(
            f"a colour {format_name} file with more than 8 bits per channel cannot be read without loss; "
            "send PNG instead"
        )
    if format_name == "TIFF" and mode in ("RGBA", "LA", "La", "CMYK"):
        return _from_tiff(picture)
    if mode == "CMYK":
        return _from_cmyk(picture)
    if format_name == "TIFF" and picture.tag_v2.get(_TIFF_SAMPLE_FORMAT, (1,))[0] == 2 and mode in ("L", "I"):
        return np.asarray(picture).astype(f"i{picture.tag_v2[_TIFF_BITS][0] // 8}")
    if mode == "F" or mode.startswith("I"):
        return np.asarray(picture).astype(np.float32 if mode == "F" else np.uint16)
    has_transparency = "transparency" in picture.info
    if format_name == "WEBP" or mode not in ("1", "L"):
        mode = "RGBA" if has_transparency or mode in ("RGBA", "LA", "PA") else "RGB"
    else:
        mode = "L"
    return np.array(picture.convert(mode))


def _exceeds_8_bits(picture: Any, data: bytes) -> bool:
    """Return whether Pillow would discard bits of the colours."""
    if picture.format == "TIFF":
        return bool(max(picture.tag_v2.get(_TIFF_BITS, (8,))) > 8)
    if picture.format == "PPM":
        return bool(picture.tile[0][3][-1] != 255) if isinstance(picture.tile[0][3], tuple) else False
    if picture.format == "JPEG2000":
        start = data.find(b"\xff\x51")  # the SIZ segment, which contains the depth of the first component
        return 0 <= start < len(data) - 41 and data[start + 40] & 0x7F > 7
    return False


def _from_cmyk(picture: Any) -> Pixels:
    """Convert a CMYK image to RGB, like OpenCV."""
    stored_pixels: Pixels = np.asarray(picture)
    is_inverted = "adobe" in picture.info  # in this case, Pillow has inverted the values
    colours: Pixels = np.empty((*stored_pixels.shape[:2], 3), np.uint8)
    for block, result in _row_blocks(stored_pixels, colours):
        wide_block = (~block if is_inverted else block).astype(np.uint16)
        black = wide_block[:, :, 3:]
        result[:] = black - ((255 - wide_block[:, :, :3]) * black >> 8)
    return colours


def _from_tiff(picture: Any) -> Pixels:
    """Convert a TIFF file with alpha or CMYK, like OpenCV (libtiff)."""
    stored_pixels: Pixels = np.asarray(picture)
    mode = picture.mode
    if mode in ("LA", "La"):
        grey: Pixels = stored_pixels[:, :, 0].copy()
        return grey
    colours: Pixels = stored_pixels.copy()
    alpha_kind = picture.tag_v2.get(_TIFF_EXTRA_SAMPLES, (0,))[0]
    if mode == "RGBA" and alpha_kind not in (1, 2):
        return colours
    rounding = 127 if alpha_kind == 2 else 254  # Pillow has divided premultiplied colours and truncated the result
    for block, result in _row_blocks(stored_pixels, colours):
        if mode == "CMYK":
            wide_block = 255 - block.astype(np.uint16)
            result[:, :, :3] = wide_block[:, :, :3] * wide_block[:, :, 3:] // 255
            result[:, :, 3] = 255
        else:
            result[:, :, :3] = (block[:, :, :3] * block[:, :, 3:].astype(np.uint16) + rounding) // 255
    return colours


def _row_blocks(*images: Pixels) -> Iterator[tuple[Pixels, ...]]:
    """Yield the same few rows of all images at a time, so that conversions to wider types need little memory."""
    height, width = images[0].shape[:2]
    rows = max(1, _BLOCK_PIXELS // width)
    for row in range(0, height, rows):
        yield tuple(image[row : row + rows] for image in images)
