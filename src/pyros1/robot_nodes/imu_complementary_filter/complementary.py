"""A complementary filter: uses the gyroscope for fast motion, and gravity and the magnetic field for slow motion.

From R. Valenti, I. Dryanovski, J. Xiao, "Keeping a good attitude: a quaternion-based orientation filter for IMUs and
MARGs", Sensors 15(8), 2015. In the world frame, z points up, and x to magnetic north if the magnetic field is used.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot

from pyros1.robot_nodes.shared.imu_readings import Estimate, OrientationFilter, Reading, UnusableReadingError
from pyros1.robot_nodes.shared.quaternions import from_rotation_vector, normalized, product, rotate
from pyros1.tf.rotation import Quaternion, Vector

GRAVITY = 9.81
_IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)

# The IMU is at rest if it is within these limits.
_MAX_REST_ACCELERATION = 0.1
_MAX_REST_RATE = 0.2
_MAX_REST_CHANGE_OF_RATE = 0.01

# Deviation from gravity, as a fraction of it, up to which acceleration counts fully, and from which it does not count.
_FULL_GAIN_UP_TO, _NO_GAIN_FROM = 0.1, 0.2


@dataclass(frozen=True)
class Settings:
    """The parameters of the filter.

    Attributes:
        gain_acc, gain_mag: the fraction of the error, relative to gravity and to the magnetic field, that each reading
            corrects, from 0.0 to 1.0.
        do_bias_estimation: whether to estimate the gyroscope's bias while the IMU is at rest.
        bias_alpha: the fraction of the bias's error that each reading corrects, from 0.0 to 1.0.
        do_adaptive_gain: whether to trust the accelerometer less while the IMU accelerates.
    """

    gain_acc: float = 0.01
    gain_mag: float = 0.01
    do_bias_estimation: bool = True
    bias_alpha: float = 0.01
    do_adaptive_gain: bool = True


class ComplementaryFilter(OrientationFilter[Settings]):
    """Estimates the orientation of an IMU.

    Args:
        settings: the parameters.
    """

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self._last_rates: Vector | None = None

    def reset(self) -> None:
        """Start again with the next reading. The gyroscope's bias is kept."""
        super().reset()
        self._last_rates = None

    def update(self, reading: Reading, seconds: float) -> Estimate | None:
        """See `OrientationFilter.update`. As in stock ROS, the first reading gives no orientation."""
        last_rates, self._last_rates = self._last_rates, reading.rates
        if last_rates is None:
            return None
        steady = self._settings.do_bias_estimation and self._update_bias(reading, last_rates)
        rates = reading.rates
        if self._settings.do_bias_estimation:
            rates = rates[0] - self._bias[0], rates[1] - self._bias[1], rates[2] - self._bias[2]
        if self._orientation is None:
            if not any(reading.acceleration):
                raise UnusableReadingError("it shows no gravity: the IMU seems to have no accelerometer")
            self._orientation = self._corrected(_IDENTITY, reading, 1.0, 1.0)
        else:
            turn = from_rotation_vector(rates[0] * seconds, rates[1] * seconds, rates[2] * seconds)
            gain = self._settings.gain_acc * self._trust(reading.acceleration)
            turned = product(self._orientation, turn)
            self._orientation = self._corrected(turned, reading, gain, self._settings.gain_mag)
        return Estimate(self._orientation, rates, reading.acceleration, steady)

    def _update_bias(self, reading: Reading, last_rates: Vector) -> bool:
        """Update the gyroscope's bias if the IMU is at rest, and return whether it is."""
        differences = [rate - bias for rate, bias in zip(reading.rates, self._bias, strict=True)]
        changes = [rate - before for rate, before in zip(reading.rates, last_rates, strict=True)]
        steady = (
            abs(hypot(*reading.acceleration) - GRAVITY) <= _MAX_REST_ACCELERATION
            and max(map(abs, differences)) <= _MAX_REST_RATE
            and max(map(abs, changes)) <= _MAX_REST_CHANGE_OF_RATE
        )
        if steady:
            alpha, (x, y, z) = self._settings.bias_alpha, self._bias
            self._bias = x + alpha * differences[0], y + alpha * differences[1], z + alpha * differences[2]
        return steady

    def _trust(self, acceleration: Vector) -> float:
        """Return the weight of an acceleration, from 0.0 to 1.0; the more it differs from gravity, the lower."""
        if not self._settings.do_adaptive_gain:
            return 1.0
        error = abs(hypot(*acceleration) - GRAVITY) / GRAVITY
        return min(1.0, max(0.0, (_NO_GAIN_FROM - error) / (_NO_GAIN_FROM - _FULL_GAIN_UP_TO)))

    def _corrected(self, orientation: Quaternion, reading: Reading, gain_acc: float, gain_mag: float) -> Quaternion:
        """Return an orientation rotated towards one in which gravity is along z, and then the magnetic field along x.

        Each gain is the fraction of the corresponding rotation that is applied, from 0.0 to 1.0.
        """
        if any(reading.acceleration):
            x, y, z = rotate(orientation, reading.acceleration)
            horizontal = hypot(x, y)
            angle = atan2(horizontal, z) * gain_acc
            axis = (y / horizontal, -x / horizontal) if horizontal > 0.0 else (1.0, 0.0)
            orientation = product(from_rotation_vector(axis[0] * angle, axis[1] * angle, 0.0), orientation)
        if reading.field is not None:
            x, y, _ = rotate(orientation, reading.field)
            orientation = product(from_rotation_vector(0.0, 0.0, -atan2(y, x) * gain_mag), orientation)
        return normalized(orientation)
