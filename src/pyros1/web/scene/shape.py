"""The form in which a scene's messages are sent to a page."""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import Error

Shape = tuple[dict[str, Any], bytes]
"""A description as JSON, and the block of numbers that it describes."""

MAX_MAGNITUDE = 1e30
"""Numbers of this magnitude or more are treated as non-finite: graphics cards use 32-bit floats, which reach 3e38."""


class ShapeError(Error):
    """A message cannot be drawn. The error's text says why."""
