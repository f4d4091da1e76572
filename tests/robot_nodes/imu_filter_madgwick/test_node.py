"""imu_filter_node through its topics."""

from __future__ import annotations

from collections.abc import Callable
from math import nan
from queue import Queue
from typing import Any

import pytest

from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import Vector3, Vector3Stamped
from pyros1.msgs.sensor_msgs.msg import Imu, MagneticField
from pyros1.msgs.std_msgs.msg import Header
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.reconfigure import Client
from pyros1.robot_nodes.imu_filter_madgwick.node import Madgwick
from pyros1.tf.rotation import Quaternion, to_angles

Make = Callable[..., Any]


def imu_at(seconds: float, rates: tuple[float, float, float] = (0.0, 0.0, 0.0), up: float = 9.81) -> Any:
    """Return what a level IMU sends."""
    header = Header(frame_id="/imu_link", stamp=Time.from_sec(seconds))
    message = Imu(header=header, angular_velocity=Vector3(*rates), linear_acceleration=Vector3(0.0, 0.0, up))
    message.angular_velocity_covariance = [float(index) for index in range(9)]
    return message


def field_at(seconds: float, *field: float) -> Any:
    return MagneticField(header=Header(stamp=Time.from_sec(seconds)), magnetic_field=Vector3(*field))


def orientation(message: Any) -> Quaternion:
    rotation = getattr(message, "orientation", None) or message.rotation
    return rotation.x, rotation.y, rotation.z, rotation.w


def test_messages_get_an_orientation(make_node: Make, wait_for_line: Callable[[str], None]) -> None:
    """Feature: imu_filter_madgwick publishes imu/data and the transform of an IMU"""
    user = make_node("user")
    came: Queue[Any] = Queue()
    transforms: Queue[Any] = Queue()
    angles: Queue[Any] = Queue()
    subscribers = [
        user.subscribe("/my_imu/data", Imu, came.put),
        user.subscribe("/tf", TFMessage, transforms.put),
        user.subscribe("/my_imu/rpy/filtered", Vector3Stamped, angles.put),
    ]
    arguments = "_use_mag:=false _orientation_stddev:=0.5 _fixed_frame:=map _publish_debug_topics:=true _gain:=0.5"
    node = make_node("imu_filter", argv=["imu:=my_imu", *arguments.split()])
    running = Madgwick(node)
    source = user.advertise("/my_imu/data_raw", Imu, queue_size=10)
    assert source.wait_for_subscribers(1, 20)
    assert all(subscriber.wait_for_publishers(1, 20) for subscriber in subscribers)
    source.publish(imu_at(100.0))
    first = came.get(timeout=20)
    assert orientation(first) == pytest.approx((0, 0, 0, 1))
    assert list(first.orientation_covariance) == [0.25, 0, 0, 0, 0.25, 0, 0, 0, 0.25]
    assert list(first.angular_velocity_covariance) == list(range(9)) and first.linear_acceleration.z == 9.81
    assert (first.header.frame_id, first.header.stamp) == ("/imu_link", Time(100))
    source.publish(imu_at(100.1, (0.0, 0.0, 1.0)))
    assert to_angles(orientation(came.get(timeout=20))) == pytest.approx((0, 0, 0.1))
    transforms.get(timeout=20)
    (transform,) = transforms.get(timeout=20).transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("map", "imu_link")
    assert to_angles(orientation(transform.transform)) == pytest.approx((0, 0, 0.1))
    angles.get(timeout=20)
    assert angles.get(timeout=20).vector.z == pytest.approx(0.1)
    source.publish(imu_at(100.2, (nan, 0.0, 1.0)))
    wait_for_line("an IMU message is ignored: the angular velocity is not finite: (nan, 0.0, 1.0)")
    source.publish(imu_at(100.19))
    wait_for_line("an IMU message is ignored, since it is 0.010 s older than the last")
    source.publish(imu_at(100.3, (0.0, 0.0, 1.0), up=0.0))
    assert to_angles(orientation(came.get(timeout=20)))[2] == pytest.approx(0.2), "the message with NaN has its time"
    wait_for_line("the IMU measures no acceleration: only its rotation is used")
    source.publish(imu_at(50.0))
    assert to_angles(orientation(came.get(timeout=20)))[2] == pytest.approx(0.0), "it starts again"
    nameless = imu_at(50.1)
    nameless.header.frame_id = ""
    source.publish(nameless)
    wait_for_line("IMU messages have no frame_id, so no transform is published")
    client = Client(user, "/imu_filter", timeout=20)
    assert client.update({"zeta": nan, "gain": 7.0}).zeta == 0.0
    assert user.params["/imu_filter/gain"] == 1.0
    client.close()
    del running


