"""navsat_transform_node through its topics and services.

Feature: the position of a robot by GPS -- navsat_transform_node of robot_localization
"""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from typing import Any

import pytest

from pyros1.ground.errors import ServiceError
from pyros1.msgs.geographic_msgs.msg import GeoPoint, GeoPose
from pyros1.msgs.geometry_msgs.msg import Point
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.robot_localization.srv import FromLL, SetDatum, SetUTMZone, ToLL
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.sensor_msgs.msg import Imu, NavSatFix
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.node import Node
from pyros1.robot_nodes.robot_localization.navsat_node import NavsatNode

PATIENCE = 20.0


class Robot:
    """A node that stands still and says where, beside the node that is tested."""

    def __init__(self, make_node: Callable[..., Node], parameters: dict[str, Any]) -> None:
        self.node = node = make_node("robot")
        node.params["/navsat"] = {"frequency": 50, **parameters}
        self.heard: dict[str, Queue[Any]] = {}
        for topic, kind in (("odometry/gps", Odometry), ("gps/filtered", NavSatFix), ("tf_static", TFMessage)):
            self.heard[topic] = Queue()
            node.subscribe(topic, kind, self.heard[topic].put)
        self.log: Queue[Any] = Queue()
        node.subscribe("/rosout", Log, self.log.put)
        self.fix = NavSatFix(latitude=48.0, longitude=9.0, altitude=100.0)
        self.fix.header.frame_id = "gps"
        self.program = NavsatNode(make_node("navsat"))
        odometry, imu = Odometry(child_frame_id="base_link"), Imu()
        odometry.header.frame_id, odometry.pose.pose.orientation.w, imu.orientation.w = "map", 1.0, 1.0
        self.imu = node.advertise("imu/data", Imu)
        publish = [
            node.advertise("odometry/filtered", Odometry).publish,
            self.imu.publish,
            node.advertise("gps/fix", NavSatFix).publish,
        ]

        def report(event: object) -> None:
            for send, message in zip(publish, (odometry, imu, self.fix), strict=True):
                send(message)

        node.timer(0.02, report)

    def call(self, service: str, kind: Any, argument: object) -> Any:
        self.node.wait_for_service(service, PATIENCE)
        return self.node.service(service, kind).call(kind._request_class(argument), PATIENCE)

    def until_logged(self, text: str) -> None:
        while text not in self.log.get(timeout=PATIENCE).msg:
            pass


@pytest.mark.parametrize("name", ["utm", "cartesian"])
def test_a_robot_with_a_receiver(make_node: Callable[..., Node], name: str) -> None:
    robot = Robot(make_node, {"publish_filtered_gps": True, f"broadcast_{name}_transform": True})
    odometry = robot.heard["odometry/gps"].get(timeout=PATIENCE)
    assert (odometry.header.frame_id, odometry.pose.pose.orientation.w) == ("map", 1.0)
    assert odometry.pose.pose.position.x == pytest.approx(0.0, abs=1e-6)
    fix = robot.heard["gps/filtered"].get(timeout=PATIENCE)
    assert (fix.latitude, fix.longitude, fix.header.frame_id) == (pytest.approx(48.0), pytest.approx(9.0), "base_link")
    (transform,) = robot.heard["tf_static"].get(timeout=PATIENCE).transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("map", "utm")
    assert transform.transform.translation.x == pytest.approx(-500_000.0, abs=1.0)
    while robot.imu.num_connections:  # it is no longer needed
        robot.heard["odometry/gps"].get(timeout=PATIENCE)
    place = robot.call("toLL", ToLL, Point(100.0, 0.0, 0.0)).ll_point
    assert place.longitude > 9.001
    point = robot.call("fromLL", FromLL, place).map_point
    assert (point.x, point.y, point.z) == pytest.approx((100.0, 0.0, 0.0), abs=1e-6)
    with pytest.raises(ServiceError, match="not degrees on Earth"):
        robot.call("fromLL", FromLL, GeoPoint(latitude=100.0))
    with pytest.raises(ServiceError, match="coordinates out of range"):
        robot.call("toLL", ToLL, Point(1e12, 0.0, 0.0))
    with pytest.raises(ServiceError, match="such as 31U"):
        robot.call("setUTMZone", SetUTMZone, "north")
    robot.call("setUTMZone", SetUTMZone, "31U")
    robot.until_logged("in UTM zone 31 north")
    (transform,) = robot.heard["tf_static"].get(timeout=PATIENCE).transforms
    assert transform.transform.translation.x < -900_000.0
    robot.call("setUTMZone", SetUTMZone, "32U")
    robot.until_logged("in UTM zone 32 north")
    robot.fix.longitude = 170.0
    robot.until_logged("a fix is ignored: latitude 48.000, longitude 170.000 is too far from UTM zone 32")


def test_a_datum(make_node: Callable[..., Node]) -> None:
    robot = Robot(
        make_node,
        {"wait_for_datum": True, "broadcast_utm_transform": True, "broadcast_utm_transform_as_parent_frame": True},
    )
    with pytest.raises(ServiceError, match="not known yet"):
        robot.call("toLL", ToLL, Point())
    with pytest.raises(ServiceError, match="there is no UTM"):
        robot.call("datum", SetDatum, GeoPose(position=GeoPoint(latitude=88.0)))
    robot.call("datum", SetDatum, GeoPose(position=GeoPoint(latitude=48.0, longitude=9.0, altitude=40.0)))
    odometry = robot.heard["odometry/gps"].get(timeout=PATIENCE)
    assert odometry.pose.pose.position.z == pytest.approx(60.0)
    (transform,) = robot.heard["tf_static"].get(timeout=PATIENCE).transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("utm", "map")


def test_a_plane_instead_of_utm(make_node: Callable[..., Node]) -> None:
    robot = Robot(make_node, {"use_local_cartesian": True, "broadcast_cartesian_transform": True})
    (transform,) = robot.heard["tf_static"].get(timeout=PATIENCE).transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("map", "local_enu")
    assert transform.transform.translation.x == pytest.approx(0.0, abs=1e-6)
    place = robot.call("toLL", ToLL, Point(0.0, 100.0, 0.0)).ll_point
    assert place.longitude == pytest.approx(9.0)


@pytest.mark.parametrize(
    ("datum", "text"),
    [
        ([48.0, 9.0, 0.0, "map", "base_link"], "the origin of map is at latitude 48.0000000, longitude 9.0000000"),
        ([48.0], "datum must be a list of latitude and longitude in degrees, and a heading in radians"),
        ([-88.0, 9.0, 0.0], "the parameter datum cannot be used: at a latitude of -88.000 there is no UTM"),
    ],
)
def test_a_datum_from_a_parameter(make_node: Callable[..., Node], datum: object, text: str) -> None:
    Robot(make_node, {"wait_for_datum": True, "datum": datum, "delay": 0.05}).until_logged(text)


def test_angles_that_seem_to_be_in_degrees(make_node: Callable[..., Node], capfd: pytest.CaptureFixture[str]) -> None:
    make_node("user").params["/navsat"] = {"magnetic_declination_radians": -10.5, "yaw_offset": 1.5707963}
    NavsatNode(make_node("navsat"))
    written = capfd.readouterr()
    lines = (written.out + written.err).splitlines()
    (line,) = (line for line in lines if "[WARN]" in line)
    assert "/navsat/magnetic_declination_radians is in radians: -10.5 is more than a turn. Degrees?" in line
