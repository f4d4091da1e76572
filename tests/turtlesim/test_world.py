"""Who is in the world, and what is drawn in it."""

from __future__ import annotations

import pytest

from pyros1.turtlesim.canvas import Canvas
from pyros1.turtlesim.turtle import PICTURE_SIZE, WORLD_SIZE, Pen, Position
from pyros1.turtlesim.world import BACKGROUND, MAX_TURTLES, TurtleError, World

RED = Pen(255, 0, 0, 3)


def test_names() -> None:
    world = World()
    assert [world.spawn("", 1, 1, 0), world.spawn("turtle3", 1, 1, 0), world.spawn("", 1, 1, 0)] == [
        "turtle1",
        "turtle3",
        "turtle2",
    ]
    with pytest.raises(TurtleError, match=r"A turtle named \[turtle2\] already exists"):
        world.spawn("turtle2", 1, 1, 0)
    world.kill("turtle2")
    assert world.spawn("", 1, 1, 0) == "turtle4"  # as stock, which never gives a number twice
    with pytest.raises(TurtleError, match=r"Tried to kill turtle \[turtle2\], which does not exist"):
        world.kill("turtle2")
    world.reset()
    assert list(world.turtles) == ["turtle1"] and world.spawn("", 1, 1, 0) == "turtle2"


def test_there_are_not_too_many() -> None:
    world = World()
    for _ in range(MAX_TURTLES):
        world.spawn("", 1, 1, 0)
    with pytest.raises(TurtleError, match="turtles already"):
        world.spawn("", 1, 1, 0)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf"), 1e300])
def test_numbers_with_which_nobody_can_calculate(bad: float) -> None:
    world = World()
    name = world.spawn("", 1, 1, 0)
    for call in (
        lambda: world.spawn("", 1, bad, 0),
        lambda: world.teleport_absolute(name, 1, 1, bad),
        lambda: world.teleport_relative(name, bad, 0),
        lambda: world.command(name, 0, 0, bad, 0.0),
    ):
        with pytest.raises(TurtleError, match="must be a number from"):
            call()
    assert list(world.turtles) == [name] and world.turtles[name].position == (1, 1)


def test_turtles_that_are_gone_do_nothing() -> None:
    world = World()
    world.command("nobody", 1, 1, 1, 0.0)
    for call in (lambda: world.teleport_absolute("nobody", 1, 1, 1), lambda: world.set_pen("nobody", RED)):
        with pytest.raises(TurtleError, match="there is no turtle"):
            call()


def test_a_turtle_draws_and_sees_the_colour_below_it_before_that() -> None:
    world = World()
    name = world.spawn("", 5, 5, 0)
    world.command(name, 30.0, 0, 0, now=0.0)
    assert [step.colour for step in world.step(0.0)] == [BACKGROUND]
    assert world.canvas.colour_at(Position(5.2, 5)) == (179, 184, 255)
    assert world.canvas.colour_at(Position(5.2, 5.1)) == BACKGROUND
    world.set_pen(name, RED)
    world.teleport_absolute(name, 5, 8, 0)
    assert world.canvas.colour_at(Position(5, 8)) == RED[:3]
    world.set_pen(name, Pen(off=True))
    world.teleport_absolute(name, 8, 8, 0)
    assert world.canvas.colour_at(Position(7, 8)) == BACKGROUND
    assert world.turtles[name].pen == RED._replace(off=True)
    world.set_pen(name, Pen(0, 255, 0, 1))
    world.teleport_relative(name, 1.0, 0.0)
    assert world.canvas.colour_at(Position(8.9, 8)) == (0, 255, 0)
    assert world.canvas.colour_at(Position(5, 8)) == RED[:3]


def test_a_line_is_as_wide_as_its_pen() -> None:
    for width in (1, 3, 10, 255):
        canvas = Canvas((0, 0, 0))
        canvas.draw_line(Position(1, WORLD_SIZE / 2), Position(10, WORLD_SIZE / 2), Pen(1, 2, 3, width))
        column = canvas.pixels()[3 * (PICTURE_SIZE // 2) :: 3 * PICTURE_SIZE]
        assert abs(sum(column) - width) <= 1, "one pixel for each pixel of the pen"


def test_lines_beyond_the_walls_and_at_them() -> None:
    canvas = Canvas((9, 9, 9))
    blank, version = canvas.pixels(), canvas.version
    canvas.draw_line(Position(-3, -3), Position(-2, -9), RED)
    canvas.draw_line(Position(1e9, 5), Position(2e9, 5), RED)
    assert (canvas.pixels(), canvas.version) == (blank, version)
    canvas.draw_line(Position(-1e9, 5), Position(1e9, 5), RED)
    assert all(canvas.colour_at(Position(x, 5)) == RED[:3] for x in (0, 5, WORLD_SIZE))
    for corner in (Position(0, 0), Position(WORLD_SIZE, WORLD_SIZE), Position(0, WORLD_SIZE), Position(WORLD_SIZE, 0)):
        canvas.draw_line(corner, corner, RED)
        assert canvas.colour_at(corner) == RED[:3]
    canvas.clear((1, 2, 3))
    assert canvas.pixels() == bytes([1, 2, 3]) * PICTURE_SIZE**2
