from __future__ import annotations

from math import isclose

from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.teleop_twist_keyboard.driver import Driver, Velocity

# Rows of keys as they lie on the keyboard: forwards, on the spot, backwards; to the left, straight on, to the right.
ROWS = ("uio", "jkl", "m,.")
SHIFTED_ROWS = ("UIO", "JKL", "M<>")


def test_the_keys_around_k() -> None:
    for forwards, row in zip((1, 0, -1), ROWS, strict=True):
        for left, key in zip((1, 0, -1), row, strict=True):
            driver = Driver(2.0, 3.0)
            assert driver.press(key) == []
            # Backwards, the wheel is turned the other way, as in a car.
            turning = -left if forwards < 0 else left
            assert driver.velocity == Velocity(2.0 * forwards, 0.0, 0.0, 3.0 * turning), key


def test_with_shift_the_robot_moves_sideways() -> None:
    for forwards, row in zip((1, 0, -1), SHIFTED_ROWS, strict=True):
        for left, key in zip((1, 0, -1), row, strict=True):
            driver = Driver(2.0, 3.0)
            driver.press(key)
            assert driver.velocity == Velocity(2.0 * forwards, 2.0 * left), key


def test_up_and_down_and_stop() -> None:
    driver = Driver(2.0, 3.0)
    driver.press("t")
    assert driver.velocity == Velocity(z=2.0)
    driver.press("b")
    assert driver.velocity == Velocity(z=-2.0)
    driver.press("i")
    driver.press("?")
    assert driver.velocity == Velocity()


@given(st.lists(st.sampled_from("qzwxeci"), max_size=60))
def test_speeds(keys: list[str]) -> None:
    driver = Driver(0.5, 1.0, 0.7, 1.5)
    speed, turn = 0.5, 1.0
    for key in keys:
        lines = driver.press(key)
        speed = min(0.7, speed * (1.1 if key in "qw" else 0.9 if key in "zx" else 1.0))
        turn = min(1.5, turn * (1.1 if key in "qe" else 0.9 if key in "zc" else 1.0))
        assert isclose(driver.speed, speed) and isclose(driver.turn, turn)
        assert ("Linear speed limit reached!" in lines) == (driver.speed == 0.7 and key != "i")
        assert ("Angular speed limit reached!" in lines) == (driver.turn == 1.5 and key != "i")
        assert any("currently:" in line for line in lines) == (key != "i")
    assert driver.velocity.x == (driver.speed if "i" in keys else 0.0)  # changes of speed leave the direction
