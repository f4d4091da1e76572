"""The position of a robot on Earth, and of places on Earth for the robot."""

from __future__ import annotations

from functools import partial
from itertools import permutations
from math import cos, inf, nan, pi, sin
from typing import Any

import numpy as np
import pytest

from pyros1.ground.timing import Time
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.sensor_msgs.msg import Imu, NavSatFix
from pyros1.robot_nodes.robot_localization.local_plane import LocalPlane
from pyros1.robot_nodes.robot_localization.navsat import Heading, Navsat
from pyros1.robot_nodes.robot_localization.sensors import Frame
from pyros1.robot_nodes.robot_localization.utm import Grid, UtmError
from pyros1.tf.rotation import IDENTITY, from_angles

LATITUDE, LONGITUDE = 48.0, 10.5
GRID = Grid.at(LATITUDE, LONGITUDE)
CONVERGENCE = GRID.convergence(LATITUDE, LONGITUDE)
FRAMES = {
    "base_link": Frame(),
    "gps": Frame((0.5, 0.0, 1.0, *IDENTITY[3:])),
    "imu": Frame((0, 0, 0, *from_angles(0.0, 0.0, pi / 2))),
}


def make_navsat(declination: float = 0.0, yaw_offset: float = 0.0, **options: Any) -> Navsat:
    return Navsat(Heading(declination, yaw_offset), lambda base, name, time: FRAMES.get(name), **options)


