"""complementary_filter_node through its topics."""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from typing import Any

import pytest

from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import Vector3
from pyros1.msgs.sensor_msgs.msg import Imu
from pyros1.msgs.std_msgs.msg import Bool, Header
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.robot_nodes.imu_complementary_filter.node import Complementary

Make = Callable[..., Any]


def test_messages_get_an_orientation(make_node: Make) -> None:
    """Feature: imu_complementary_filter publishes imu/data, without the bias of the gyroscope"""
    user = make_node("user")
    came: Queue[Any] = Queue()
    steady: Queue[Any] = Queue()
    transforms: Queue[Any] = Queue()
    subscribers = [
        user.subscribe("/imu/data", Imu, came.put),
        user.subscribe("/imu/steady_state", Bool, steady.put),
        user.subscribe("/tf", TFMessage, transforms.put),
    ]
    arguments = "_bias_alpha:=0.5 _constant_dt:=0.1 _publish_debug_topics:=true _publish_tf:=true _reverse_tf:=true"
    running = Complementary(make_node("filter", argv=arguments.split()))
    source = user.advertise("/imu/data_raw", Imu, queue_size=10)
    assert source.wait_for_subscribers(1, 20)
    assert all(subscriber.wait_for_publishers(1, 20) for subscriber in subscribers)
    for second in range(1, 4):
        header = Header(frame_id="imu_link", stamp=Time(second))
        rates, up = Vector3(0.0, 0.0, 0.1), Vector3(0.0, 0.0, 9.81)
        source.publish(Imu(header=header, angular_velocity=rates, linear_acceleration=up))
    outputs = [came.get(timeout=20) for _ in range(2)]
    assert [message.header.stamp for message in outputs] == [Time(2), Time(3)], "the first message has no output"
    assert [message.angular_velocity.z for message in outputs] == pytest.approx([0.05, 0.025])
    assert [message.orientation.z for message in outputs] == pytest.approx([0.0, 0.00125], abs=1e-6)
    assert [steady.get(timeout=20).data for _ in range(2)] == [True, True]
    transforms.get(timeout=20)
    (transform,) = transforms.get(timeout=20).transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("imu_link", "odom")
    assert transform.transform.rotation.z == pytest.approx(-0.00125, abs=1e-6)
    del running
