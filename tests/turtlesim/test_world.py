"""Who is in the world, and what is drawn in it."""

from __future__ import annotations

import pytest

from pyros1.turtlesim.canvas import Canvas
from pyros1.turtlesim.turtle import PIXELS, SIZE, Pen, Place
from pyros1.turtlesim.world import BACKGROUND, MOST, TurtleError, World

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
    for _ in range(MOST):
        world.spawn("", 1, 1, 0)
    with pytest.raises(TurtleError, match="turtles already"):
        world.spawn("", 1, 1, 0)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf"), 1e300])
def test_numbers_with_which_nobody_can_calculate(bad: float) -> None:
    world = World()
    name = world.spawn("", 1, 1, 0)
    for call in (
        lambda: world.spawn("", 1, bad, 0),
        lambda: world.put(name, 1, 1, bad),
        lambda: world.hop(name, bad, 0),
        lambda: world.command(name, 0, 0, bad, 0.0),
    ):
        with pytest.raises(TurtleError, match="must be a number from"):
            call()
    assert list(world.turtles) == [name] and world.turtles[name].place == (1, 1)


def test_turtles_that_are_gone_do_nothing() -> None:
    world = World()
    world.command("nobody", 1, 1, 1, 0.0)
    for call in (lambda: world.put("nobody", 1, 1, 1), lambda: world.set_pen("nobody", RED)):
        with pytest.raises(TurtleError, match="there is no turtle"):
            call()


def test_a_turtle_draws_and_sees_the_colour_below_it_before_that() -> None:
    world = World()
    name = world.spawn("", 5, 5, 0)
    world.command(name, 30.0, 0, 0, now=0.0)
    assert [step.colour for step in world.step(0.0)] == [BACKGROUND]
    assert world.canvas.colour(Place(5.2, 5)) == (179, 184, 255)
    assert world.canvas.colour(Place(5.2, 5.1)) == BACKGROUND
    world.set_pen(name, RED)
    world.put(name, 5, 8, 0)
    assert world.canvas.colour(Place(5, 8)) == RED[:3]
    world.set_pen(name, Pen(off=True))
    world.put(name, 8, 8, 0)
    assert world.canvas.colour(Place(7, 8)) == BACKGROUND
    assert world.turtles[name].pen == RED._replace(off=True)
    world.set_pen(name, Pen(0, 255, 0, 1))
    world.hop(name, 1.0, 0.0)
    assert world.canvas.colour(Place(8.9, 8)) == (0, 255, 0)
    assert world.canvas.colour(Place(5, 8)) == RED[:3]


def test_a_line_is_as_wide_as_its_pen() -> None:
    for width in (1, 3, 10, 255):
        canvas = Canvas((0, 0, 0))
        canvas.line(Place(1, SIZE / 2), Place(10, SIZE / 2), Pen(1, 2, 3, width))
        column = canvas.pixels()[3 * (PIXELS // 2) :: 3 * PIXELS]
        assert abs(sum(column) - width) <= 1, "one pixel for each pixel of the pen"


def test_lines_beyond_the_walls_and_at_them() -> None:
    canvas = Canvas((9, 9, 9))
    blank, version = canvas.pixels(), canvas.version
    canvas.line(Place(-3, -3), Place(-2, -9), RED)
    canvas.line(Place(1e9, 5), Place(2e9, 5), RED)
    assert (canvas.pixels(), canvas.version) == (blank, version)
    canvas.line(Place(-1e9, 5), Place(1e9, 5), RED)
    assert all(canvas.colour(Place(x, 5)) == RED[:3] for x in (0, 5, SIZE))
    for corner in (Place(0, 0), Place(SIZE, SIZE), Place(0, SIZE), Place(SIZE, 0)):
        canvas.line(corner, corner, RED)
        assert canvas.colour(corner) == RED[:3]
    canvas.clear((1, 2, 3))
    assert canvas.pixels() == bytes([1, 2, 3]) * PIXELS**2
