"""The motion model, against numeric differentiation, small steps with matrices, and motions that are known."""

from __future__ import annotations

from math import cos, nan, pi, sin, tau

import numpy as np
import pytest

from pyros1.robot_nodes.robot_localization.motion import SIZE, Array, predict, rotation_matrix, wrap_angles
from pyros1.tf.transformations import euler_from_matrix, euler_matrix


def random_state(random: np.random.Generator) -> Array:
    state = random.normal(0.0, 2.0, SIZE)
    state[3:6] = random.uniform((-3.0, -1.4, -3.0), (3.0, 1.4, 3.0))
    return state


@pytest.mark.parametrize("seed", range(20))
def test_the_jacobian_is_that_of_numeric_differentiation(seed: int) -> None:
    random = np.random.default_rng(seed)
    state, seconds, step = random_state(random), random.uniform(0.001, 0.2), 1e-6
    _, jacobian = predict(state, seconds)
    for column in range(SIZE):
        change = np.zeros(SIZE)
        change[column] = step
        difference = predict(state + change, seconds)[0] - predict(state - change, seconds)[0]
        difference[3:6] = wrap_angles(difference[3:6])
        assert jacobian[:, column] == pytest.approx(difference / (2 * step), rel=1e-5, abs=1e-6), column


@pytest.mark.parametrize("seed", range(5))
def test_many_small_steps_are_a_rigid_motion(seed: int) -> None:
    """The reference turns a matrix by the angular velocity and moves along it; it knows no angles."""
    random = np.random.default_rng(seed)
    state = random_state(random)
    state[3:6] *= 0.3
    state[9:12] *= 0.2
    matrix, position, velocity = euler_matrix(*state[3:6])[:3, :3], state[:3].copy(), state[6:9].copy()
    wx, wy, wz = state[9:12]
    cross, step = np.array([[0, -wz, wy], [wz, 0, -wx], [-wy, wx, 0]]), 1e-4
    for _ in range(2000):
        state = predict(state, step)[0]
        position += matrix @ velocity * step
        velocity += state[12:] * step
        matrix = matrix @ (np.eye(3) + cross * step)
    assert state[:3] == pytest.approx(position, abs=2e-3)
    assert state[3:6] == pytest.approx(euler_from_matrix(matrix), abs=1e-3)
    assert state[6:9] == pytest.approx(velocity)


def test_a_circle_returns_to_its_start() -> None:
    state = np.zeros(SIZE)
    state[6], state[11] = 1.0, 0.5
    for _ in range(1000):
        state = predict(state, tau / 0.5 / 1000)[0]
    assert state[:3] == pytest.approx(0.0, abs=0.02)
    assert wrap_angles(state[5]) == pytest.approx(0.0, abs=1e-9)


def test_a_robot_that_looks_straight_up_keeps_finite_numbers() -> None:
    state = np.ones(SIZE)
    state[4] = pi / 2
    after, jacobian = predict(state, 0.01)
    assert np.isfinite(after).all()
    assert np.isfinite(jacobian).all()


@pytest.mark.parametrize("index", range(15))
@pytest.mark.parametrize("value", [1e308, -1e308, nan])
def test_numbers_that_are_too_large_are_no_error(index: int, value: float) -> None:
    state = np.zeros(15)
    state[index] = value
    for _ in range(3):  # whoever uses the estimate notices that it is not finite
        state, _ = predict(state, 1000.0)
    assert not (index >= 6 and np.isfinite(state).all())


def test_rotations_are_those_of_tf() -> None:
    angles = (0.3, -0.7, 2.1)
    assert rotation_matrix(*angles) == pytest.approx(euler_matrix(*angles)[:3, :3])


def test_angles_are_wrapped() -> None:
    for angle in np.linspace(-20.0, 20.0, 101):
        wrapped = wrap_angles(angle)
        assert -pi <= wrapped <= pi
        assert (cos(wrapped), sin(wrapped)) == pytest.approx((cos(angle), sin(angle)))
