"""The filter: beside a plain Kalman filter where the model is linear, and its consistency with a simulated truth."""

from __future__ import annotations

from math import inf, pi

import numpy as np
import pytest

from pyros1.robot_nodes.robot_localization.ekf import Ekf, Measurement
from pyros1.robot_nodes.robot_localization.motion import SIZE, Array, predict, wrap_angles
from pyros1.robot_nodes.robot_localization.settings import DEFAULT_NOISE


def measure(indices: list[int], values: object, variances: object, threshold: float = inf) -> Measurement:
    variances = np.broadcast_to(np.asarray(variances, float), len(indices))
    return Measurement(0, np.array(indices), np.array(values, float), np.diag(variances), threshold)


def make_ekf(variance: float = 1.0) -> Ekf:
    return Ekf(np.diag(DEFAULT_NOISE), variance * np.eye(SIZE))


@pytest.mark.parametrize("seed", range(5))
def test_in_the_linear_case_it_is_a_kalman_filter(seed: int) -> None:
    """Without rotation, each axis is a linear system of position, velocity and acceleration."""
    random = np.random.default_rng(seed)
    ekf = make_ekf()
    variables = [0, 6, 12]
    x, p = np.zeros(3), np.eye(3)
    q = np.diag(np.array(DEFAULT_NOISE)[variables])
    for _ in range(50):
        dt = random.uniform(0.01, 0.1)
        ekf.predict(dt)
        f = np.array([[1, dt, dt * dt / 2], [0, 1, dt], [0, 0, 1]])
        x, p = f @ x, f @ p @ f.T + dt * q
        used = random.choice(3, random.integers(1, 4), replace=False)
        h, z = np.eye(3)[np.sort(used)], random.normal(0, 5, len(used))
        r = np.diag(random.uniform(0.01, 1.0, len(used)))
        ekf.correct(Measurement(0, np.array(variables)[np.sort(used)], z, r))
        gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + r)
        x, p = x + gain @ (z - h @ x), (np.eye(3) - gain @ h) @ p
        assert ekf.state[variables] == pytest.approx(x)
        assert ekf.covariance[np.ix_(variables, variables)] == pytest.approx(p)


@pytest.mark.slow
def test_the_error_is_as_large_as_the_covariance_says() -> None:
    """NEES: the squared error, in units of the covariance, is 15 on average; the bounds are those of 99.9 %."""
    runs, steps, dt = 30, 60, 0.05
    noise = np.diag(DEFAULT_NOISE) * 0.1
    nees: list[float] = []
    for seed in range(runs):
        random = np.random.default_rng(seed)
        truth = random.normal(0.0, 0.1, SIZE)
        truth[6], truth[11] = 1.0, 0.3
        initial = 0.01 * np.eye(SIZE)
        ekf = Ekf(noise, initial, truth + random.normal(0.0, 0.1, SIZE))
        for step in range(steps):
            truth = predict(truth, dt)[0] + random.normal(0.0, np.sqrt(dt * np.diag(noise)))
            ekf.predict(dt)
            indices = [6, 7, 8, 11] if step % 2 else [0, 1, 2, 3, 4, 5, 12, 13, 14]
            variances = np.linspace(0.01, 0.05, len(indices))
            values = truth[indices] + random.normal(0.0, np.sqrt(variances))
            ekf.correct(measure(indices, values, variances))
        error = ekf.state - truth
        error[3:6] = wrap_angles(error[3:6])
        nees.append(float(error @ np.linalg.inv(ekf.covariance) @ error))
    # the sum is distributed as chi-squared with runs * 15 degrees of freedom, about normal
    freedom = runs * SIZE
    assert abs(sum(nees) - freedom) < 3.3 * np.sqrt(2 * freedom), sum(nees) / runs


def test_the_covariance_stays_symmetric_and_positive() -> None:
    random, ekf = np.random.default_rng(1), make_ekf(1e-9)
    for _ in range(500):
        ekf.predict(random.uniform(0.0, 0.2))
        indices = np.sort(random.choice(SIZE, random.integers(1, SIZE), replace=False))
        ekf.correct(measure(indices.tolist(), random.normal(0.0, 0.1, len(indices)), 10.0 ** random.uniform(-9, 6)))
    assert ekf.covariance == pytest.approx(ekf.covariance.T)
    assert np.linalg.eigvalsh(ekf.covariance).min() > 0.0


def test_angles_are_corrected_the_short_way() -> None:
    ekf = make_ekf()
    ekf.state[5] = 3.1
    ekf.correct(measure([5], [-3.1], 1.0))
    assert abs(ekf.state[5]) == pytest.approx(pi)


@pytest.mark.parametrize(("value", "accepted"), [(2.9, True), (3.1, False), (-3.1, False)])
def test_measurements_beyond_the_threshold_are_rejected(value: float, accepted: bool) -> None:
    """With variances of 1 and 3, a difference of 6 is 3 standard deviations."""
    ekf = make_ekf()
    assert ekf.correct(measure([0], [2 * value], 3.0, threshold=3.0)) is accepted
    assert bool(ekf.state[0]) is accepted


def test_the_first_measurement_sets_what_it_has() -> None:
    ekf = make_ekf()
    ekf.start(measure([0, 5], [7.0, 1.0], [0.2, 0.3]))
    assert ekf.state.tolist() == [7.0, 0, 0, 0, 0, 1.0, *[0.0] * 9]
    assert np.diag(ekf.covariance)[:6].tolist() == [0.2, 1, 1, 1, 1, 0.3]


def test_the_noise_of_the_pose_can_depend_on_the_speed() -> None:
    def grown(speed: float) -> Array:
        ekf = Ekf(np.diag(DEFAULT_NOISE), np.zeros((SIZE, SIZE)), dynamic_noise=True)
        ekf.state[7] = speed
        ekf.predict(1.0)
        return np.diag(ekf.covariance)

    assert grown(0.0)[:6].tolist() == [0.0] * 6
    assert grown(2.0)[:6] == pytest.approx(4.0 * np.array(DEFAULT_NOISE[:6]))
    assert grown(2.0)[6:] == pytest.approx(DEFAULT_NOISE[6:])
