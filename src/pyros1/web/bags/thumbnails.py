"""Makes thumbnails of recorded images."""

from __future__ import annotations

from io import BytesIO
from typing import Any

from pyros1.bag.export.extras import import_extra
from pyros1.ground.errors import Error, MessageError
from pyros1.web.transforms.image_size import MAX_PIXELS

_JPEG_QUALITY = 80


def thumbnail(message: Any, height: int) -> tuple[bytes, int, int]:
    """Return a thumbnail of an image as a JPEG file, and the image's original width and height.

    Args:
        message: a sensor_msgs/Image or sensor_msgs/CompressedImage.
        height: maximum height of the thumbnail in pixels.

    Raises:
        MessageError: the image is damaged or too large, or its encoding is not supported.
        Error: Pillow is not installed; the message says how to install it.
    """
    pil = import_extra("PIL.Image", "images")
    image = (
        _decode_compressed(pil, message, height)
        if message._type.endswith("CompressedImage")
        else _decode_raw(pil, message)
    )
    original_size = getattr(image, "original_size", image.size)
    factor = min(1.0, height / image.size[1])
    size = max(1, round(image.size[0] * factor)), max(1, round(image.size[1] * factor))
    scaled = image.resize(size) if size != image.size else image
    file = BytesIO()
    (scaled if scaled.mode in ("L", "RGB") else scaled.convert("RGB")).save(file, "JPEG", quality=_JPEG_QUALITY)
    return file.getvalue(), original_size[0], original_size[1]


def _decode_raw(pil: Any, message: Any) -> Any:
    from pyros1.bag.export.images import pixels, to_8_bits  # noqa: PLC0415 - needs numpy, rarely needed

    if message.width * message.height > MAX_PIXELS:
        raise MessageError(f"an image of {message.width} x {message.height} pixels is too large to display")
    return pil.fromarray(to_8_bits(pixels(message)))


def _decode_compressed(pil: Any, message: Any, height: int) -> Any:
    from pyros1.bag.export.image_files import compressed_pixels  # noqa: PLC0415
    from pyros1.bag.export.images import to_8_bits  # noqa: PLC0415

    data = bytes(message.data)
    if not data.startswith(b"\xff\xd8"):
        return pil.fromarray(to_8_bits(compressed_pixels(message, MAX_PIXELS)))
    try:
        image = pil.open(BytesIO(data), formats=("JPEG",))
        original_size = image.size
        if original_size[0] * original_size[1] > MAX_PIXELS:
            raise MessageError(f"an image of {original_size[0]} x {original_size[1]} pixels is too large to display")
        image.draft("RGB", (1, height))  # decoded at a smaller size, which is much faster
        image.load()
    except Error:
        raise
    except pil.UnidentifiedImageError:
        raise MessageError("the image cannot be read: its format is unknown") from None
    except Exception as error:  # noqa: BLE001 - Pillow raises many types of errors for damaged files
        raise MessageError(f"the image cannot be read: {error}") from None
    image.original_size = original_size
    return image
