"""Image files to arrays of pixels and back, without loss of depth or opacity: JPEG, PNG and other formats of Pillow.

Pixels are like those of OpenCV's ``imread`` with ``IMREAD_UNCHANGED``, but with red first. Needs Pillow.
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
"""Maximum number of pixels of an image to unpack, unless the caller sets a lower one."""
_FORMATS = ("JPEG", "PNG", "BMP", "TIFF", "WEBP", "PPM", "JPEG2000")
_NAMES = {"jpg": "JPEG", "jpe": "JPEG", "tif": "TIFF", "dib": "BMP", "jp2": "JPEG2000", "pgm": "PPM", "pbm": "PPM"}
"""File extensions that are not names of Pillow's formats."""
_DEEP_COST = 4
"""Files with 16 bits per channel need this many times more memory per pixel than others."""
_BLOCK = 1 << 16
"""Number of pixels calculated at a time."""
_END_OF_JPEG = b"\xff\xd9"
_TIFF_BITS, _TIFF_MORE, _TIFF_NUMBERS = 258, 338, 339
"""Tags of TIFF: bits of each channel; kind of the channels after the colours: 1 or 2 for opacity, by which the colours
are or are not multiplied; and kind of the numbers: 1 unsigned, 2 signed integers, 3 floating point."""
_TIFF_KINDS = ("u1", "u2", "i4", "f4")


class ImageFileError(MessageError):
    """An image cannot be read, or cannot be written in a format."""


class UnsupportedFileError(ImageFileError):
    """Pillow would lose bits of the image; OpenCV would not. The text gives an alternative."""


def pillow() -> Any:
    """Return the module PIL.Image; raises Error if it is not installed."""
    try:
        return import_module("PIL.Image")
    except ImportError as error:
        raise Error(f"compressed images need Pillow ({error}): pip install 'pyros1[images]'") from None


