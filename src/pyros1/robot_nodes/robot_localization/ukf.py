"""The unscented Kalman filter of ukf_localization_node. Pure.

It applies the motion model to sigma points around the estimate, whereas the extended filter uses the model's
derivatives. Since measurements are variables of the state, they correct the estimate as in the extended filter.

See Wan and van der Merwe, The unscented Kalman filter for nonlinear estimation, 2000.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pyros1.robot_nodes.robot_localization.control import Control
from pyros1.robot_nodes.robot_localization.ekf import Ekf
from pyros1.robot_nodes.robot_localization.motion import (
    ACCELERATION,
    ANGLES,
    ANGULAR,
    LINEAR,
    MIN_COSINE,
    POSITION,
    SIZE,
    Array,
    wrap_angles,
)


@dataclass(frozen=True)
class Spread:
    """The parameters of the sigma points' spread around the estimate.

    Attributes:
        alpha: affects how far they are from the estimate; more than 0.
        kappa: also affects how far they are from it; more than -15.
        beta: 2 if errors are normally distributed.
    """

    alpha: float = 0.001
    kappa: float = 0.0
    beta: float = 2.0


class Ukf(Ekf):
    """An unscented Kalman filter: an estimate of the state, with its covariance.

    Args:
        process_noise, covariance, state, dynamic_noise: see `Ekf`.
        spread: the spread of the sigma points.
    """

    def __init__(
        self,
        process_noise: Array,
        covariance: Array,
        state: Array | None = None,
        dynamic_noise: bool = False,
        spread: Spread | None = None,
    ) -> None:
        super().__init__(process_noise, covariance, state, dynamic_noise)
        spread = spread or Spread()
        self._scale = spread.alpha**2 * (SIZE + spread.kappa)
        self._bend = spread.beta - spread.alpha**2

    def predict(self, seconds: float, control: Control | None = None, time: int = 0) -> None:
        """Predict the state after ``seconds``, and make it the estimate; see `Ekf.predict` for the arguments."""
        state = self.state if control is None else control.apply(self.state, seconds, time)
        offsets = np.sqrt(self._scale) * _square_root(self.covariance).T
        offsets = np.concatenate((offsets, -offsets))
        own = change(state[None], seconds)
        # The textbook's weights are up to a million, but their sum is 1. Using differences from the change of the
        # estimate itself avoids cancelling numbers of that size.
        differences = change(state + offsets, seconds) - own
        mean = differences.sum(axis=0) / (2.0 * self._scale)
        deviations = offsets + differences
        self.state = state + own[0] + mean
        self.state[ANGLES] = wrap_angles(self.state[ANGLES])
        spread = deviations.T @ deviations / (2.0 * self._scale) + self._bend * np.outer(mean, mean)
        self.covariance = spread + seconds * self.noise_of(state)


def change(states: Array, seconds: float) -> Array:
    """Return the changes (n, 15) of states (n, 15) after ``seconds``: the motion model for many states at once.

    Angles are not wrapped.
    """
    roll, pitch, yaw = states[:, ANGLES].T
    wx, wy, wz = states[:, ANGULAR].T
    sr, cr, sp, cp, sy, cy = np.sin(roll), np.cos(roll), np.sin(pitch), np.cos(pitch), np.sin(yaw), np.cos(yaw)
    x, y, z = (seconds * states[:, LINEAR] + 0.5 * seconds * seconds * states[:, ACCELERATION]).T
    y, z = cr * y - sr * z, sr * y + cr * z
    x, z = cp * x + sp * z, cp * z - sp * x
    steep = np.copysign(np.maximum(np.abs(cp), MIN_COSINE), cp)
    across = sr * wy + cr * wz
    changes = np.zeros_like(states)
    changes[:, POSITION] = np.stack((cy * x - sy * y, sy * x + cy * y, z), axis=1)
    rates = np.stack((wx + across * sp / steep, cr * wy - sr * wz, across / steep), axis=1)
    changes[:, ANGLES] = seconds * rates
    changes[:, LINEAR] = seconds * states[:, ACCELERATION]
    return changes


def _square_root(covariance: Array) -> Array:
    """Return a matrix that, multiplied by its transpose, is a covariance (15, 15)."""
    root: Array
    try:
        root = np.asarray(np.linalg.cholesky(covariance))
    except np.linalg.LinAlgError:  # variances are 0, or negative because of rounding
        try:
            values, vectors = np.linalg.eigh(covariance)
            root = vectors * np.sqrt(np.maximum(values, 0.0))
        except np.linalg.LinAlgError:  # not finite, so the estimate is not either: callers check this
            root = np.full_like(covariance, np.nan)
    return root
