"""Converts positions on Earth to the robot's world frame, and back. Does no I/O.

The transform between a grid (UTM or a plane) and the world frame is computed from the first fix and the robot's pose
and heading at that time, or from a datum, which is the position of the world frame's origin on Earth.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.sensor_msgs.msg import NavSatFix
from pyros1.robot_nodes.robot_localization.inputs import pose_tuple
from pyros1.robot_nodes.robot_localization.local_plane import LocalPlane
from pyros1.robot_nodes.robot_localization.motion import Array
from pyros1.robot_nodes.robot_localization.sensors import FindFrame, Mount, matrix
from pyros1.robot_nodes.robot_localization.utm import Grid, UtmError, check_degrees, check_metres
from pyros1.tf.rotation import IDENTITY, Quaternion, Transform, from_angles, invert, multiply, to_angles

_NO_FIX, _GBAS_FIX, _KNOWN = -1, 2, 3  # constants of NavSatStatus and NavSatFix


@dataclass(frozen=True)
class Heading:
    """Corrections, in radians, to add to the heading that an IMU reports.

    Attributes:
        declination: the magnetic declination, if the IMU's heading is from magnetic north.
        yaw_offset: the negative of what the IMU reports when it faces east.
    """

    declination: float = 0.0
    yaw_offset: float = 0.0


@dataclass(frozen=True)
class Georeference:
    """The transform between a grid and the robot's world frame.

    Attributes:
        grid: the UTM zone, or the plane.
        pose: the origin of the grid, in the world frame.
        flat: whether altitudes in the world frame are 0.
    """

    grid: Grid | LocalPlane
    pose: Transform
    flat: bool

    def to_world(self, latitude: float, longitude: float, altitude: float) -> tuple[float, float, float]:
        """Return the position in the world frame, in metres, of a place given in degrees, with its altitude in metres.

        Raises:
            UtmError: see `Grid.forward`.
        """
        check_metres(altitude)
        x, y, z, *_ = multiply(self.pose, (*self.grid.forward(latitude, longitude), altitude, *IDENTITY[3:]))
        return x, y, 0.0 if self.flat else z

    def to_earth(self, x: float, y: float, z: float) -> tuple[float, float, float]:
        """Return latitude and longitude in degrees, and the altitude in metres, of a position in the world frame.

        Raises:
            UtmError: the position is too far away.
        """
        easting, northing, altitude, *_ = multiply(invert(self.pose), (x, y, z, *IDENTITY[3:]))
        check_metres(easting, northing, altitude)
        return (*self.grid.inverse(easting, northing), altitude)


class Navsat:
    """Converts between fixes and the robot's world frame.

    Args:
        heading: corrections of the heading.
        flat: whether altitudes in the world frame are 0.
        uses_odometry_yaw: whether to use the odometry's heading, not an IMU's.
        uses_plane: whether the grid is a plane that touches the Earth at the first fix or datum, instead of UTM.
        waits_for_datum: whether `set_datum` defines the transform, not the first fix.
        find_frame: looks up the frames of the IMU and the receiver on the robot.
        world, base: names of the frames until an odometry message names them.

    Attributes:
        georeference: the transform; None until it is known.
        world, base: names of the frames in the odometry messages.
    """

    def __init__(
        self,
        heading: Heading,
        find_frame: FindFrame,
        *,
        flat: bool = False,
        uses_odometry_yaw: bool = False,
        uses_plane: bool = False,
        waits_for_datum: bool = False,
        world: str = "odom",
        base: str = "base_link",
    ) -> None:
        self.georeference: Georeference | None = None
        self.world, self.base = world, base
        self._heading = heading
        self._find_frame = find_frame
        self._flat = flat
        self._uses_odometry_yaw = uses_odometry_yaw
        self._uses_plane = uses_plane
        self._zone: Grid | None = None
        self._has_datum = waits_for_datum
        self._datum: tuple[float, float, float, Quaternion] | None = None
        self._odometry: Any = None
        self._fix: Any = None
        self._orientation: Quaternion | None = None
        self._odometry_is_new = self._fix_is_new = False

    @property
    def has_odometry(self) -> bool:
        """Whether an odometry message has been received, so that the names of the frames are known."""
        return self._odometry is not None

    def add_odometry(self, odometry: Any) -> None:
        """Use a nav_msgs/Odometry, unless its pose is not finite."""
        pose = pose_tuple(odometry.pose.pose)
        if not all(map(isfinite, pose)):
            return
        self.world, self.base = odometry.header.frame_id or self.world, odometry.child_frame_id or self.base
        self._odometry, self._odometry_is_new = odometry, True
        if self._uses_odometry_yaw:
            self._orientation = pose[3:]

    def add_fix(self, fix: Any) -> None:
        """Use a sensor_msgs/NavSatFix, unless it has no fix.

        Raises:
            UtmError: the fix is not on Earth, or too far from the zone of the first fix.
        """
        if fix.status.status == _NO_FIX or not all(map(isfinite, (fix.latitude, fix.longitude, fix.altitude))):
            return
        check_metres(fix.altitude)
        place = fix.latitude, fix.longitude, fix.altitude
        grid = self._find_grid(*place) if self.georeference is None else self.georeference.grid
        grid.forward(fix.latitude, fix.longitude)
        self._fix, self._fix_is_new = fix, True

    def add_imu(self, imu: Any) -> None:
        """Use the orientation of a sensor_msgs/Imu. It is ignored before the first odometry message, which names the
        robot's frame.
        """
        if self._odometry is None or self._uses_odometry_yaw:
            return
        frame = self._find_frame(self.base, imu.header.frame_id or self.base, imu.header.stamp.to_nsec())
        orientation = imu.orientation.x, imu.orientation.y, imu.orientation.z, imu.orientation.w
        if frame is not None and all(map(isfinite, orientation)):
            self._orientation = Mount(frame).robot_orientation(orientation)[3:]

    def set_datum(self, latitude: float, longitude: float, altitude: float, orientation: Quaternion) -> None:
        """Set the position of the world frame's origin on Earth, and the direction of its x axis (0 is east).

        Raises:
            UtmError: UTM is not defined there, or a number is not finite.
        """
        check_metres(altitude)
        if not all(map(isfinite, orientation)):
            raise UtmError("the orientation of the datum is not finite")
        self._find_grid(latitude, longitude, altitude).forward(latitude, longitude)
        self._has_datum, self.georeference = True, None
        self._datum = latitude, longitude, altitude, orientation

    def set_zone(self, name: str) -> None:
        """Use a UTM zone, such as ``31U``, even if the robot is in another one. The world frame does not move.

        Raises:
            UtmError: there is no such zone, the robot is too far from it, or UTM is not used.
        """
        if self._uses_plane:
            raise UtmError("UTM is not used, since use_local_cartesian is set")
        zone, old = Grid.named(name), self.georeference
        if old is not None:
            latitude, longitude, altitude = old.to_earth(0.0, 0.0, 0.0)
            turn = zone.convergence(latitude, longitude) - old.grid.convergence(latitude, longitude)
            yaw = to_angles(invert(old.pose)[3:])[2] + turn
            on_grid = (*zone.forward(latitude, longitude), altitude, *from_angles(0.0, 0.0, yaw))
            self.georeference = Georeference(zone, invert(on_grid), self._flat)
        self._zone = zone

    def start(self) -> bool:
        """Compute the transform if everything needed for it has been received. Return whether this call computed it.

        Raises:
            UtmError: the robot is too far from the zone of `set_zone`, or the odometry's position is not on Earth.
        """
        if self.georeference is not None:
            return False
        if self._has_datum:
            if self._datum is None:
                return False
            *place, orientation = self._datum
            self.georeference = self._reference(place, IDENTITY, orientation, None)
            return True
        if self._odometry is None or self._fix is None or self._orientation is None:
            return False
        place = [self._fix.latitude, self._fix.longitude, self._fix.altitude]
        pose, receiver = pose_tuple(self._odometry.pose.pose), self._receiver_offset()
        self.georeference = self._reference(place, pose, self._orientation, receiver)
        return True

    def make_odometry(self) -> Any:
        """Return the last fix as a nav_msgs/Odometry with the robot's position in its world frame.

        Returns None unless there are a new fix and new odometry.

        Raises:
            UtmError: the fix is too far from the zone of a datum.
        """
        if self.georeference is None or not (self._fix_is_new and self._odometry_is_new):
            return None
        self._fix_is_new = False
        fix, message = self._fix, Odometry()
        position = np.array(self.georeference.to_world(fix.latitude, fix.longitude, fix.altitude))
        offset = self._receiver_offset()
        if offset is not None:
            position -= matrix(pose_tuple(self._odometry.pose.pose)[3:]) @ offset
        message.header.stamp, message.header.frame_id = fix.header.stamp, self.world
        point = message.pose.pose.position
        point.x, point.y, point.z = position.tolist()
        if self._flat:
            point.z = 0.0
        message.pose.pose.orientation.w = 1.0
        rotation, covariance = matrix(self.georeference.pose[3:]), np.zeros((6, 6))
        covariance[:3, :3] = rotation @ np.array(fix.position_covariance).reshape(3, 3) @ rotation.T
        message.pose.covariance = covariance.ravel().tolist()
        return message

    def make_fix(self) -> Any:
        """Return the last odometry as a sensor_msgs/NavSatFix; None if there is no new one.

        Raises:
            UtmError: the odometry's position is too far away.
        """
        if self.georeference is None or not self._odometry_is_new or self._odometry is None:
            return None
        self._odometry_is_new = False
        odometry, message = self._odometry, NavSatFix()
        point = odometry.pose.pose.position
        message.latitude, message.longitude, message.altitude = self.georeference.to_earth(point.x, point.y, point.z)
        message.header.stamp, message.header.frame_id = odometry.header.stamp, self.base
        rotation = matrix(invert(self.georeference.pose)[3:])
        covariance = np.array(odometry.pose.covariance).reshape(6, 6)[:3, :3]
        message.position_covariance = (rotation @ covariance @ rotation.T).ravel().tolist()
        message.position_covariance_type, message.status.status = _KNOWN, _GBAS_FIX
        return message

    def _find_grid(self, latitude: float, longitude: float, altitude: float) -> Grid | LocalPlane:
        if not self._uses_plane:
            return self._zone or Grid.at(latitude, longitude)
        check_degrees(latitude, longitude)
        return LocalPlane(latitude, longitude, altitude)

    def _receiver_offset(self) -> Array | None:
        """Return the receiver's position on the robot (3,), or None if it is unknown."""
        name = self._fix.header.frame_id
        frame = self._find_frame(self.base, name, self._fix.header.stamp.to_nsec()) if name else None
        return None if frame is None else frame.offset

    def _reference(
        self, place: list[float], world: Transform, orientation: Quaternion, receiver: Array | None
    ) -> Georeference:
        latitude, longitude, altitude = place
        grid = self._find_grid(latitude, longitude, altitude)
        position = np.array((*grid.forward(latitude, longitude), altitude))
        roll, pitch, yaw = to_angles(orientation)
        yaw += self._heading.declination + self._heading.yaw_offset + grid.convergence(latitude, longitude)
        if receiver is not None:
            position -= matrix(from_angles(roll, pitch, yaw)) @ receiver
        x, y, z = position.tolist()
        on_grid = (x, y, z, *from_angles(0.0, 0.0, yaw))
        level = (*world[:3], *from_angles(0.0, 0.0, to_angles(world[3:])[2]))
        reference = Georeference(grid, multiply(level, invert(on_grid)), self._flat)
        reference.to_earth(0.0, 0.0, 0.0)  # raises if the odometry's position is too far away
        return reference
