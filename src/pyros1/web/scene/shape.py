"""The form in which messages in a scene are sent to a page."""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import Error

Shape = tuple[dict[str, Any], bytes]
"""A description for JSON, and a block of numbers that belongs to it."""

MAX_MAGNITUDE = 1e30
"""Maximum magnitude of numbers: graphics cards use 32-bit floats, which reach 3e38."""


class ShapeError(Error):
    """A message cannot be drawn; the message says why."""
