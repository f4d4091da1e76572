"""Conversions, prefixes of frames, log messages and clocks across real bridges.

Feature: images as JPEG or H.264 and thinned-out clouds between masters -- `pyros1 bridge`
Feature: the tf trees of several robots as one, with prefixes -- `pyros1 bridge`
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from PIL import Image as Pillow

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.rosgraph_msgs.msg import Clock, Log
from pyros1.msgs.sensor_msgs.msg import Image, LaserScan
from pyros1.msgs.tf2_msgs.msg import TFMessage

from .conftest import QueuedSubscriber, RunningSite, subscriptions, wait_for_subscribers, wait_until

MakeSite = Callable[..., RunningSite]


def sent(site: RunningSite, local: str) -> Any:
    return next(entry for entry in json.loads(site.bridge.status())["sent"] if entry["local"] == local)


def image(value: int, encoding: str = "mono8") -> Any:
    size = 4 if encoding == "32FC1" else 1
    return Image(height=16, width=32, encoding=encoding, step=32 * size, data=bytes([value]) * 16 * 32 * size)


def test_images_as_jpeg(make_site: MakeSite, endpoint: str) -> None:
    base = make_site("base", "{take: ['red:**']}", (), (endpoint,))
    red = make_site("red", "{send: [{topic: '/camera/**', convert: jpeg}]}", (endpoint,))
    publisher: Any = red.node.advertise("/camera/image_raw", Image)
    other = red.node.advertise("/camera/camera_info", "sensor_msgs/CameraInfo")
    base.has_topic("/red/camera/image_raw/compressed")
    assert base.topics()["/red/camera/image_raw/compressed"] == "sensor_msgs/CompressedImage"
    assert subscriptions(publisher) == 0, "nobody wants it yet"
    subscriber = QueuedSubscriber(base.node, "/red/camera/image_raw/compressed", "sensor_msgs/CompressedImage")
    wait_for_subscribers(publisher)
    wait_until(lambda: sent(red, "/camera/image_raw")["wanted_by"] == ["base"], "the base wants it")
    publisher.publish(image(200))
    received = subscriber.get()
    assert received.format == "mono8; jpeg compressed "
    assert np.abs(np.asarray(Pillow.open(io.BytesIO(received.data))).astype(int) - 200).max() <= 2
    publisher.publish(image(0, "32FC1"))
    wait_until(lambda: sent(red, "/camera/image_raw")["dropped"] == {"could not be converted": 1}, "it is counted")
    status = json.loads(red.bridge.status())
    assert "32FC1" in status["problems"]["/camera/image_raw"]
    assert sent(red, "/camera/image_raw")["conversion"] == "jpeg"
    assert subscriptions(other) == 0 and "/red/camera/camera_info" not in base.topics()
    publisher.publish(image(10))
    assert np.asarray(Pillow.open(io.BytesIO(subscriber.get().data))).max() < 13
    subscriber.subscriber.unregister()
    wait_until(lambda: subscriptions(publisher) == 0, "the bridge unsubscribes")


def test_a_conversion_that_is_not_for_the_type(make_site: MakeSite, endpoint: str) -> None:
    red = make_site("red", "{send: [{topic: /scan, convert: jpeg}]}", (), (endpoint,))
    red.node.advertise("/scan", LaserScan)
    problem = "convert: jpeg is for sensor_msgs/Image, not for sensor_msgs/LaserScan"
    wait_until(lambda: json.loads(red.bridge.status())["problems"] == {"/scan": problem}, "the status says so")
    assert json.loads(red.bridge.status())["sent"] == []


def test_scans_with_fewer_beams(make_site: MakeSite, endpoint: str) -> None:
    base = make_site("base", "{take: ['red:**']}", (), (endpoint,))
    red = make_site("red", "{send: [{topic: /scan, convert: every, every: 2}]}", (endpoint,))
    publisher: Any = red.node.advertise("/scan", LaserScan, latch=True)
    publisher.publish(LaserScan(ranges=(1.0, 2.0, 3.0), angle_increment=0.5))
    base.has_topic("/red/scan")
    for _ in range(2):
        scan = QueuedSubscriber(base.make_node(f"viewer{_}"), "/red/scan", "sensor_msgs/LaserScan").get()
        assert (scan.ranges, scan.angle_increment) == ((1.0, 3.0), 1.0)


def test_video_for_who_comes_later(make_site: MakeSite, endpoint: str) -> None:
    av = pytest.importorskip("av")
    from pyros1.bridge.conversions.video import video_class

    base = make_site("base", "{take: ['red:**']}", (), (endpoint,))
    red = make_site("red", "{send: [{topic: /camera, convert: h264}]}", (endpoint,))
    blue = make_site("blue", "{take: ['red:**']}", (endpoint,))
    publisher: Any = red.node.advertise("/camera", Image)
    wanting = []
    for site in (base, blue):
        site.has_topic("/red/camera/h264")
        subscriber = QueuedSubscriber(site.node, "/red/camera/h264", video_class())
        wanting.append(site.name)
        wait_until(lambda: sent(red, "/camera")["wanted_by"] == sorted(wanting), "it wants the video")
        wait_for_subscribers(publisher)
        publisher.publish(image(50))
        message = subscriber.get()
        assert (message._type, message.format) == ("foxglove_msgs/CompressedVideo", "h264")
        (frame,) = av.CodecContext.create("h264", "r").decode(av.Packet(message.data))
        assert frame.key_frame and (frame.width, frame.height) == (32, 16)


def transform(parent: str, child: str) -> Any:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.transform.rotation.w = 1.0
    return message


def test_two_robots_in_one_tf_tree(make_site: MakeSite, endpoint: str) -> None:
    rules = "\n".join(
        f"- {{topic: '{robot}:/{topic}', here: /{topic}, prefix_frames: {robot}, keep_frames: [map]}}"
        for robot in ("red", "blue")
        for topic in ("tf", "tf_static")
    )
    base = make_site("base", f"take:\n{rules}", (), (endpoint,))
    publishers: dict[str, Any] = {}
    for name, x in (("red", 1.0), ("blue", 2.0)):
        robot = make_site(name, "{send: [/tf, /tf_static]}", (endpoint,))
        fixed: Any = robot.node.advertise("/tf_static", TFMessage, latch=True)
        fixed.publish([transform("base_link", "laser")])
        placed = transform("map", "base_link")
        placed.transform.translation.x = x
        publishers[name] = robot.node.advertise("/tf", TFMessage, latch=True)
        publishers[name].publish([placed])
    for topic, expected in (
        ("/tf_static", {("red/base_link", "red/laser"), ("blue/base_link", "blue/laser")}),
        ("/tf", {("map", "red/base_link"), ("map", "blue/base_link")}),
    ):
        base.has_topic(topic)
        subscriber = QueuedSubscriber(base.node, topic, "tf2_msgs/TFMessage")
        seen = {}
        while seen.keys() != expected:
            for each in subscriber.get().transforms:
                seen[each.header.frame_id, each.child_frame_id] = each.transform.translation.x
        if topic == "/tf":
            assert seen == {("map", "red/base_link"): 1.0, ("map", "blue/base_link"): 2.0}


def test_log_messages_of_a_robot(make_site: MakeSite, endpoint: str) -> None:
    base = make_site("base", "{take: [{topic: 'red:/rosout', here: /rosout_agg}]}", (), (endpoint,))
    red = make_site("red", "{send: [/rosout]}", (endpoint,))
    base.has_topic("/rosout_agg")
    subscriber = QueuedSubscriber(base.node, "/rosout_agg", "rosgraph_msgs/Log")
    driver = red.make_node("driver")

    def arrives() -> bool:
        driver.log.warning("the motor is hot")
        return not subscriber.is_silent()

    wait_until(arrives, "a log message of red")
    log: Any = subscriber.get()
    while log.msg != "the motor is hot":
        log = subscriber.get()
    assert (log.name, log.level) == ("/red/driver", Log.WARN)


def test_the_clock_of_a_simulation(make_site: MakeSite, endpoint: str) -> None:
    base = make_site("base", "{take: [{topic: 'red:/clock', here: /clock}]}", (), (endpoint,))
    red = make_site("red", "{send: [/clock]}", (endpoint,))
    clock: Any = red.node.advertise("/clock", Clock)
    base.node.master.set_param("/use_sim_time", True)
    base.has_topic("/clock")
    follower = base.make_node("follower")
    wait_for_subscribers(clock)

    simulated = type(follower.now())(1234, 5)

    def follows() -> bool:
        clock.publish(Clock(simulated))
        return follower.now() == simulated

    wait_until(follows, "the clock at the base")
