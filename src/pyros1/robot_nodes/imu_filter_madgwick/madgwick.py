"""Madgwick's filter: integrates the gyroscope, and corrects the other sensors' error by gradient descent.

Based on S. Madgwick, "An efficient orientation filter for inertial and inertial/magnetic sensor arrays", 2010.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, hypot, sin

from pyros1.robot_nodes.imu_filter_madgwick.world import WorldFrame, measured_orientation
from pyros1.robot_nodes.shared.imu_readings import Estimate, OrientationFilter, Reading, UnusableReadingError
from pyros1.robot_nodes.shared.quaternions import conjugate, from_rotation_vector, normalized, product, rotate
from pyros1.tf.rotation import Quaternion, Vector

GRAVITY = 9.80665
_MAX_GYRO_BIAS = 10.0


@dataclass(frozen=True)
class Settings:
    """The parameters of the filter.

    Attributes:
        world: the world frame.
        use_mag: whether the filter needs the magnetic field to start.
        gain: how fast the orientation follows the accelerometer and the magnetic field.
        zeta: how fast the gyroscope's bias is corrected, roughly in rad/s². Needs the magnetic field.
        mag_bias: the vector to subtract from the magnetic field.
        yaw_offset: the angle to add to the yaw, in radians.
        stateless: whether to compute the orientation from each reading alone.
        remove_gravity: whether to subtract gravity from the acceleration.
    """

    world: WorldFrame = WorldFrame.ENU
    use_mag: bool = False
    gain: float = 0.1
    zeta: float = 0.0
    mag_bias: Vector = (0.0, 0.0, 0.0)
    yaw_offset: float = 0.0
    stateless: bool = False
    remove_gravity: bool = False


class MadgwickFilter(OrientationFilter[Settings]):
    """Estimates the orientation of an IMU.

    Args:
        settings: the parameters.
    """

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self._offset: Quaternion = (0.0, 0.0, sin(settings.yaw_offset / 2), cos(settings.yaw_offset / 2))

    def configure(self, gain: float, zeta: float, mag_bias: Vector) -> None:
        """Change the parameters that can be changed while the filter is running."""
        self._settings = replace(self._settings, gain=gain, zeta=zeta, mag_bias=mag_bias)

    def measure(self, reading: Reading) -> Quaternion:
        """Return the orientation from a single reading, without the yaw offset.

        Raises:
            UnusableReadingError: the orientation cannot be computed from this reading.
        """
        if reading.field is None and self._settings.use_mag:
            raise UnusableReadingError("the magnetic field is not finite")
        return measured_orientation(self._settings.world, reading.acceleration, self._unbiased(reading.field))

    def update(self, reading: Reading, seconds: float) -> Estimate:
        """Return the orientation after a reading; see `OrientationFilter.update`."""
        settings = self._settings
        orientation = self._orientation
        if orientation is None or settings.stateless:
            orientation = self.measure(reading)
        if not settings.stateless:
            orientation = self._step(orientation, reading, seconds)
        self._orientation = orientation
        acceleration = reading.acceleration
        if settings.remove_gravity:
            gx, gy, gz = rotate(conjugate(orientation), settings.world.up)
            ax, ay, az = acceleration
            acceleration = ax - GRAVITY * gx, ay - GRAVITY * gy, az - GRAVITY * gz
        if settings.yaw_offset:
            orientation = product(self._offset, orientation)
        return Estimate(orientation, reading.rates, acceleration)

    def _unbiased(self, field: Vector | None) -> Vector | None:
        if field is None:
            return None
        bx, by, bz = self._settings.mag_bias
        return field[0] - bx, field[1] - by, field[2] - bz

    def _step(self, orientation: Quaternion, reading: Reading, seconds: float) -> Quaternion:
        settings = self._settings
        field = _unit(self._unbiased(reading.field))
        up = _unit(reading.acceleration)
        rx, ry, rz = reading.rates
        descent, size = None, 0.0
        if up is not None:
            slope = gradient(orientation, settings.world.up, up)
            if field is not None:
                north = settings.world.to_north(rotate(orientation, field))
                slope = _sum(slope, gradient(orientation, north, field))
            size = hypot(*slope)
            if size > 0.0:
                descent = slope[0] / size, slope[1] / size, slope[2] / size, slope[3] / size
                if field is not None and settings.zeta:
                    self._bias = self._next_bias(orientation, descent, settings.zeta * seconds)
        if field is not None:
            rx, ry, rz = rx - self._bias[0], ry - self._bias[1], rz - self._bias[2]
        turned = product(orientation, from_rotation_vector(rx * seconds, ry * seconds, rz * seconds))
        if descent is not None:
            # A step of a quarter of the gradient aligns gravity; a longer one would amplify rounding errors.
            # After a step of 1, the length might be 0, which cannot be normalized.
            factor = -min(settings.gain * seconds, size / 4.0, 0.5)
            turned = _sum(turned, (descent[0] * factor, descent[1] * factor, descent[2] * factor, descent[3] * factor))
        return normalized(turned)

    def _next_bias(self, orientation: Quaternion, descent: Quaternion, factor: float) -> Vector:
        errors = product(conjugate(orientation), descent)
        x, y, z = (
            max(-_MAX_GYRO_BIAS, min(_MAX_GYRO_BIAS, bias + 2.0 * factor * error))
            for bias, error in zip(self._bias, errors[:3], strict=True)
        )
        return x, y, z


def gradient(orientation: Quaternion, reference: Vector, measured: Vector) -> Quaternion:
    """Return the gradient of half the squared distance between a reference direction and its measurement.

    Args:
        orientation: the IMU's orientation in the world frame.
        reference: a direction in the world frame.
        measured: the same direction as measured in the IMU's frame.

    Returns:
        The derivatives with respect to the four components of the orientation.
    """
    x, y, z, w = orientation
    a, b, c = 2.0 * reference[0], 2.0 * reference[1], 2.0 * reference[2]
    along_x = a * (0.5 - y * y - z * z) + b * (x * y + w * z) + c * (x * z - w * y) - measured[0]
    along_y = a * (x * y - w * z) + b * (0.5 - x * x - z * z) + c * (y * z + w * x) - measured[1]
    along_z = a * (x * z + w * y) + b * (y * z - w * x) + c * (0.5 - x * x - y * y) - measured[2]
    return (
        (b * y + c * z) * along_x + (a * y - 2 * b * x + c * w) * along_y + (a * z - b * w - 2 * c * x) * along_z,
        (b * x - 2 * a * y - c * w) * along_x + (a * x + c * z) * along_y + (a * w + b * z - 2 * c * y) * along_z,
        (b * w - 2 * a * z + c * x) * along_x + (c * y - a * w - 2 * b * z) * along_y + (a * x + b * y) * along_z,
        (b * z - c * y) * along_x + (c * x - a * z) * along_y + (a * y - b * x) * along_z,
    )


def _sum(first: Quaternion, second: Quaternion) -> Quaternion:
    return first[0] + second[0], first[1] + second[1], first[2] + second[2], first[3] + second[3]


def _unit(vector: Vector | None) -> Vector | None:
    if vector is None:
        return None
    length = hypot(*vector)
    return (vector[0] / length, vector[1] / length, vector[2] / length) if length > 0.0 else None