def decode(data: bytes, max_pixels: int = MAX_PIXELS) -> Pixels:
    """Return the pixels of an image file.

    Args:
        data: the file. A JPEG file may be truncated: the missing part is grey, like with other readers.
        max_pixels: an image with more pixels is refused.

    Returns:
        An array of shape (height, width), or (height, width, 3 or 4) with red, green, blue and opacity; of uint8, or of
        uint16, int32 or float32 if the file contains such numbers.

    Raises:
        ImageFileError: the file is damaged or too large, or its format or depth is not supported.
        Error: Pillow is not installed.
    """
    module = pillow()
    _ignore_warnings()
    try:
        with module.open(BytesIO(data + _END_OF_JPEG), formats=_FORMATS) as picture:
            head = png16.header(data)
            # Of several headers in a file, Pillow takes the last.
            width, height = map(max, picture.size, (head.width, head.height) if head else (0, 0))
            if width * height > (max_pixels // _DEEP_COST if head is not None and head.bits == 16 else max_pixels):
                raise _too_large(max_pixels, f" of {width} x {height} pixels")
            return _unpacked(module, picture, data)
    except MessageError:
        raise
    except module.UnidentifiedImageError:
        raise ImageFileError("the image cannot be read: its format is not known") from None
    except module.DecompressionBombError:
        raise _too_large(max_pixels) from None
    except Exception as error:  # noqa: BLE001 - Pillow raises many kinds for damaged files
        raise ImageFileError(f"the image cannot be read: {error}") from None


def encode(image: Pixels, form: str, **options: Any) -> bytes:
    """Return an image file.

    Args:
        image: array of shape (height, width), or (height, width, 1, 3 or 4) with red, green, blue and opacity. Numbers
            outside the format's range become the nearest from 0 to 255; opacity is left out if it has none.
        form: the format, or the extension of such files: "jpg", "png" ...
        options: Pillow's for that format, for example ``quality`` of JPEG or ``compress_level`` of PNG.

    Raises:
        ImageFileError: the format does not exist, or cannot store such an image.
        Error: Pillow is not installed.
    """
    name = _NAMES.get(form.lower(), form.upper())
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if not image.size or image.ndim not in (2, 3) or image.shape[2:] not in ((), (3,), (4,)):
        raise ImageFileError(f"an image with the shape {image.shape} cannot be written as {form}")
    kind = image.dtype.str[1:]
    if name == "PNG" and kind == "u2" and image.ndim == 3:
        return png16.write(image, options.get("compress_level", 6))
    deep = {"PNG": ("u2",), "TIFF": _TIFF_KINDS, "PPM": ("u2",), "JPEG2000": ("u2",)}.get(name, ())
    if kind not in deep and name not in ("TIFF", "PPM", "JPEG2000"):
        image = to_bytes(image)
    elif kind != "u1" and (kind not in deep or image.ndim == 3):
        raise UnsupportedFileError(
            f"an image of {image.dtype} with the shape {image.shape} cannot be written as {form}; write 8 bits, or PNG"
        )
    if name in ("JPEG", "BMP", "PPM") and image.ndim == 3:
        image = image[:, :, :3]
    if name == "PPM" and kind == "u2":
        image = image.astype(np.int32)
    file = BytesIO()
    try:
        pillow().fromarray(np.ascontiguousarray(image.astype(image.dtype.newbyteorder("=")))).save(
            file, name, **options
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ImageFileError(f"the image cannot be written as {form}: {error}") from None
    return file.getvalue()


def _ignore_warnings() -> None:
    """Keep Pillow from writing warnings to the terminal, for example about damaged or large files: we report errors."""
    pattern = r"PIL\."
    if not any(kind == "ignore" and module and module.pattern == pattern for kind, _, _, module, _ in warnings.filters):
        warnings.filterwarnings("ignore", module=pattern)


def _too_large(max_pixels: int, size: str = "") -> ImageFileError:
    return ImageFileError(f"the image{size} is too large: at most {max_pixels} pixels can be read")


def to_bytes(image: Pixels) -> NDArray[np.uint8]:
    """Return numbers as the nearest from 0 to 255; nan and numbers beyond 32 bits become 0, like in OpenCV."""
    if image.dtype == np.uint8:
        return image
    if image.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            image = np.where(np.abs(image) < 1 << 31, np.rint(image), 0)
    return np.clip(image, 0, 255).astype(np.uint8)


def _unpacked(module: Any, picture: Any, data: bytes) -> Pixels:
    head = png16.header(data)
    if head is not None and head.bits == 16 and head.colour:
        found = png16.read(data, module)
        return np.dstack([found[:, :, :1]] * 3 + [found[:, :, 1:]]) if found.shape[2] == 2 else found
    mode, name = picture.mode, picture.format
    if mode in ("RGB", "RGBA", "LA", "La", "CMYK") and _is_deep(picture, data):
        raise UnsupportedFileError(
            f"a colour {name} file with more than 8 bits per channel cannot be read without loss; send PNG instead"
        )
    if name == "TIFF" and mode in ("RGBA", "LA", "La", "CMYK"):
        return _from_tiff(picture)
    if mode == "CMYK":
        return _from_cmyk(picture)
    if name == "TIFF" and picture.tag_v2.get(_TIFF_NUMBERS, (1,))[0] == 2 and mode in ("L", "I"):
        return np.asarray(picture).astype(f"i{picture.tag_v2[_TIFF_BITS][0] // 8}")
    if mode == "F" or mode.startswith("I"):
        return np.asarray(picture).astype(np.float32 if mode == "F" else np.uint16)
    clear = "transparency" in picture.info
    if name == "WEBP" or mode not in ("1", "L"):
        mode = "RGBA" if clear or mode in ("RGBA", "LA", "PA") else "RGB"
    else:
        mode = "L"
    return np.array(picture.convert(mode))


def _is_deep(picture: Any, data: bytes) -> bool:
    """Return whether Pillow discards bits of the colours."""
    if picture.format == "TIFF":
        return bool(max(picture.tag_v2.get(_TIFF_BITS, (8,))) > 8)
    if picture.format == "PPM":
        return bool(picture.tile[0][3][-1] != 255) if isinstance(picture.tile[0][3], tuple) else False
    if picture.format == "JPEG2000":
        at = data.find(b"\xff\x51")  # the segment SIZ: the depth of its first component
        return 0 <= at < len(data) - 41 and data[at + 40] & 0x7F > 7
    return False


def _from_cmyk(picture: Any) -> Pixels:
    """Return the colours of a picture for printers (CMYK), calculated like in OpenCV."""
    stored: Pixels = np.asarray(picture)
    turned = "adobe" in picture.info  # by Pillow
    colours: Pixels = np.empty((*stored.shape[:2], 3), np.uint8)
    for part, found in _blocks(stored, colours):
        wide = (~part if turned else part).astype(np.uint16)
        black = wide[:, :, 3:]
        found[:] = black - ((255 - wide[:, :, :3]) * black >> 8)
    return colours


def _from_tiff(picture: Any) -> Pixels:
    """Return the pixels of a TIFF file with opacity, or for printers, calculated like in OpenCV (libtiff)."""
    stored: Pixels = np.asarray(picture)
    mode = picture.mode
    if mode in ("LA", "La"):
        grey: Pixels = stored[:, :, 0].copy()
        return grey
    colours: Pixels = stored.copy()
    opacity = picture.tag_v2.get(_TIFF_MORE, (0,))[0]
    if mode == "RGBA" and opacity not in (1, 2):
        return colours
    half = 127 if opacity == 2 else 254  # Pillow has divided premultiplied colours, and discarded the fraction
    for part, found in _blocks(stored, colours):
        if mode == "CMYK":
            wide = 255 - part.astype(np.uint16)
            found[:, :, :3] = wide[:, :, :3] * wide[:, :, 3:] // 255
            found[:, :, 3] = 255
        else:
            found[:, :, :3] = (part[:, :, :3] * part[:, :, 3:].astype(np.uint16) + half) // 255
    return colours


def _blocks(*images: Pixels) -> Iterator[tuple[Pixels, ...]]:
    """Yield a few rows of images at a time, so that calculations with larger types need little memory."""
    height, width = images[0].shape[:2]
    rows = max(1, _BLOCK // width)
    for row in range(0, height, rows):
        yield tuple(image[row : row + rows] for image in images)
