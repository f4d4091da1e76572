"""The extended Kalman filter of ekf_localization_node. Pure.

Predicts the state with the motion model, and corrects it with measurements of some of its variables. `motion` defines
the order of the variables.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

import numpy as np

from pyros1.robot_nodes.robot_localization.control import Control
from pyros1.robot_nodes.robot_localization.motion import (
    ANGLES,
    ANGULAR,
    LINEAR,
    SIZE,
    Array,
    predict,
    wrap_angles,
)

MIN_VARIANCE = 1e-9
"""Replaces smaller variances of measurements, since no measurement is exact."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """Measured values of some of the state's variables.

    Attributes:
        time: the time of the measurement in nanoseconds.
        indices: which of the 15 variables were measured (k,), ascending.
        values: their values (k,).
        covariance: the covariance of the values (k, k).
        threshold: the measurement is rejected at this Mahalanobis distance from the estimate, or beyond it.
        name: the sensor, such as ``imu0``.
    """

    time: int
    indices: np.ndarray[tuple[int], np.dtype[np.intp]]
    values: Array
    covariance: Array
    threshold: float = inf
    name: str = ""


class Ekf:
    """An extended Kalman filter: an estimate of the state, with its covariance.

    Args:
        process_noise: the growth of the covariance per second (15, 15).
        covariance: the initial covariance (15, 15).
        state: the initial state (15,); None for 0.
        dynamic_noise: whether the pose's noise is proportional to the square of the robot's speed.

    Attributes:
        state: the estimate (15,).
        covariance: its covariance (15, 15).
    """

    def __init__(
        self, process_noise: Array, covariance: Array, state: Array | None = None, dynamic_noise: bool = False
    ) -> None:
        self.state = np.zeros(SIZE) if state is None else state.copy()
        self.covariance = covariance.copy()
        self._noise = process_noise
        self._dynamic_noise = dynamic_noise

    def start(self, measurement: Measurement) -> None:
        """Initialize the variables that the first measurement contains."""
        self.state[measurement.indices] = measurement.values
        self.covariance[measurement.indices[:, None], measurement.indices] = measurement.covariance

    def predict(self, seconds: float, control: Control | None = None, time: int = 0) -> None:
        """Predict the state after ``seconds``, and make it the estimate.

        Args:
            seconds: the duration of the prediction.
            control: the robot's commands, or None.
            time: the time of the predicted state in nanoseconds, to ignore commands that are too old.
        """
        state = self.state if control is None else control.apply(self.state, seconds, time)
        self.state, jacobian = predict(state, seconds)
        self.covariance = jacobian @ self.covariance @ jacobian.T + seconds * self.noise_of(state)

    def noise_of(self, state: Array) -> Array:
        """Return the process noise per second (15, 15) for a state (15,)."""
        if not self._dynamic_noise:
            return self._noise
        noise: Array = self._noise.copy()
        noise[:6, :6] *= state[LINEAR] @ state[LINEAR] + state[ANGULAR] @ state[ANGULAR]
        return noise

    def correct(self, measurement: Measurement) -> bool:
        """Correct the estimate, unless the measurement's threshold rejects it. Return whether it was accepted."""
        indices = measurement.indices
        innovation = measurement.values - self.state.take(indices)
        if max(map(abs, innovation.tolist())) > pi:
            is_angle = (indices >= ANGLES.start) & (indices < ANGLES.stop)
            innovation[is_angle] = wrap_angles(innovation[is_angle])
        covariance = self.covariance
        columns = covariance.take(indices, axis=1)
        try:
            inverse = np.linalg.inv(columns.take(indices, axis=0) + measurement.covariance)
        except np.linalg.LinAlgError:
            return False
        if measurement.threshold < inf and innovation @ inverse @ innovation >= measurement.threshold**2:
            return False
        gain = columns @ inverse
        self.state += gain @ innovation
        if max(map(abs, self.state[ANGLES].tolist())) > pi:
            self.state[ANGLES] = wrap_angles(self.state[ANGLES])
        # The Joseph form keeps the matrix symmetric and positive despite rounding: with H, which selects the
        # measured variables, it is (1 - gain H) covariance (1 - gain H)^T + gain R gain^T.
        left = covariance - gain @ covariance.take(indices, axis=0)
        self.covariance = left - (left.take(indices, axis=1) - gain @ measurement.covariance) @ gain.T
        return True