@pytest.mark.parametrize("old_type", [False, True])
def test_the_magnetic_field_shows_the_yaw(
    make_node: Make, wait_for_line: Callable[[str], None], old_type: bool
) -> None:
    user = make_node("user")
    came: Queue[Any] = Queue()
    raw: Queue[Any] = Queue()
    subscribers = [
        user.subscribe("/imu/data", Imu, came.put),
        user.subscribe("/imu/rpy/raw", Vector3Stamped, raw.put),
    ]
    arguments = "_publish_tf:=false _mag_bias_x:=0.5 _publish_debug_topics:=true"
    node = make_node("imu_filter", argv=[*arguments.split(), f"_use_magnetic_field_msg:={str(not old_type).lower()}"])
    running = Madgwick(node)
    imu = user.advertise("/imu/data_raw", Imu, queue_size=10)
    field = user.advertise("/imu/mag", Vector3Stamped if old_type else MagneticField, queue_size=10)
    assert imu.wait_for_subscribers(1, 20) and field.wait_for_subscribers(1, 20)
    assert all(subscriber.wait_for_publishers(1, 20) for subscriber in subscribers)

    def yaw_after(seconds: float, x: float) -> float:
        vector = field_at(seconds + 0.003, x, 0.0, -1.0)
        field.publish(Vector3Stamped(vector.header, vector.magnetic_field) if old_type else vector)
        imu.publish(imu_at(seconds))
        return to_angles(orientation(came.get(timeout=20)))[2]

    field.publish(
        Vector3Stamped(Header(stamp=Time(199)), Vector3(nan, 0.0, 0.0)) if old_type else field_at(199, nan, 0, 0)
    )
    imu.publish(imu_at(199.0))
    wait_for_line("an IMU message is ignored: the magnetic field is not finite")
    # The IMU faces north; in the ENU frame, that is a quarter turn from x, east.
    assert yaw_after(200.0, 1.0) == pytest.approx(1.5708, abs=1e-4)
    assert raw.get(timeout=20).vector.z == pytest.approx(1.5708, abs=1e-4)
    assert yaw_after(200.1, nan) == pytest.approx(1.5708, abs=1e-4), "without a field, the gyroscope counts"
    # A bag that is played in a loop.
    for number in range(6):
        imu.publish(imu_at(300.0 + number))
    assert yaw_after(10.0, 0.0) == pytest.approx(-1.5708, abs=1e-4), "it starts again, now to the south"
    del running


@pytest.mark.parametrize(
    ("argument", "line"),
    [
        ("_world_frame:=up", "world_frame must be enu, ned or nwu, not 'up'"),
        ("_constant_dt:=-1", "constant_dt must be a number of at least 0, not -1: using 0.0"),
        ("_use_mag:=7", "use_mag must be true or false"),
        ("_gain:=much", "/imu_filter/gain must be a number, not 'much': using 0.1"),
    ],
)
def test_wrong_parameters_are_reported(
    make_node: Make, wait_for_line: Callable[[str], None], argument: str, line: str
) -> None:
    running = Madgwick(make_node("imu_filter", argv=[argument]))
    wait_for_line(line)
    del running


def test_it_says_what_it_waits_for(
    make_node: Make, wait_for_line: Callable[[str], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.robot_nodes.shared.imu_node.WAIT_PERIOD", 0.05)
    running = Madgwick(make_node("imu_filter", argv=["imu/mag:=compass"]))
    wait_for_line("still waiting for messages on /imu/data_raw and /compass")
    del running
