"""The world of the turtles: who is in it, and what is drawn in it."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from pyros1.ground.errors import Error
from pyros1.turtlesim.canvas import Canvas, Colour
from pyros1.turtlesim.turtle import PERIOD, Pen, Position, Turtle

BACKGROUND: Colour = (69, 86, 255)
MAX_TURTLES = 100
"""Most turtles."""
_MAX_VALUE = 1e9


class TurtleError(Error):
    """Something cannot be done; the text says why."""


class Step(NamedTuple):
    """What a step did to a turtle.

    Attributes:
        name: the turtle's.
        turtle: a copy of the turtle.
        colour: of what was below it when it came.
        requested: where it would be without the wall; None if it hit none.
    """

    name: str
    turtle: Turtle
    colour: Colour
    requested: Position | None


class World:
    """Turtles on a canvas.

    Attributes:
        turtles: by name, in the order in which they came.
        canvas: what they have drawn.
    """

    def __init__(self) -> None:
        self.turtles: dict[str, Turtle] = {}
        self.canvas = Canvas(BACKGROUND)
        self._number = 0

    def spawn(self, name: str, x: float, y: float, theta: float) -> str:
        """Let a turtle come, and return its name.

        Args:
            name: empty for the next free one of turtle1, turtle2, ...
            x, y, theta: where, in units and radians.

        Raises:
            TurtleError: there is one of that name, there are too many, or the place is none.
        """
        if len(self.turtles) >= MAX_TURTLES:
            raise TurtleError(f"There are {MAX_TURTLES} turtles already")
        check(x=x, y=y, theta=theta)
        if not name:
            name = self._free_name()
        if name in self.turtles:
            raise TurtleError(f"A turtle named [{name}] already exists")
        turtle = self.turtles[name] = Turtle()
        turtle.teleport_absolute(x, y, theta)
        return name

    def _free_name(self) -> str:
        while True:
            self._number += 1
            if (name := f"turtle{self._number}") not in self.turtles:
                return name

    def kill(self, name: str) -> None:
        """Remove a turtle; what it has drawn stays.

        Raises:
            TurtleError: there is none of that name.
        """
        if self.turtles.pop(name, None) is None:
            raise TurtleError(f"Tried to kill turtle [{name}], which does not exist")

    def reset(self) -> None:
        """Begin anew, with turtle1 in the middle. The canvas is another matter."""
        self.turtles = {"turtle1": Turtle()}
        self._number = 1

    def command(self, name: str, forward: float, sideways: float, turning: float, now: float) -> None:
        """See `Turtle.command`. A turtle that is gone obeys nobody.

        Raises:
            TurtleError: a speed is no number.
        """
        check(forward=forward, sideways=sideways, turning=turning)
        if name in self.turtles:
            self.turtles[name].command(forward, sideways, turning, now)

    def set_pen(self, name: str, pen: Pen) -> None:
        """Give a turtle another pen; one that is off leaves it the colour and width that it has.

        Raises:
            TurtleError: there is no such turtle.
        """
        turtle = self._turtle(name)
        turtle.pen = turtle.pen._replace(off=True) if pen.off else pen

    def teleport_absolute(self, name: str, x: float, y: float, theta: float) -> None:
        """See `Turtle.teleport_absolute`; draws a line.

        Raises:
            TurtleError: the place is none, or there is no such turtle.
        """
        check(x=x, y=y, theta=theta)
        turtle = self._turtle(name)
        previous = turtle.position
        turtle.teleport_absolute(x, y, theta)
        self.canvas.line(previous, turtle.position, turtle.pen)

    def teleport_relative(self, name: str, distance: float, angle: float) -> None:
        """See `Turtle.teleport_relative`; draws a line.

        Raises:
            TurtleError: a number is none, or there is no such turtle.
        """
        check(linear=distance, angular=angle)
        turtle = self._turtle(name)
        previous = turtle.position
        turtle.teleport_relative(distance, angle)
        self.canvas.line(previous, turtle.position, turtle.pen)

    def _turtle(self, name: str) -> Turtle:
        try:
            return self.turtles[name]
        except KeyError:
            raise TurtleError(f"there is no turtle [{name}]") from None

    def step(self, now: float, seconds: float = PERIOD) -> list[Step]:
        """Move all turtles, see `Turtle.step`."""
        steps = []
        for name, turtle in self.turtles.items():
            previous = turtle.position
            requested = turtle.step(now, seconds)
            # First the colour: a turtle does not see the line that it just draws.
            steps.append(Step(name, replace(turtle), self.canvas.colour(turtle.position), requested))
            if turtle.position != previous:
                self.canvas.line(previous, turtle.position, turtle.pen)
        return steps


def check(**numbers: float) -> None:
    """Check that numbers are some with which one can calculate.

    Raises:
        TurtleError: one is not.
    """
    for name, number in numbers.items():
        if not abs(number) <= _MAX_VALUE:
            raise TurtleError(f"{name} must be a number from {-_MAX_VALUE:.0e} to {_MAX_VALUE:.0e}, not {number}")