def odometry(x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> Any:
    message = Odometry(child_frame_id="base_link")
    message.header.frame_id, message.header.stamp = "map", Time(3)
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    rotation = message.pose.pose.orientation
    rotation.x, rotation.y, rotation.z, rotation.w = from_angles(0.0, 0.0, yaw)
    message.pose.covariance = np.diag([1.0, 4.0, 9.0, 0, 0, 0]).ravel().tolist()
    return message


def imu(yaw: float, frame: str = "") -> Any:
    message = Imu()
    message.header.frame_id = frame
    rotation = message.orientation
    rotation.x, rotation.y, rotation.z, rotation.w = from_angles(0.0, 0.0, yaw)
    return message


def fix(east: float = 0.0, north: float = 0.0, altitude: float = 100.0, frame: str = "") -> Any:
    """Return the fix of a place so many metres from the first one, along the axes of the grid."""
    easting, northing = GRID.forward(LATITUDE, LONGITUDE)
    message = NavSatFix(altitude=altitude)
    message.latitude, message.longitude = GRID.inverse(easting + east, northing + north)
    message.header.frame_id, message.header.stamp = frame, Time(2)
    message.position_covariance = [1.0, 0, 0, 0, 4.0, 0, 0, 0, 9.0]
    return message


def position(navsat: Navsat, message: Any) -> list[float]:
    navsat.add_fix(message)
    navsat.add_odometry(odometry())
    point = navsat.make_odometry().pose.pose.position
    return [point.x, point.y, point.z]


def started(navsat: Navsat, *messages: Any) -> Navsat:
    adders = {Odometry: navsat.add_odometry, NavSatFix: navsat.add_fix, Imu: navsat.add_imu}
    for message in messages:
        assert not navsat.start(), "something is still missing"
        adders[type(message)](message)
    assert navsat.start()
    assert not navsat.start()
    return navsat


def test_a_robot_that_looks_east_has_the_axes_of_the_grid() -> None:
    navsat = started(make_navsat(), odometry(), fix(), imu(-CONVERGENCE))
    assert position(navsat, fix(30.0, 40.0, 105.0)) == pytest.approx([30.0, 40.0, 5.0], abs=1e-5)


def test_a_robot_that_looks_north_finds_east_at_its_right() -> None:
    navsat = started(make_navsat(), odometry(), imu(pi / 2 - CONVERGENCE), fix())
    assert position(navsat, fix(30.0, 40.0)) == pytest.approx([40.0, -30.0, 0.0], abs=1e-5)


def test_the_robot_may_have_driven_before_the_first_fix() -> None:
    navsat = started(make_navsat(), odometry(7.0, 8.0, 1.0), imu(1.0 - CONVERGENCE), fix())
    assert position(navsat, fix(30.0, 40.0)) == pytest.approx([37.0, 48.0, 0.0], abs=1e-5)


def test_the_heading_is_corrected() -> None:
    navsat = started(make_navsat(0.1, pi / 2), odometry(), imu(-0.1 - CONVERGENCE), fix())
    assert position(navsat, fix(30.0, 40.0)) == pytest.approx([40.0, -30.0, 0.0], abs=1e-5)


def test_a_mounted_imu_has_another_heading_than_the_robot() -> None:
    navsat = started(make_navsat(), odometry(), imu(pi / 2 - CONVERGENCE, "imu"), fix())
    assert position(navsat, fix(30.0, 40.0)) == pytest.approx([30.0, 40.0, 0.0], abs=1e-5)
    navsat = make_navsat()
    navsat.add_odometry(odometry())
    navsat.add_fix(fix())
    navsat.add_imu(imu(0.0, "unknown"))
    assert not navsat.start()


def test_the_heading_can_come_from_odometry() -> None:
    navsat = started(make_navsat(uses_odometry_yaw=True), fix(), odometry(yaw=0.4 - CONVERGENCE))
    cosine, sine = cos(CONVERGENCE), sin(CONVERGENCE)  # true east is the x axis
    assert position(navsat, fix(10.0, 0.0)) == pytest.approx([10 * cosine, -10 * sine, 0.0], abs=1e-5)


def test_the_receiver_is_beside_the_robots_centre() -> None:
    navsat = started(make_navsat(), odometry(), imu(-CONVERGENCE), fix(frame="gps"))
    assert position(navsat, fix(frame="gps")) == pytest.approx([0.0, 0.0, 0.0], abs=1e-5)
    navsat.add_fix(fix(30.0, 40.0, frame="gps"))
    navsat.add_odometry(odometry(yaw=pi / 2))
    point = navsat.make_odometry().pose.pose.position
    assert (point.x, point.y) == pytest.approx((30.5, 39.5), abs=1e-5)


def test_odometry_is_made_of_each_fix_once() -> None:
    navsat = started(make_navsat(), odometry(), imu(pi / 2 - CONVERGENCE), fix())
    message = navsat.make_odometry()
    assert (message.header.frame_id, message.header.stamp, message.pose.pose.orientation.w) == ("map", Time(2), 1.0)
    assert np.diag(np.array(message.pose.covariance).reshape(6, 6)) == pytest.approx([4.0, 1.0, 9.0, 0, 0, 0])
    assert navsat.make_odometry() is None


def test_fixes_are_made_of_odometry() -> None:
    navsat = started(make_navsat(), odometry(), imu(pi / 2 - CONVERGENCE), fix())
    navsat.add_odometry(odometry(40.0, -30.0))
    found, expected = navsat.make_fix(), fix(30.0, 40.0)
    assert (found.latitude, found.longitude) == pytest.approx((expected.latitude, expected.longitude), abs=1e-9)
    assert (found.altitude, found.header.frame_id, found.header.stamp) == (pytest.approx(100.0), "base_link", Time(3))
    assert np.diag(np.array(found.position_covariance).reshape(3, 3)) == pytest.approx([4.0, 1.0, 9.0])
    assert (found.status.status, found.position_covariance_type) == (2, 3)
    assert navsat.make_fix() is None


def test_a_datum_is_the_origin_of_the_world() -> None:
    navsat = make_navsat(waits_for_datum=True)
    for add, message in ((navsat.add_odometry, odometry(5.0)), (navsat.add_fix, fix()), (navsat.add_imu, imu(0.0))):
        add(message)
    assert not navsat.start()
    navsat.set_datum(LATITUDE, LONGITUDE, 100.0, from_angles(0.0, 0.0, -CONVERGENCE))
    assert navsat.start()
    assert position(navsat, fix(30.0, 40.0)) == pytest.approx([30.0, 40.0, 0.0], abs=1e-5)
    assert navsat.georeference is not None
    assert navsat.georeference.to_earth(0.0, 0.0, 0.0) == pytest.approx((LATITUDE, LONGITUDE, 100.0))
    navsat.set_datum(LATITUDE, LONGITUDE, 0.0, from_angles(0.0, 0.0, pi / 2 - CONVERGENCE))
    assert navsat.start(), "a datum can be set again"
    assert position(navsat, fix(30.0, 40.0)) == pytest.approx([40.0, -30.0, 100.0], abs=1e-5)


def test_a_plane_instead_of_utm() -> None:
    """A heading of 0 is true east, and metres are not scaled, as UTM's are."""
    navsat = started(make_navsat(uses_plane=True), odometry(), imu(0.0), fix())
    plane = LocalPlane(LATITUDE, LONGITUDE, 100.0)
    message = fix(altitude=103.0)
    message.latitude, message.longitude = plane.inverse(3000.0, 4000.0)
    assert position(navsat, message) == pytest.approx([3000.0, 4000.0, 3.0], abs=1e-5)
    assert navsat.georeference is not None
    assert navsat.georeference.to_earth(3000.0, 4000.0, 0.0)[:2] == pytest.approx((message.latitude, message.longitude))
    with pytest.raises(UtmError, match="UTM is not used"):
        navsat.set_zone("32U")


@pytest.mark.parametrize(("zone", "northing"), [("33U", 0.0), ("31u", 0.0), ("32H", 10_000_000.0)])
def test_the_zone_can_be_chosen(zone: str, northing: float) -> None:
    """A robot at the edge of a zone. What is on Earth stays where it is in the world frame, but for UTM's scale."""
    before, navsat = make_navsat(), started(make_navsat(), odometry(1.0, 2.0, 0.5), imu(0.7), fix())
    before.set_zone(zone)
    before = started(before, odometry(1.0, 2.0, 0.5), imu(0.7), fix())
    old = position(navsat, fix(30.0, 40.0))
    navsat.set_zone(zone)
    for each in (navsat, before):
        assert each.georeference is not None
        grid = Grid.named(zone)
        assert (each.georeference.grid, grid.north) == (grid, northing == 0.0)
        assert position(each, fix(30.0, 40.0)) == pytest.approx(old, abs=0.2)
        assert position(each, fix()) == pytest.approx([1.0, 2.0, 0.0], abs=0.01)


@pytest.mark.parametrize("zone", ["", "U", "31", "61U", "0U", "31I", "U31", "31U\n", "\N{ARABIC-INDIC DIGIT THREE}U"])
def test_zones_that_do_not_exist(zone: str) -> None:
    with pytest.raises(UtmError, match="a UTM zone is a number from 1 to 60"):
        make_navsat().set_zone(zone)


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_messages_may_come_in_any_order(order: tuple[int, ...]) -> None:
    """All come again and again; what comes late is waited for."""
    navsat = make_navsat()
    adders = [partial(navsat.add_odometry, odometry()), partial(navsat.add_fix, fix())]
    adders.append(partial(navsat.add_imu, imu(-CONVERGENCE)))
    for index in order:
        assert not navsat.start()
        adders[index]()
    if not navsat.start():  # the IMU came before the odometry, which names the frame that its heading is needed in
        adders[2]()
        assert navsat.start()
    assert position(navsat, fix(30.0, 40.0)) == pytest.approx([30.0, 40.0, 0.0], abs=1e-5)


def test_altitudes_can_be_left_out() -> None:
    navsat = started(make_navsat(flat=True), odometry(), imu(0.0), fix(frame="gps"))
    assert position(navsat, fix(altitude=300.0, frame="gps"))[2] == 0.0


def test_garbage_is_ignored_or_refused() -> None:
    navsat = make_navsat()
    navsat.add_odometry(odometry(nan))
    navsat.add_fix(fix(altitude=nan))
    lost = fix()
    lost.status.status = -1
    navsat.add_fix(lost)
    navsat.add_imu(imu(0.0))
    assert not navsat.start()
    polar = fix()
    polar.latitude = 89.0
    with pytest.raises(UtmError, match="there is no UTM"):
        navsat.add_fix(polar)
    with pytest.raises(UtmError):
        navsat.set_datum(200.0, 0.0, 0.0, IDENTITY[3:])
    navsat = started(make_navsat(), odometry(), imu(0.0), fix())
    far = fix()
    far.longitude = -170.0
    with pytest.raises(UtmError, match="too far from UTM zone 32"):
        navsat.add_fix(far)


@pytest.mark.parametrize("uses_plane", [False, True])
def test_what_is_not_finite_or_far_from_the_earth_is_refused(uses_plane: bool) -> None:
    navsat = make_navsat(uses_plane=uses_plane)
    for altitude, w in ((nan, 1.0), (inf, 1.0), (1e308, 1.0), (0.0, nan)):
        with pytest.raises(UtmError):
            navsat.set_datum(LATITUDE, LONGITUDE, altitude, (0.0, 0.0, 0.0, w))
    with pytest.raises(UtmError, match="coordinates out of range"):
        navsat.add_fix(fix(altitude=1e308))
    started(navsat, odometry(), imu(0.0), fix())
    reference = navsat.georeference
    assert reference is not None
    for x in (1e12, 1e308, nan):
        with pytest.raises(UtmError, match="coordinates out of range"):
            reference.to_earth(x, 0.0, 0.0)
    with pytest.raises(UtmError):
        reference.to_world(LATITUDE, LONGITUDE, nan)
    navsat.add_odometry(odometry(1e12))
    with pytest.raises(UtmError):
        navsat.make_fix()
    navsat = make_navsat(uses_plane=uses_plane)
    for add, message in ((navsat.add_odometry, odometry(1e12)), (navsat.add_imu, imu(0.0)), (navsat.add_fix, fix())):
        add(message)
    with pytest.raises(UtmError, match="coordinates out of range"):
        navsat.start()


def test_a_datum_far_from_the_chosen_zone_is_refused() -> None:
    navsat = make_navsat()
    navsat.set_zone("31U")
    with pytest.raises(UtmError, match="too far from UTM zone 31"):
        navsat.set_datum(LATITUDE, -170.0, 0.0, IDENTITY[3:])
