"""Reads maps from files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.robot_nodes.map_server.cells import to_cells
from pyros1.robot_nodes.map_server.description import Description, parse_description
from pyros1.robot_nodes.map_server.errors import MapDataError, MapError, MapMissingError
from pyros1.robot_nodes.map_server.pgm import MAX_PIXELS, is_pgm, read_pgm
from pyros1.robot_nodes.shared.user_files import read_regular_file

_MAX_YAML_BYTES = 1 << 20
_MAX_PICTURE_BYTES = 1 << 29


class Map(NamedTuple):
    """A map.

    Attributes:
        cells: 0 (free) to 100 (occupied), or -1 (unknown); shape (height, width), the lowest row first.
        resolution: size of a cell in m.
        origin: pose of the corner of cell (0, 0): x and y in m, yaw in radians.
    """

    cells: NDArray[np.int8]
    resolution: float
    origin: tuple[float, float, float]


def load_map(path: str) -> Map:
    """Read the map that a YAML file describes.

    Raises:
        MapMissingError: a file cannot be read.
        MapMetadataError, MapDataError: a file is damaged; the message begins with its path.
        Error: Pillow is needed, and not installed.
    """
    with _naming(path):
        description = parse_description(_read(path, _MAX_YAML_BYTES).decode("utf-8", "replace"))
    image = os.path.join(os.path.dirname(path), description.image)
    return load_picture(description._replace(image=image))


def load_picture(description: Description) -> Map:
    """Read a map whose description is known; raises the same errors as `load_map`."""
    with _naming(description.image):
        cells = to_cells(_read_pixels(description.image), description)
    return Map(cells, description.resolution, description.origin)


@contextmanager
def _naming(path: str) -> Iterator[None]:
    """Add a file's path to the beginning of errors about it."""
    try:
        yield
    except MapError as error:
        raise type(error)(f"{one_line(path, 1000)}: {error}") from None


def _read_pixels(path: str) -> NDArray[np.uint8]:
    data = _read(path, _MAX_PICTURE_BYTES)
    if is_pgm(data):
        return read_pgm(data)
    from pyros1.observe.image_files import ImageFileError, decode, import_pillow  # noqa: PLC0415 - most maps are PGM

    try:
        import_pillow()
    except Error:
        raise MapDataError("maps in formats other than PGM need Pillow: pip install 'pyros1[images]'") from None
    try:
        pixels = decode(data, MAX_PIXELS)
    except ImageFileError as error:
        raise MapDataError(str(error)) from None
    if pixels.dtype == np.uint16:  # as in SDL, the upper bits count
        pixels = pixels >> 8
    if pixels.dtype.kind not in "ui":
        raise MapDataError(f"pictures with pixels of {pixels.dtype} cannot be maps; save it as PGM or PNG")
    return pixels.astype(np.uint8)


def _read(path: str, max_bytes: int) -> bytes:
    try:
        data = read_regular_file(path, max_bytes + 1)
    except (OSError, ValueError) as error:
        # roslaunch does not start nodes in the user's current folder.
        where = "" if os.path.isabs(path) else f" (in the folder {os.getcwd()}; nodes of launch files need a full path)"
        raise MapMissingError(f"cannot be read: {getattr(error, 'strerror', None) or error}{where}") from None
    if len(data) > max_bytes:
        raise MapDataError(f"too large: at most {max_bytes >> 20} MiB can be read")
    return data
