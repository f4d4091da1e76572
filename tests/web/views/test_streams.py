"""Views of pictures and of the log."""

from __future__ import annotations

import struct
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image
from pyros1.msgs.std_msgs.msg import String
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.image import ImageView

PNG = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sII", 13, b"IHDR", 100_000, 100_000) + bytes(9)
JPEG = b"\xff\xd8\xff\xc0\x00\x11\x08" + struct.pack(">HH", 65_500, 65_500) + bytes(9)


@pytest.mark.parametrize("data", [PNG, JPEG, bytes(12) + PNG], ids=["PNG", "JPEG", "depth"])
def test_pictures_that_would_unpack_to_too_much_are_not_sent(
    watch: Callable[..., Any], make_node: Callable[..., Any], data: bytes
) -> None:
    make_node("bomber").advertise("/bomb", CompressedImage, latch=True).publish(format="png", data=data)
    with pytest.raises(RequestError, match="too large"):
        watch("image", topic="/bomb").until(lambda facts: True)


def test_the_rate_of_pictures_is_that_of_now(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    """A camera that was off for an hour has its rate soon."""
    now = 1000.0
    monkeypatch.setattr("pyros1.web.views.image.monotonic", lambda: now)
    arrived: list[Callable[[Any], object]] = []
    stands_for_it = SimpleNamespace(listen=lambda topic, listener: arrived.append(listener) or (lambda: None))
    view = ImageView(stands_for_it, {"topic": "/camera"}, lambda: None)  # type: ignore[arg-type]
    message = Image(height=1, width=1, step=1, encoding="mono8", data=b"x")
    rates = []
    for start in (1000.0, 4600.0):
        for number in range(50):
            now = start + number / 10
            raw = SimpleNamespace(_buff=b"", _connection_header={"type": "sensor_msgs/Image"})
            arrived[0](SimpleNamespace(raw=raw, checked_message=message, arrived_at=now))
        push = view.poll()
        assert push is not None
        rates.append(round(push.data["hz"], 6))
    assert rates == [10.0, 10.0]


def test_the_log_names_no_topics_that_pages_may_not_see(
    watch: Callable[..., Any], make_robot: Callable[..., Robot]
) -> None:
    robot = make_robot(topics=("/rosout", "/camera/*"))
    robot.console.add(Log(name="/node", msg="hello", topics=["/camera/image", "/secret"]))
    (entry,) = watch("console", robot, after=0, run="").until(lambda data: data["entries"])["entries"]
    assert entry.topics == ["/camera/image"]


def test_a_page_of_an_earlier_run_gets_the_whole_log(watch: Callable[..., Any], robot: Robot) -> None:
    for text in ("one", "two"):
        robot.console.add(Log(name="/node", level=2, msg=text))
    run = watch("console", after=0, run="").until(lambda data: len(data["entries"]) == 2)["run"]
    assert run == robot.console.run_id
    data = watch("console", after=1, run=run).until(lambda data: data["entries"])
    assert [entry.text for entry in data["entries"]] == ["two"]
    data = watch("console", after=1, run="of yesterday").until(lambda data: data["entries"])
    assert [entry.text for entry in data["entries"]] == ["one", "two"]


def test_what_a_curve_waits_for_is_no_problem(watch: Callable[..., Any], make_node: Callable[..., Any]) -> None:
    plot = watch("plot", curves=[{"id": 1, "text": "/words/data"}, {"id": 2, "text": "/late: 1 + m.data"}])
    data = plot.until(lambda data: data["waiting"])
    assert data["waiting"] == {1: "no such topic yet", 2: "no such topic yet"} and not data["problems"]
    publisher = make_node("talker").advertise("/words", String)
    waiting = {1: "no message yet", 2: "no such topic yet"}
    plot.until(lambda data: data["waiting"] == waiting)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish("hello")
    data = plot.until(lambda data: data["waiting"] == {2: "no such topic yet"})
    assert data["problems"] == {1: "not a number, but a string"}


def test_what_is_wrong_with_transforms_is_told_until_it_is_right(
    watch: Callable[..., Any], make_node: Callable[..., Any]
) -> None:
    watched = watch("frames")
    node = make_node("robot")
    node.advertise("/tf_static", "std_msgs/Float64", latch=True).publish(1.0)
    watched.until(lambda data: "/robot publishes something other" in data["problem"])
    node.shutdown()
    message = TFMessage(transforms=[TransformStamped(child_frame_id="base")])
    make_node("robot").advertise("/tf_static", TFMessage, latch=True).publish(message)
    watched.until(lambda data: data["frames"] and not data["problem"])


def test_what_cannot_be_drawn_in_a_scene_is_told(watch: Callable[..., Any], make_node: Callable[..., Any]) -> None:
    make_node("talker").advertise("/words", String, latch=True).publish("hello")
    with pytest.raises(RequestError, match="std_msgs/String cannot be drawn"):
        watch("scene_topic", topic="/words", fixed="map").until(lambda facts: True)
