"""The unscented filter: beside the textbook's formulas, a Kalman filter, the extended filter, and random samples."""

from __future__ import annotations

from math import inf, pi

import numpy as np
import pytest

from pyros1.robot_nodes.robot_localization.ekf import Ekf, Measurement
from pyros1.robot_nodes.robot_localization.motion import SIZE, Array, predict, wrap_angles
from pyros1.robot_nodes.robot_localization.settings import DEFAULT_NOISE
from pyros1.robot_nodes.robot_localization.ukf import Spread, Ukf, change

NOISE = np.diag(DEFAULT_NOISE)


def random_state(random: np.random.Generator) -> Array:
    state = random.normal(0.0, 2.0, SIZE)
    state[3:6] = random.uniform((-3.0, -1.3, -3.0), (3.0, 1.3, 3.0))
    return state


def random_covariance(random: np.random.Generator, size: float) -> Array:
    factor = random.normal(0.0, 1.0, (SIZE, SIZE))
    covariance: Array = size * (factor @ factor.T / SIZE + 0.1 * np.eye(SIZE))
    return covariance


def textbook(state: Array, covariance: Array, seconds: float, spread: Spread) -> tuple[Array, Array]:
    """The formulas of Wan and van der Merwe, one by one, for the motion model that `motion.predict` is."""
    n = SIZE
    lam = spread.alpha**2 * (n + spread.kappa) - n
    root = np.linalg.cholesky((n + lam) * covariance)
    points = [state, *(state + root[:, i] for i in range(n)), *(state - root[:, i] for i in range(n))]
    weights = np.full(2 * n + 1, 1 / (2 * (n + lam)))
    weights[0] = lam / (n + lam)
    moved = [predict(point, seconds)[0] for point in points]
    for point in moved[1:]:
        point[3:6] = moved[0][3:6] + wrap_angles(point[3:6] - moved[0][3:6])
    mean = sum((weight * point for weight, point in zip(weights, moved, strict=True)), np.zeros(n))
    weights[0] += 1 - spread.alpha**2 + spread.beta
    spreads = (w * np.outer(point - mean, point - mean) for w, point in zip(weights, moved, strict=True))
    return mean, sum(spreads, np.zeros((n, n)))


@pytest.mark.parametrize("seed", range(10))
def test_many_states_change_as_one_does(seed: int) -> None:
    random = np.random.default_rng(seed)
    states = np.stack([random_state(random) for _ in range(5)])
    states[0, 4] = pi / 2
    seconds = random.uniform(0.001, 0.2)
    for state, moved in zip(states, states + change(states, seconds), strict=True):
        moved[3:6] = wrap_angles(moved[3:6])
        assert moved == pytest.approx(predict(state, seconds)[0])


@pytest.mark.parametrize("spread", [Spread(0.5), Spread(1.0, 3.0, 0.0), Spread(0.1, -5.0, 2.0)])
@pytest.mark.parametrize("seed", range(4))
def test_it_predicts_as_the_textbook_does(seed: int, spread: Spread) -> None:
    random = np.random.default_rng(seed)
    state, covariance, seconds = random_state(random), random_covariance(random, 0.01), random.uniform(0.01, 0.2)
    ukf = Ukf(NOISE, covariance, state, spread=spread)
    ukf.predict(seconds)
    mean, expected = textbook(state, covariance, seconds, spread)
    mean[3:6] = wrap_angles(mean[3:6])
    assert ukf.state == pytest.approx(mean)
    assert ukf.covariance == pytest.approx(expected + seconds * NOISE)


@pytest.mark.parametrize("seed", range(4))
def test_where_it_is_certain_it_is_the_extended_filter(seed: int) -> None:
    random = np.random.default_rng(seed)
    state, covariance = random_state(random), random_covariance(random, 1e-8)
    ekf, ukf = (kind(np.zeros((SIZE, SIZE)), covariance, state) for kind in (Ekf, Ukf))
    for step in range(20):
        measurement = Measurement(0, np.array([step % SIZE]), state[[step % SIZE]], 1e-8 * np.eye(1))
        for each in (ekf, ukf):
            each.predict(0.02)
            each.correct(measurement)
    assert ukf.state == pytest.approx(ekf.state, abs=1e-4)
    assert ukf.covariance == pytest.approx(ekf.covariance, rel=1e-2, abs=1e-11)


@pytest.mark.parametrize("seed", range(3))
def test_in_the_linear_case_it_is_a_kalman_filter(seed: int) -> None:
    random = np.random.default_rng(seed)
    is_linear = np.diag(np.repeat((1.0, 0.0, 1.0, 0.0, 1.0), 3))  # angles and their rates are known to be 0
    ukf = Ukf(NOISE * is_linear, is_linear)
    variables = [0, 6, 12]
    x, p = np.zeros(3), np.eye(3)
    q = np.diag(np.array(DEFAULT_NOISE)[variables])
    for _ in range(30):
        dt = random.uniform(0.01, 0.1)
        ukf.predict(dt)
        f = np.array([[1, dt, dt * dt / 2], [0, 1, dt], [0, 0, 1]])
        x, p = f @ x, f @ p @ f.T + dt * q
        used = np.sort(random.choice(3, random.integers(1, 4), replace=False))
        h, z = np.eye(3)[used], random.normal(0, 5, len(used))
        r = np.diag(random.uniform(0.01, 1.0, len(used)))
        ukf.correct(Measurement(0, np.array(variables)[used], z, r))
        gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + r)
        x, p = x + gain @ (z - h @ x), (np.eye(3) - gain @ h) @ p
        assert ukf.state[variables] == pytest.approx(x)
        assert ukf.covariance[np.ix_(variables, variables)] == pytest.approx(p)


