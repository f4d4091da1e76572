from __future__ import annotations

import itertools
from math import inf

import numpy as np
import pytest

from pyros1.robot_nodes.robot_localization import estimator as module
from pyros1.robot_nodes.robot_localization.ekf import Ekf, Measurement
from pyros1.robot_nodes.robot_localization.estimator import MAX_QUEUED, Estimator
from pyros1.robot_nodes.robot_localization.motion import SIZE
from pyros1.robot_nodes.robot_localization.settings import DEFAULT_NOISE

SECOND = 10**9


def make_estimator(history: float = 0.0, timeout: float = 1000.0, always_predict: bool = False) -> Estimator:
    ekf = Ekf(np.diag(DEFAULT_NOISE), 0.1 * np.eye(SIZE))
    times = {"history": round(history * SECOND), "sensor_timeout": round(timeout * SECOND)}
    return Estimator(ekf, always_predict=always_predict, **times)


def at(seconds: float, index: int, value: float, threshold: float = inf) -> Measurement:
    return Measurement(round(seconds * SECOND), np.array([index]), np.array([value]), 0.1 * np.eye(1), threshold)


def advance(estimator: Estimator, seconds: float) -> None:
    estimator.advance(round(seconds * SECOND))


def random_measurements(seed: int) -> list[Measurement]:
    random = np.random.default_rng(seed)
    times = np.cumsum(random.uniform(0.001, 0.05, 100))
    variables = random.choice([0, 1, 5, 6, 11], 100)
    return [at(*item) for item in zip(times, variables.tolist(), random.normal(0.0, 1.0, 100).tolist(), strict=True)]


@pytest.mark.parametrize("seed", range(5))
def test_with_a_history_the_order_of_arrival_does_not_matter(seed: int) -> None:
    measurements = random_measurements(seed)
    in_order = make_estimator()
    for measurement in measurements:
        in_order.add(measurement)
        in_order.advance(measurement.time)
    late = make_estimator(history=10.0)
    random = np.random.default_rng(seed)
    # the first one is on time, since nothing can be put before it
    arrivals = [0, *(1 + np.argsort(np.arange(99) + random.uniform(0, 30, 99)))]
    now = 0
    for number in arrivals:
        late.add(measurements[number])
        now = max(now, measurements[number].time)
        late.advance(now)
    assert late.time == in_order.time
    assert late.ekf.state == pytest.approx(in_order.ekf.state)
    assert late.ekf.covariance == pytest.approx(in_order.ekf.covariance)
    assert late.num_too_late == 0


def test_measurements_of_the_same_time_keep_their_order() -> None:
    estimator = make_estimator(history=10.0)
    # The last one is near enough only after the one before it.
    for measurement in (at(0.0, 0, 0.0), at(1.0, 0, 50.0), at(1.0, 0, 50.0, threshold=50.0)):
        estimator.add(measurement)
    advance(estimator, 1.0)
    estimator.add(at(0.5, 1, 0.0))
    advance(estimator, 1.0)
    assert (estimator.num_rejected, estimator.num_too_late) == (0, 0)


def test_without_a_history_a_late_measurement_corrects_the_present() -> None:
    estimator = make_estimator()
    for measurement in (at(0.0, 0, 0.0), at(1.0, 1, 2.0)):
        estimator.add(measurement)
    advance(estimator, 1.0)
    covariance = estimator.ekf.covariance[0, 0]
    estimator.add(at(0.5, 0, 3.0))
    advance(estimator, 1.0)
    assert estimator.time == SECOND
    assert estimator.ekf.state[0] == pytest.approx(3.0 * covariance / (covariance + 0.1))


def test_what_is_older_than_the_history_is_used_now_and_counted() -> None:
    estimator = make_estimator(history=0.5)
    for seconds in (0.0, 1.0, 2.0, 3.0):
        estimator.add(at(seconds, 0, 0.0))
        advance(estimator, seconds)
    estimator.add(at(0.2, 0, 5.0))
    advance(estimator, 3.0)
    assert (estimator.num_too_late, estimator.time) == (1, 3 * SECOND)
    assert estimator.ekf.state[0] > 0.0


