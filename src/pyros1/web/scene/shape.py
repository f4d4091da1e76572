"""What a message looks like."""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import Error

Shape = tuple[dict[str, Any], bytes]
"""Facts for JSON, and a block of numbers that goes with them."""

MAX_MAGNITUDE = 1e30
"""Numbers must be smaller: graphics cards calculate with what 32 bits can hold, which is up to 3e38."""


class ShapeError(Error):
    """A message cannot be drawn; the text says why."""