def test_it_knows_that_who_does_not_know_its_heading_gets_less_far() -> None:
    """A robot drives 10 m, its heading known to 0.5 rad: the mean of where it can be is 8.8 m away. The extended filter
    says 10 m, and that it is certain of it.
    """
    covariance, state = 1e-9 * np.eye(SIZE), np.zeros(SIZE)
    covariance[5, 5], state[6] = 0.25, 10.0
    ends = 10.0 * np.cos(np.random.default_rng(0).normal(0.0, 0.5, 100_000))
    ekf, ukf = (kind(np.zeros((SIZE, SIZE)), covariance, state) for kind in (Ekf, Ukf))
    for each in (ekf, ukf):
        each.predict(1.0)
    assert (ekf.state[0], ekf.covariance[0, 0]) == pytest.approx((10.0, 0.0), abs=1e-6)
    assert ukf.state[0] == pytest.approx(ends.mean(), abs=0.1)
    assert ukf.covariance[0, 0] == pytest.approx(ends.var(), rel=0.4)


def test_the_error_is_as_large_as_the_covariance_says() -> None:
    """NEES, as in the extended filter's test."""
    runs, dt, noise = 20, 0.05, 0.1 * NOISE
    nees: list[float] = []
    for seed in range(runs):
        random = np.random.default_rng(seed)
        truth = random.normal(0.0, 0.1, SIZE)
        truth[6], truth[11] = 1.0, 0.3
        ukf = Ukf(noise, 0.01 * np.eye(SIZE), truth + random.normal(0.0, 0.1, SIZE))
        for step in range(40):
            truth = predict(truth, dt)[0] + random.normal(0.0, np.sqrt(dt * np.diag(noise)))
            ukf.predict(dt)
            indices = np.array([6, 7, 8, 11] if step % 2 else [0, 1, 2, 3, 4, 5, 12, 13, 14])
            variances = np.linspace(0.01, 0.05, len(indices))
            values = truth[indices] + random.normal(0.0, np.sqrt(variances))
            ukf.correct(Measurement(0, indices, values, np.diag(variances)))
        error = ukf.state - truth
        error[3:6] = wrap_angles(error[3:6])
        nees.append(float(error @ np.linalg.inv(ukf.covariance) @ error))
    freedom = runs * SIZE
    assert abs(sum(nees) - freedom) < 3.3 * np.sqrt(2 * freedom), sum(nees) / runs


def test_angles_pass_half_a_turn_also_far_from_the_origin() -> None:
    state = np.zeros(SIZE)
    state[:2], state[5], state[11] = (5e5, 5e6), 3.13, 1.0
    ukf = Ukf(np.zeros((SIZE, SIZE)), 1e-4 * np.eye(SIZE), state)
    for _ in range(10):
        ukf.predict(0.01)
    assert ukf.state[5] == pytest.approx(3.23 - 2 * pi, abs=1e-3)
    assert ukf.state[:2] == pytest.approx((5e5, 5e6), abs=1e-3)
    assert ukf.covariance[5, 5] < 2e-4


def test_the_covariance_stays_symmetric_and_positive() -> None:
    random, ukf = np.random.default_rng(1), Ukf(NOISE, np.zeros((SIZE, SIZE)))
    for _ in range(300):
        ukf.predict(random.uniform(0.0, 0.2))
        indices = np.sort(random.choice(SIZE, random.integers(1, SIZE), replace=False))
        values, variance = random.normal(0.0, 0.1, len(indices)), 10.0 ** random.uniform(-9, 6)
        ukf.correct(Measurement(0, indices, values, variance * np.eye(len(indices))))
    assert ukf.covariance == pytest.approx(ukf.covariance.T)
    assert np.linalg.eigvalsh(ukf.covariance).min() > 0.0


@pytest.mark.parametrize("bad", [np.nan, inf])
def test_what_is_not_finite_stays_so_without_an_error(bad: float) -> None:
    covariance = np.eye(SIZE)
    covariance[2, 3] = covariance[3, 2] = bad
    ukf = Ukf(NOISE, covariance)
    with np.errstate(all="ignore"):
        ukf.predict(0.1)
    assert not np.isfinite(ukf.covariance).all()


def test_the_noise_of_the_pose_can_depend_on_the_speed() -> None:
    ukf = Ukf(NOISE, np.zeros((SIZE, SIZE)), dynamic_noise=True)
    ukf.predict(1.0)
    assert np.diag(ukf.covariance)[:6].tolist() == [0.0] * 6
