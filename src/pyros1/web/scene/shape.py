"""The form in which a scene's messages are sent to a page."""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import Error

Shape = tuple[dict[str, Any], bytes]
"""What to draw, as a dict for JSON, and the bytes of its arrays of numbers (vertices, colours and the like)."""

MAX_MAGNITUDE = 1e30
"""Numbers of this magnitude or more are treated as non-finite: graphics cards use 32-bit floats, which reach 3e38."""


class ShapeError(Error):
    """A message cannot be drawn. The error's text says why."""
