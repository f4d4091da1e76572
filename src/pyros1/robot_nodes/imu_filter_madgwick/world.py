"""World frames, and the orientation in them computed from an acceleration and a magnetic field alone."""

from __future__ import annotations

from enum import Enum
from math import atan2, hypot

from pyros1.robot_nodes.shared.imu_readings import UnusableReadingError
from pyros1.robot_nodes.shared.quaternions import from_rows
from pyros1.tf.rotation import Quaternion, Vector, from_angles

_MIN_ACCELERATION = 0.1  # as in stock ROS
_MIN_SINE = 1e-3
"""Minimum sine of the angle between up and the magnetic field at which the field still shows where north is."""


class WorldFrame(Enum):
    """The directions of the world frame's axes x, y and z: east, north, up; north, east, down; or north, west, up."""

    ENU = "enu"
    NED = "ned"
    NWU = "nwu"

    @property
    def up(self) -> Vector:
        """The direction of the acceleration that an IMU measures at rest."""
        return (0.0, 0.0, -1.0) if self is WorldFrame.NED else (0.0, 0.0, 1.0)

    def to_north(self, field: Vector) -> Vector:
        """Rotate a magnetic field in this frame about the vertical axis so that it points north."""
        horizontal = hypot(field[0], field[1])
        return (0.0, horizontal, field[2]) if self is WorldFrame.ENU else (horizontal, 0.0, field[2])


def measured_orientation(world: WorldFrame, acceleration: Vector, field: Vector | None) -> Quaternion:
    """Return the orientation of an IMU at rest.

    Args:
        world: the world frame.
        acceleration: in m/s², in the IMU's frame.
        field: the magnetic field in any unit, in the IMU's frame; without it the yaw is 0.

    Raises:
        UnusableReadingError: the IMU is in free fall, or the magnetic field is vertical.
    """
    length = hypot(*acceleration)
    if length < _MIN_ACCELERATION:
        raise UnusableReadingError("it shows no gravity: the IMU seems to be in free fall, or to have no accelerometer")
    ux, uy, uz = (component / length for component in acceleration)
    if field is None:
        sign = world.up[2]
        return from_angles(atan2(sign * uy, sign * uz), atan2(-sign * ux, hypot(uy, uz)), 0.0)
    mx, my, mz = field
    east = my * uz - mz * uy, mz * ux - mx * uz, mx * uy - my * ux
    strength = hypot(*east)
    if not strength > _MIN_SINE * hypot(*field):
        raise UnusableReadingError("the magnetic field is zero or vertical, so it does not show where north is")
    ex, ey, ez = (component / strength for component in east)
    up, north = (ux, uy, uz), (uy * ez - uz * ey, uz * ex - ux * ez, ux * ey - uy * ex)
    if world is WorldFrame.ENU:
        return from_rows((ex, ey, ez), north, up)
    if world is WorldFrame.NWU:
        return from_rows(north, (-ex, -ey, -ez), up)
    return from_rows(north, (ex, ey, ez), (-ux, -uy, -uz))
