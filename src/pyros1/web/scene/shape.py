"""The shape of a message in a scene."""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import Error

Shape = tuple[dict[str, Any], bytes]
"""Facts for JSON, and a block of numbers that goes with them."""

MAX_MAGNITUDE = 1e30
"""Upper bound of numbers: graphics cards calculate with 32-bit floats, which reach 3e38."""


class ShapeError(Error):
    """A message cannot be drawn; the text says why."""
