"""The views of cameras: pictures and depths with what has seen them."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.msgs.std_msgs.msg import String
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.server.wire import RequestError

from ...bodies import encode

pytestmark = pytest.mark.once

Make = Callable[..., Any]
PATIENCE = 20.0


def camera_info(width: int = 2) -> CameraInfo:
    return CameraInfo(width=width, height=1, P=[1.0, 0, 0.5, 0, 0, 1.0, 0, 0, 0, 0, 1, 0])


def picture(encoding: str, data: bytes) -> Image:
    image = Image(width=2, height=1, encoding=encoding, step=len(data), data=data)
    image.header.frame_id = "optical"
    return image


def link() -> TransformStamped:
    message = TransformStamped(child_frame_id="optical")
    message.header.frame_id, message.transform.translation.x, message.transform.rotation.w = "map", 2.0, 1.0
    return message


def test_a_picture_with_its_camera(make_node: Make, watch: Make) -> None:
    node = make_node("camera")
    node.advertise("/cam/image", Image, latch=True).publish(picture("rgb8", b"abcdef"))
    watched = watch("scene_camera", topic="/cam/image", fixed="map")
    first = watched.until(lambda data: data["type"] == "sensor_msgs/Image")
    assert (first["camera"], first["why"]) == (None, "no CameraInfo has been received on /cam/camera_info")
    info = node.advertise("/cam/camera_info", CameraInfo, latch=True)
    info.publish(camera_info())
    seen = watched.until(lambda data: data["camera"])
    assert (seen["camera"]["fx"], seen["camera"]["width"], seen["why"], seen["pose"]) == (1.0, 2, "", None)
    assert watched.view.polls_periodically
    StaticTransformBroadcaster(node).send_transform([link()])
    assert watched.until(lambda data: data["pose"])["pose"][0] == 2.0
    info.publish(camera_info())  # the same again is nothing new
    info.publish(camera_info(9))
    assert watched.until(lambda data: True)["camera"]["width"] == 9


def test_a_camera_info_elsewhere(make_node: Make, watch: Make) -> None:
    node = make_node("camera")
    node.advertise("/cam/image", Image, latch=True).publish(picture("rgb8", b"abcdef"))
    node.advertise("/other", CameraInfo, latch=True).publish(camera_info())
    node.advertise("/wrong", String, latch=True).publish(String("x"))
    node.advertise("/raw", CameraInfo, latch=True).publish(CameraInfo())
    watched = watch("scene_camera", topic="/cam/image", info="/other")
    watched.until(lambda data: data["camera"])
    for topic, why in [
        ("/wrong", "the type of /wrong is not sensor_msgs/CameraInfo, but std_msgs/String"),
        ("/raw", "not calibrated"),
    ]:
        watched.view.change({"topic": "/cam/image", "info": topic})
        assert watched.until(lambda data, why=why: why in data["why"])["camera"] is None


def test_depths_with_colours(make_node: Make, watch: Make) -> None:
    node = make_node("camera")
    depth = picture("16UC1", np.array([1000, 2000], "<u2").tobytes())
    node.advertise("/cam/depth", Image, latch=True).publish(depth)
    watched = watch("scene_depth", topic="/cam/depth", fixed="optical", colour="/cam/rgb")
    with pytest.raises(RequestError, match="no CameraInfo has been received on /cam/camera_info"):
        watched.until(lambda data: False)
    node.advertise("/cam/camera_info", CameraInfo, latch=True).publish(camera_info())
    grey = watched.until(lambda data: data["kind"] == "cloud")
    assert (grey["count"], grey["colour"], grey["pose"][:3]) == (2, "z", [0, 0, 0])
    node.advertise("/cam/rgb", Image, latch=True).publish(picture("rgb8", b"abcdef"))
    assert watched.until(lambda data: data["colour"] == "rgb")["count"] == 2
    watched.view.change({"topic": "/cam/depth", "fixed": "optical", "most": 1})
    assert watched.until(lambda data: True) | {"stamp": 0} == grey | {"count": 1, "every": 4, "most": 1.0, "stamp": 0}
    with pytest.raises(RequestError, match="most must be a number"):
        watched.view.change({"topic": "/cam/depth", "most": 0})


def test_of_the_colours_those_that_were_seen_with_the_depths(make_node: Make, watch: Make) -> None:
    node = make_node("camera")
    node.advertise("/cam/camera_info", CameraInfo, latch=True).publish(camera_info())
    colours = node.advertise("/cam/rgb", Image)
    watched = watch("scene_depth", topic="/cam/depth", fixed="optical", colour="/cam/rgb")
    assert colours.wait_for_subscribers(timeout=PATIENCE)
    for second, data in [*((0, b"------") for _ in range(9)), (1, b"aaaaaa"), (2, b"bbbbbb"), (3, b"cccccc")]:
        image = picture("rgb8", data)
        image.header.stamp.secs = second
        colours.publish(image)
    depth = picture("16UC1", np.array([1000, 2000], "<u2").tobytes())
    depth.header.stamp.secs = 2
    depths = node.advertise("/cam/depth", Image, latch=True)

    depths.publish(depth)

    deadline, blob = time.monotonic() + PATIENCE, b""
    while not blob.endswith(b"bbb\0bbb\0"):  # messages of different topics come when they come
        assert time.monotonic() < deadline, blob
        watched.view.change({"topic": "/cam/depth", "fixed": "optical", "colour": "/cam/rgb"})
        with suppress(RequestError):
            push = watched.view.poll()
            blob = push.blob if push else b""


@pytest.mark.slow
@pytest.mark.parametrize(("room", "nearest"), [(0, b"ccc"), (1.9, b"ccc"), (2, b"bbb"), (2.9, b"bbb"), (3, b"aaa")])
def test_as_many_colours_are_kept_as_there_is_room_for(
    make_node: Make, watch: Make, monkeypatch: pytest.MonkeyPatch, room: float, nearest: bytes
) -> None:
    colour = picture("rgb8", b"aaaaaa")
    monkeypatch.setattr("pyros1.web.views.scene.depth.MAX_IMAGE_BYTES", int(room * len(encode(colour))))
    node = make_node("camera")
    node.advertise("/cam/camera_info", CameraInfo, latch=True).publish(camera_info())
    colours, depths = node.advertise("/cam/rgb", Image), node.advertise("/cam/depth", Image, latch=True)
    watched = watch("scene_depth", topic="/cam/depth", fixed="optical", colour="/cam/rgb")
    assert colours.wait_for_subscribers(timeout=PATIENCE)
    for colour.header.stamp.secs, colour.data in [(1, b"aaaaaa"), (2, b"bbbbbb"), (3, b"cccccc")]:
        colours.publish(colour)
    depth = picture("16UC1", np.array([1000, 2000], "<u2").tobytes())

    def points(second: int, end: bytes) -> bytes:
        """Return the points of the depths of a time, with the end of their colours, when these have it."""
        depth.header.stamp.secs = second
        depths.publish(depth)
        deadline, blob, stamp = time.monotonic() + PATIENCE, b"", 0.0
        while stamp != second or not blob.endswith(end):
            assert time.monotonic() < deadline, (stamp, blob)
            watched.view.change({"topic": "/cam/depth", "fixed": "optical", "colour": "/cam/rgb"})
            with suppress(RequestError):
                push = watched.view.poll()
                stamp, blob = (push.data["stamp"], push.blob) if push else (0.0, b"")
        return blob

    points(3, b"ccc\0ccc\0")  # all colours have come
    assert points(1, b"\0").endswith(nearest + b"\0")


def test_topics_of_something_else(make_node: Make, watch: Make) -> None:
    make_node("talker").advertise("/words", String, latch=True).publish(String("x"))
    for view in ("scene_camera", "scene_depth"):
        watched = watch(view, topic="/words")
        with pytest.raises(RequestError, match="this is not an image topic, its type is std_msgs/String"):
            watched.until(lambda data: False)
