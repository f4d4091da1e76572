"""navsat_transform_node: publishes a robot's GPS position in the frame of its odometry.

See https://docs.ros.org/en/noetic/api/robot_localization/html/navsat_transform_node.html.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from math import tau
from typing import Any

from pyros1.ground.errors import ServiceRefusal
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.robot_localization.srv import FromLL, SetDatum, SetUTMZone, ToLL
from pyros1.msgs.sensor_msgs.msg import Imu, NavSatFix
from pyros1.node import Node
from pyros1.robot_nodes.robot_localization.ekf_node import find_prefix
from pyros1.robot_nodes.robot_localization.frames import Frames
from pyros1.robot_nodes.robot_localization.navsat import Heading, Navsat
from pyros1.robot_nodes.robot_localization.output import make_transform
from pyros1.robot_nodes.robot_localization.sensors import unit
from pyros1.robot_nodes.robot_localization.settings import prefixed
from pyros1.robot_nodes.robot_localization.utm import UtmError
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number
from pyros1.robot_nodes.shared.program import run_node
from pyros1.tf.broadcaster import StaticTransformBroadcaster
from pyros1.tf.rotation import from_angles, invert

_IGNORED = "a fix is ignored: %s"


class NavsatNode:
    """The topics, services and timer of navsat_transform_node.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        parameters = PrivateParameters.of(node)
        waits_for_datum = parameters.flag("wait_for_datum", False)
        uses_odometry_yaw = parameters.flag("use_odometry_yaw", False)
        self._flat = parameters.flag("zero_altitude", False)
        self._delay = parameters.number("delay", 0.0, 0.0)
        self._started_at = node.now()
        uses_plane = parameters.flag("use_local_cartesian", False)
        self._cartesian_frame = parameters.text("cartesian_frame_id", "local_enu" if uses_plane else "utm")
        self._broadcasts = _either(parameters, "broadcast_{}_transform")
        self._is_parent = _either(parameters, "broadcast_{}_transform_as_parent_frame")
        prefix = find_prefix(node)
        self._navsat = Navsat(
            Heading(_angle(node, parameters, "magnetic_declination_radians"), _angle(node, parameters, "yaw_offset")),
            Frames(node, parameters.number("transform_timeout", 0.0, 0.0)).find,
            flat=self._flat,
            uses_odometry_yaw=uses_odometry_yaw,
            uses_plane=uses_plane,
            waits_for_datum=waits_for_datum,
            world=prefixed("odom", prefix),
            base=prefixed("base_link", prefix),
        )
        if waits_for_datum:
            self._read_datum(parameters)

        self._broadcaster = StaticTransformBroadcaster(node) if self._broadcasts else None
        self._odometry = node.advertise("odometry/gps", Odometry, queue_size=10)
        self._filtered: Any = None
        if parameters.flag("publish_filtered_gps", False):
            self._filtered = node.advertise("gps/filtered", NavSatFix, queue_size=10)
        node.advertise_service("datum", SetDatum, self._on_datum)
        node.advertise_service("setUTMZone", SetUTMZone, self._on_zone)
        node.advertise_service("toLL", ToLL, self._on_to_earth)
        node.advertise_service("fromLL", FromLL, self._on_from_earth)
        self._imu: Any = None
        self._is_new = False
        if not (waits_for_datum or uses_odometry_yaw):
            self._imu = node.subscribe("imu/data", Imu, self._on_imu, queue_size=1)
        node.subscribe("odometry/filtered", Odometry, self._on_odometry, queue_size=1)
        node.subscribe("gps/fix", NavSatFix, self._on_fix, queue_size=1)
        node.timer(1.0 / parameters.number("frequency", 10.0, 0.01, 10_000.0), lambda event: self.update())

    def update(self) -> None:
        """Compute the transform if it is not known yet, and publish new positions."""
        with self._lock:
            if not self._started_at:  # simulated time has not begun
                self._started_at = self._node.now()
            if (self._node.now() - self._started_at).to_sec() < self._delay:
                return
            if self._attempt(self._navsat.start, "there is no transform yet: %s"):
                self._is_new = True
            # With a datum, the transform is known before an odometry message has named the frame.
            if self._is_new and self._navsat.has_odometry:
                self._is_new = False
                self._announce()
            odometry = self._attempt(self._navsat.make_odometry, _IGNORED)
            fix = None if self._filtered is None else self._attempt(self._navsat.make_fix, "an odometry is ignored: %s")
        if odometry is not None:
            self._odometry.publish(odometry)
        if fix is not None:
            self._filtered.publish(fix)

    def _attempt(self, function: Callable[[], Any], text: str) -> Any:
        try:
            return function()
        except UtmError as error:
            self._node.log.error(text, error, throttle=10)
            return None

    def _announce(self) -> None:
        """Log and broadcast the transform; the IMU is no longer needed."""
        reference = self._navsat.georeference
        assert reference is not None
        imu, self._imu = self._imu, None
        if imu is not None:
            imu.unregister()
        latitude, longitude, _ = reference.to_earth(0.0, 0.0, 0.0)
        text = "the origin of %s is at latitude %.7f, longitude %.7f, in %s"
        self._node.log.info(text, self._navsat.world, latitude, longitude, reference.grid.name)
        if self._broadcaster is not None:
            parent, child, pose = self._navsat.world, self._cartesian_frame, reference.pose
            if self._is_parent:
                parent, child, pose = child, parent, invert(pose)
            if self._flat:
                pose = (*pose[:2], 0.0, *pose[3:])
            self._broadcaster.send_transform(make_transform(pose, self._node.now(), parent, child))

    def _read_datum(self, parameters: PrivateParameters) -> None:
        datum = parameters.value("datum")
        if datum is None:
            self._node.log.info("waiting for the service datum, since wait_for_datum is set")
            return
        if not (isinstance(datum, list) and len(datum) >= 3 and all(map(is_number, datum[:3]))):
            parameters.report_invalid(
                "datum", datum, "a list of latitude and longitude in degrees, and a heading in radians", ""
            )
            return
        latitude, longitude, yaw = (float(number) for number in datum[:3])
        try:
            self._navsat.set_datum(latitude, longitude, 0.0, from_angles(0.0, 0.0, yaw))
        except UtmError as error:
            self._node.log.error("the parameter datum cannot be used: %s", error)

    def _on_imu(self, message: Any) -> None:
        with self._lock:
            self._navsat.add_imu(message)

    def _on_odometry(self, message: Any) -> None:
        with self._lock:
            self._navsat.add_odometry(message)

    def _on_fix(self, message: Any) -> None:
        if not message.header.frame_id:
            self._node.log.warn(
                "fixes have no frame_id: the receiver is assumed to be at the robot's origin", throttle=60
            )
        try:
            with self._lock:
                self._navsat.add_fix(message)
        except UtmError as error:
            self._node.log.error(_IGNORED, error, throttle=10)

    def _on_datum(self, request: Any) -> Any:
        place, rotation = request.geo_pose.position, request.geo_pose.orientation
        orientation = unit((rotation.x, rotation.y, rotation.z, rotation.w))
        try:
            with self._lock:
                self._navsat.set_datum(place.latitude, place.longitude, place.altitude, orientation)
        except UtmError as error:
            raise ServiceRefusal(str(error)) from error
        return SetDatum._response_class()

    def _on_zone(self, request: Any) -> Any:
        try:
            with self._lock:
                self._navsat.set_zone(request.utm_zone)
                self._is_new = self._navsat.georeference is not None
        except UtmError as error:
            raise ServiceRefusal(str(error)) from error
        return SetUTMZone._response_class()

    def _on_to_earth(self, request: Any) -> Any:
        response, point = ToLL._response_class(), request.map_point
        try:
            place = self._reference().to_earth(point.x, point.y, point.z)
        except UtmError as error:
            raise ServiceRefusal(str(error)) from error
        response.ll_point.latitude, response.ll_point.longitude, response.ll_point.altitude = place
        return response

    def _on_from_earth(self, request: Any) -> Any:
        response, place = FromLL._response_class(), request.ll_point
        try:
            point = self._reference().to_world(place.latitude, place.longitude, place.altitude)
        except UtmError as error:
            raise ServiceRefusal(str(error)) from error
        response.map_point.x, response.map_point.y, response.map_point.z = point
        return response

    def _reference(self) -> Any:
        with self._lock:
            reference = self._navsat.georeference
        if reference is None:
            raise ServiceRefusal(
                "the robot's position is not known yet: it needs a fix, odometry and IMU data, or a datum"
            )
        return reference


def _either(parameters: PrivateParameters, name: str) -> bool:
    """Return a flag whose parameter has an old name, with utm, and a new one, with cartesian."""
    return parameters.flag(name.format("utm"), parameters.flag(name.format("cartesian"), False))


def _angle(node: Node, parameters: PrivateParameters, name: str) -> float:
    """Return an angle in radians; warn if it seems to be in degrees, since the robot would then drive anywhere."""
    angle = parameters.number(name, 0.0)
    if abs(angle) > tau:
        node.log.warn("the parameter %s/%s is in radians: %g is more than a turn. Degrees?", node.name, name, angle)
    return angle


def main(argv: list[str]) -> int:
    """Run navsat_transform_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "navsat_transform_node", NavsatNode)


if __name__ == "__main__":
    sys.exit(main(sys.argv))
