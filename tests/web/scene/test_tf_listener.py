"""Frames over time for the scenes of all pages."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from pyros1 import Time
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.web.scene import tf_listener as module
from pyros1.web.scene.tf_listener import IDENTITY_POSE, TfListener
from pyros1.web.server.wire import RequestError


class Topics:
    """Stands for the robot: transforms are sent by the test."""

    def __init__(self) -> None:
        self.listeners: dict[str, Callable[[Any], object]] = {}

    def listen(self, topic: str, listener: Callable[[Any], object]) -> Callable[[], None]:
        assert topic not in self.listeners
        self.listeners[topic] = listener
        return lambda: self.listeners.__delitem__(topic)

    def send(
        self, *transforms: TransformStamped, static: bool = False, publisher: str = "/p", now: float = 0.0
    ) -> None:
        class Raw:
            _connection_header = {"callerid": publisher}

        class Message:
            pass

        class Arrival:
            raw = Raw()
            message = Message()
            time = now

        Arrival.message.transforms = list(transforms)  # type: ignore[attr-defined]
        self.listeners["/tf_static" if static else "/tf"](Arrival())


def transform(parent: str, child: str, x: float, stamp: float = 1.0, yaw: float = 0.0) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id, message.header.stamp = parent, Time.from_sec(stamp)
    message.transform.translation.x = x
    message.transform.rotation.z, message.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return message


@pytest.fixture
def topics() -> Topics:
    return Topics()


@pytest.fixture
def tf_listener(topics: Topics) -> TfListener:
    return TfListener(topics.listen)


def test_poses(topics: Topics, tf_listener: TfListener) -> None:
    heard: list[int] = []
    end = tf_listener.watch(lambda: heard.append(1))
    topics.send(transform("map", "base", 2.0, yaw=math.pi / 2))
    topics.send(transform("base", "laser", 1.0), static=True)
    pose = tf_listener.pose("map", "laser")
    assert pose is not None
    assert pose[:3] == pytest.approx([2.0, 1.0, 0.0])
    assert tf_listener.pose("/map", "/map") == IDENTITY_POSE
    assert tf_listener.pose("map", "elsewhere") is None
    assert len(heard) == 2
    end()


@pytest.mark.parametrize("x", [math.inf, math.nan, 1e308])
def test_a_frame_that_is_nowhere(topics: Topics, tf_listener: TfListener, x: float) -> None:
    tf_listener.watch(lambda: None)
    topics.send(transform("map", "base", x), transform("base", "hand", x, yaw=1.0))
    assert tf_listener.pose("map", "hand") is None  # no numbers that JSON lacks


def test_a_time_that_is_not_in_the_buffer_gives_the_latest(topics: Topics, tf_listener: TfListener) -> None:
    tf_listener.watch(lambda: None)
    topics.send(transform("map", "base", 1.0, stamp=1.0))
    topics.send(transform("map", "base", 3.0, stamp=2.0))
    assert [tf_listener.pose("map", "base", Time.from_sec(at))[0] for at in (1.5, 9.0)] == [2.0, 3.0]  # type: ignore[index]


def test_it_listens_only_while_somebody_looks(topics: Topics, tf_listener: TfListener) -> None:
    ends = [tf_listener.watch(lambda: None) for _ in range(2)]
    topics.send(transform("map", "base", 1.0))
    ends[0]()
    ends[0]()
    assert topics.listeners
    ends[1]()
    assert not topics.listeners
    tf_listener.watch(lambda: None)
    assert tf_listener.pose("map", "base") is None  # what was known may be old


def test_who_may_not_see_static_frames_leaves_nothing_behind(topics: Topics) -> None:
    def listen(topic: str, listener: Callable[[Any], object]) -> Callable[[], None]:
        if topic == "/tf_static":
            raise RequestError("not shown")
        return topics.listen(topic, listener)

    tf_listener = TfListener(listen)
    for _ in range(2):  # the page tries again
        with pytest.raises(RequestError):
            tf_listener.watch(lambda: None)
        assert not topics.listeners


def test_a_bag_that_begins_again(topics: Topics, tf_listener: TfListener) -> None:
    tf_listener.watch(lambda: None)
    topics.send(transform("base", "laser", 1.0), static=True)
    topics.send(transform("map", "base", 1.0, stamp=100.0))
    topics.send(transform("map", "base", 7.0, stamp=10.0))
    pose = tf_listener.pose("map", "laser")
    assert pose is not None
    assert pose[0] == 8.0
    topics.send(transform("tf_listener", "map", 0.0, stamp=0.5), publisher="/another")  # with a clock of its own
    assert tf_listener.pose("map", "base") is not None


def test_a_short_bag_that_begins_again_with_its_clock(topics: Topics, tf_listener: TfListener) -> None:
    tf_listener.watch(lambda: None)
    for stamp in (1.0, 2.0, 3.0):
        topics.send(transform("map", "base", stamp, stamp=stamp), now=stamp)
    topics.send(transform("map", "base", 1.0, stamp=1.0), now=1.0)
    assert tf_listener.pose("map", "base")[0] == 1.0  # type: ignore[index]  # else it stood still for two seconds
    topics.send(transform("base", "laser", 1.0, stamp=1.0), now=0.99)  # from another thread
    assert tf_listener.pose("map", "laser") is not None


def test_the_number_of_frames_is_bounded(
    topics: Topics, tf_listener: TfListener, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "MAX_FRAMES", 10)
    tf_listener.watch(lambda: None)
    for number in range(30):
        topics.send(transform("map", f"f{number}", float(number)))
    assert len(tf_listener.buffer.frames()) <= 12
    topics.send(transform("map", "f0", 5.0, stamp=2.0))
    assert tf_listener.pose("map", "f0", None)[0] == 5.0  # type: ignore[index]
