"""What a message looks like."""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import Error

Shape = tuple[dict[str, Any], bytes]
"""Facts for JSON, and a block of numbers that goes with them."""


class ShapeError(Error):
    """A message cannot be drawn; the text says why."""
