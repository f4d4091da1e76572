"""The simulated world: the turtles and their drawing (no I/O)."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from pyros1.ground.errors import Error
from pyros1.turtlesim.canvas import Canvas, Colour
from pyros1.turtlesim.turtle import STEP_PERIOD, Pen, Position, Turtle

BACKGROUND: Colour = (69, 86, 255)
MAX_TURTLES = 100
"""Maximum number of turtles."""
_MAX_VALUE = 1e9


class TurtleError(Error):
    """A request about a turtle is invalid; the error message says why."""


class StepResult(NamedTuple):
    """The result of a step for one turtle.

    Attributes:
        name: the turtle's name.
        turtle: a copy of the turtle after the step.
        colour: the colour below the turtle, without the line that it draws in this step.
        requested: the position that the turtle would have reached without walls; None if it has not hit a wall.
    """

    name: str
    turtle: Turtle
    colour: Colour
    requested: Position | None


class World:
    """Turtles on a canvas.

    Attributes:
        turtles: the turtles by name, in the order in which they were spawned.
        canvas: the turtles' drawing.
    """

    def __init__(self) -> None:
        self.turtles: dict[str, Turtle] = {}
        self.canvas = Canvas(BACKGROUND)
        self._last_number = 0

    def spawn(self, name: str, x: float, y: float, theta: float) -> str:
        """Add a turtle, and return its name.

        Args:
            name: the turtle's name; if empty, the next unused name among turtle1, turtle2, ...
            x, y, theta: the turtle's pose in units and radians.

        Raises:
            TurtleError: a turtle already has the name, there are `MAX_TURTLES` turtles, or a number is out of range.
        """
        if len(self.turtles) >= MAX_TURTLES:
            raise TurtleError(f"There are {MAX_TURTLES} turtles already")
        check_range(x=x, y=y, theta=theta)
        if not name:
            name = self._next_free_name()
        if name in self.turtles:
            raise TurtleError(f"A turtle named [{name}] already exists")
        turtle = self.turtles[name] = Turtle()
        turtle.teleport_absolute(x, y, theta)
        return name

    def _next_free_name(self) -> str:
        while True:
            self._last_number += 1
            if (name := f"turtle{self._last_number}") not in self.turtles:
                return name

    def kill(self, name: str) -> None:
        """Remove a turtle; what it has drawn stays.

        Raises:
            TurtleError: no turtle has this name.
        """
        if self.turtles.pop(name, None) is None:
            raise TurtleError(f"Tried to kill turtle [{name}], which does not exist")

    def reset(self) -> None:
        """Replace all turtles with a new turtle1 in the middle. The canvas is not cleared."""
        self.turtles = {"turtle1": Turtle()}
        self._last_number = 1

    def command(self, name: str, forward: float, sideways: float, turning: float, now: float) -> None:
        """Set a turtle's speeds, see `Turtle.command`. Commands to a removed turtle have no effect.

        Raises:
            TurtleError: a speed is out of range.
        """
        check_range(forward=forward, sideways=sideways, turning=turning)
        if name in self.turtles:
            self.turtles[name].command(forward, sideways, turning, now)

    def set_pen(self, name: str, pen: Pen) -> None:
        """Set a turtle's pen. A pen that is off leaves the colour and width unchanged.

        Raises:
            TurtleError: no turtle has this name.
        """
        turtle = self._get_turtle(name)
        turtle.pen = turtle.pen._replace(off=True) if pen.off else pen

    def teleport_absolute(self, name: str, x: float, y: float, theta: float) -> None:
        """Move a turtle to a pose at once, drawing a line; see `Turtle.teleport_absolute`.

        Raises:
            TurtleError: a number is out of range, or no turtle has this name.
        """
        check_range(x=x, y=y, theta=theta)
        turtle = self._get_turtle(name)
        previous = turtle.position
        turtle.teleport_absolute(x, y, theta)
        self.canvas.draw_line(previous, turtle.position, turtle.pen)

    def teleport_relative(self, name: str, distance: float, angle: float) -> None:
        """Move a turtle by a distance at once, drawing a line; see `Turtle.teleport_relative`.

        Raises:
            TurtleError: a number is out of range, or no turtle has this name.
        """
        check_range(linear=distance, angular=angle)
        turtle = self._get_turtle(name)
        previous = turtle.position
        turtle.teleport_relative(distance, angle)
        self.canvas.draw_line(previous, turtle.position, turtle.pen)

    def _get_turtle(self, name: str) -> Turtle:
        try:
            return self.turtles[name]
        except KeyError:
            raise TurtleError(f"there is no turtle [{name}]") from None

    def step(self, now: float, seconds: float = STEP_PERIOD) -> list[StepResult]:
        """Move all turtles, see `Turtle.step`; return the result for each turtle."""
        results = []
        for name, turtle in self.turtles.items():
            previous = turtle.position
            requested = turtle.step(now, seconds)
            # The colour is read first, so that a turtle does not see the line that it is drawing.
            results.append(StepResult(name, replace(turtle), self.canvas.colour_at(turtle.position), requested))
            if turtle.position != previous:
                self.canvas.draw_line(previous, turtle.position, turtle.pen)
        return results


def check_range(**numbers: float) -> None:
    """Check that numbers, given by name, are within the allowed range.

    Raises:
        TurtleError: a number is out of range.
    """
    for name, number in numbers.items():
        if not abs(number) <= _MAX_VALUE:
            raise TurtleError(f"{name} must be a number from {-_MAX_VALUE:.0e} to {_MAX_VALUE:.0e}, not {number}")
