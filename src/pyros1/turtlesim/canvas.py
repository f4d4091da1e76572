"""The picture that the turtles draw, as pixels: memory use is fixed, and a turtle can ask for the colour under it."""

from __future__ import annotations

from math import ceil, floor

import numpy

from pyros1.turtlesim.turtle import PICTURE_SIZE, PIXELS_PER_UNIT, Pen, Position

Colour = tuple[int, int, int]
"""Red, green and blue, each from 0 to 255."""


class Canvas:
    """The picture on which turtles draw.

    Args:
        background: the background's colour.

    Attributes:
        version: a number that increases with each change.
    """

    def __init__(self, background: Colour) -> None:
        self._pixels = numpy.empty((PICTURE_SIZE, PICTURE_SIZE, 3), numpy.uint8)
        self.version = 0
        self.clear(background)

    def clear(self, background: Colour) -> None:
        """Remove everything that was drawn, and set the background."""
        self._pixels[:] = background
        self.version += 1

    def draw_line(self, start: Position, end: Position, pen: Pen) -> None:
        """Draw a straight line with round ends, or nothing if the pen is off."""
        if pen.off:
            return
        (x, y), (to_x, to_y) = _to_pixels(start), _to_pixels(end)
        radius = max(pen.width, 1) / 2
        first_column, last_column = _pixel_range(x, to_x, radius)
        top, bottom = _pixel_range(y, to_y, radius)
        if first_column >= last_column or top >= bottom:
            return  # the line is outside the walls
        delta_x, delta_y = to_x - x, to_y - y
        columns = numpy.arange(first_column, last_column) - x
        rows = (numpy.arange(top, bottom) - y)[:, None]
        # `along` is, for each pixel, the position of the nearest point on the line, from 0 (start) to 1 (end).
        length = delta_x * delta_x + delta_y * delta_y
        along = numpy.clip((columns * delta_x + rows * delta_y) / length, 0, 1) if length else 0
        distance = (columns - along * delta_x) ** 2 + (rows - along * delta_y) ** 2
        self._pixels[top:bottom, first_column:last_column][distance <= radius * radius] = pen[:3]
        self.version += 1

    def colour_at(self, position: Position) -> Colour:
        """Return the colour at a position within the walls."""
        x, y = _to_pixels(position)
        red, green, blue = self._pixels[round(y), round(x)].tolist()
        return red, green, blue

    def pixels(self) -> bytes:
        """Return all pixels as red, green and blue bytes, in rows of `PICTURE_SIZE` pixels from top to bottom."""
        return self._pixels.tobytes()


def _to_pixels(position: Position) -> tuple[float, float]:
    return position.x * PIXELS_PER_UNIT, PICTURE_SIZE - 1 - position.y * PIXELS_PER_UNIT


def _pixel_range(first: float, second: float, radius: float) -> tuple[int, int]:
    low, high = min(first, second) - radius, max(first, second) + radius
    return floor(max(low, 0)), ceil(min(high, PICTURE_SIZE - 1)) + 1
