"""The YAML file that describes a map (no I/O): https://wiki.ros.org/map_server#Map_format."""

from __future__ import annotations

from math import isfinite
from typing import Any, NamedTuple

from pyros1.ground.terminal_text import one_line
from pyros1.robot_nodes.map_server.errors import MapMetadataError
from pyros1.values.reading import YamlError, load_yaml

MODES = ("trinary", "scale", "raw")


class Description(NamedTuple):
    """The content of a map's YAML file.

    Attributes:
        image: path of the image, absolute or relative to the YAML file.
        resolution: size of a pixel in m.
        origin: pose of the image's lower left corner in the map's frame: x and y in m, yaw in radians.
        negate: whether dark pixels are free, and bright ones occupied.
        occupied_thresh: occupancy above which a cell is occupied, from 0 to 1.
        free_thresh: occupancy below which a cell is free.
        mode: how all other cells are interpreted: as unknown ("trinary") or as a percentage ("scale"). In "raw", pixels
            are cells.
    """

    image: str
    resolution: float
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    negate: bool = False
    occupied_thresh: float = 0.65
    free_thresh: float = 0.196
    mode: str = "trinary"


def parse_description(text: str) -> Description:
    """Parse the YAML file of a map.

    Raises:
        MapMetadataError: the file is not YAML, or a value is missing or cannot be used.
    """
    try:
        values = load_yaml(text)
    except YamlError as error:
        raise MapMetadataError(str(error)) from None
    if not isinstance(values, dict):
        raise MapMetadataError("it must be YAML with image, resolution, origin, negate and thresholds")
    image = values.get("image")
    if not isinstance(image, str) or not image:
        raise MapMetadataError(_must_be("image", image, "the path of a picture"))
    resolution = _number(values, "resolution")
    if resolution <= 0:
        raise MapMetadataError(_must_be("resolution", resolution, "a number of metres above 0"))
    mode = values.get("mode", "trinary")
    if mode not in MODES:
        raise MapMetadataError(_must_be("mode", mode, "trinary, scale or raw"))
    return Description(
        image,
        resolution,
        _origin(values.get("origin")),
        bool(_number(values, "negate")),
        _number(values, "occupied_thresh"),
        _number(values, "free_thresh"),
        mode,
    )


def _origin(value: Any) -> tuple[float, float, float]:
    numbers = [_to_number(each) for each in value] if isinstance(value, list) and len(value) == 3 else []
    if not numbers or None in numbers:
        raise MapMetadataError(_must_be("origin", value, "[x, y, yaw]"))
    x, y, yaw = (number or 0.0 for number in numbers)
    return x, y, yaw


def _number(values: Any, name: str) -> float:
    number = _to_number(values.get(name))
    if number is None:
        raise MapMetadataError(_must_be(name, values.get(name), "a number"))
    return number


def _to_number(value: object) -> float | None:
    """Convert a YAML value: 1e-2 is a number in the original, but a string in YAML 1.1; negate may be false."""
    try:
        number = float(value) if isinstance(value, (int, float, str)) else None
    except (ValueError, OverflowError):
        return None
    return number if number is None or isfinite(number) else None


def _must_be(name: str, value: object, expected: str) -> str:
    return f"{name} must be {expected}" + ("" if value is None else f", not {one_line(repr(value), 100)}")


def format_description(image: str, resolution: float, origin: tuple[float, float, float]) -> str:
    """Return the YAML file for a map that `cells.to_pixels` made, in the original's format.

    Args:
        image: the image's path.
        resolution: size of a pixel in m.
        origin: x and y in m, yaw in radians.
    """
    defaults = Description(image, resolution)
    x, y, yaw = origin
    return (
        f"image: {image}\nresolution: {resolution:f}\norigin: [{x:f}, {y:f}, {yaw:f}]\nnegate: 0\n"
        f"occupied_thresh: {defaults.occupied_thresh}\nfree_thresh: {defaults.free_thresh}\n\n"
    )