def test_the_history_is_bounded_in_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_HISTORY", 10)
    estimator = make_estimator(history=1e6)
    for number in range(100):
        estimator.add(at(number, 0, 0.0))
    advance(estimator, 100)
    estimator.add(at(80.5, 0, 0.0))
    advance(estimator, 100)
    assert estimator.num_too_late == 1


def test_the_queue_is_bounded() -> None:
    estimator = make_estimator()
    for number in range(MAX_QUEUED + 5):
        estimator.add(at(number, 0, 0.0))
    assert estimator.num_dropped == 5


def test_measurements_of_the_future_wait() -> None:
    estimator = make_estimator()
    estimator.add(at(1.0, 0, 1.0))
    estimator.add(at(9.0, 0, 2.0))
    for seconds, expected in ((0.0, None), (2.0, SECOND), (8.0, SECOND), (9.0, 9 * SECOND)):
        advance(estimator, seconds)
        assert estimator.time == expected


@pytest.mark.parametrize(
    ("always", "now", "expected"), [(False, 1.4, 1.0), (False, 1.6, 1.6), (True, 1.1, 1.1), (True, 0.5, 1.0)]
)
def test_without_measurements_the_state_is_predicted(always: bool, now: float, expected: float) -> None:
    estimator = make_estimator(timeout=0.5, always_predict=always)
    estimator.ekf.state[6] = 2.0
    estimator.add(at(1.0, 0, 0.0))
    advance(estimator, 1.0)
    advance(estimator, now)
    assert estimator.time == round(expected * SECOND)
    assert estimator.ekf.state[0] == pytest.approx(2.0 * (expected - 1.0))


def test_the_state_stays_at_a_measurement_that_has_just_arrived_however_old() -> None:
    estimator = make_estimator(timeout=0.5)
    estimator.add(at(1.0, 0, 0.0))
    advance(estimator, 2.0)
    assert estimator.time == SECOND


def test_a_jump_of_the_clock_is_not_driven() -> None:
    estimator = make_estimator()
    estimator.ekf.state[6] = 1.0
    for measurement in (at(0.0, 1, 0.0), at(1e6, 1, 0.0)):
        estimator.add(measurement)
    advance(estimator, 1e6)
    assert estimator.ekf.state[0] == pytest.approx(0.01)


def test_rejected_measurements_are_counted() -> None:
    estimator = make_estimator()
    for number, value in enumerate((0.0, 50.0, 0.1)):
        estimator.add(at(number * 0.1, 0, value, threshold=3.0))
    advance(estimator, 1.0)
    assert estimator.num_rejected == 1
    assert abs(estimator.ekf.state[0]) < 0.2


def test_a_state_that_is_set_forgets_what_was_before() -> None:
    estimator = make_estimator(history=10.0)
    for measurement in itertools.islice(random_measurements(0), 20):
        estimator.add(measurement)
    advance(estimator, 0.1)
    state = np.arange(SIZE, dtype=float)
    estimator.set_state(state, np.eye(SIZE), 5 * SECOND)
    advance(estimator, 5.0)
    assert estimator.ekf.state.tolist() == state.tolist()
    estimator.add(at(4.0, 0, 0.0))
    advance(estimator, 5.0)
    assert (estimator.num_too_late, estimator.time) == (1, 5 * SECOND)


def test_what_arrives_while_the_filter_is_off_is_forgotten() -> None:
    estimator = make_estimator()
    estimator.add(at(0.0, 0, 1.0))
    advance(estimator, 0.0)
    estimator.add(at(1.0, 0, 9.0))
    estimator.skip_to(2 * SECOND)
    advance(estimator, 2.0)
    assert (estimator.time, estimator.ekf.state[0]) == (2 * SECOND, 1.0)
