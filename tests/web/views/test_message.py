"""The latest message of a topic, as a tree."""

from __future__ import annotations

import queue
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import Pose as PoseMessage
from pyros1.msgs.geometry_msgs.msg import PoseArray, Quaternion
from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.msgs.std_msgs.msg import Int64, String, UInt8MultiArray
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.message import tree


def field(value: Any, name: str) -> Any:
    return next(inner for each, _, inner in value["fields"] if each == name)


def test_long_arrays_are_shown_in_pieces() -> None:
    scan = LaserScan(ranges=[float(x) for x in range(720)])
    first = field(tree(scan), "ranges")
    assert (first["length"], first["start"], first["items"][:2], len(first["items"])) == (720, 0, [0.0, 1.0], 64)
    later = field(tree(scan, {"ranges": 700}), "ranges")
    assert (later["start"], later["items"][0], len(later["items"])) == (700, 700.0, 20)
    assert field(tree(scan, {"ranges": 10**6}), "ranges")["start"] == 719


def test_arrays_within_arrays_have_windows_of_their_own() -> None:
    poses = PoseArray(poses=[PoseMessage(orientation=Quaternion(w=float(x))) for x in range(100)])
    shown = field(tree(poses, {"poses": 98}), "poses")
    assert field(field(shown["items"][1], "orientation"), "w") == 99.0


def test_values_that_json_has_not() -> None:
    scan = LaserScan(range_max=float("inf"), angle_min=float("nan"))
    scan.header.stamp = Time(3, 4)
    shown = tree(scan)
    assert (field(shown, "range_max"), field(shown, "angle_min")) == ("inf", "nan")
    assert field(field(shown, "header"), "stamp") == {"secs": 3, "nsecs": 4}
    assert field(tree(Int64(2**60)), "data") == str(2**60)
    assert field(tree(UInt8MultiArray(data=b"\1\2")), "data")["items"] == [1, 2]


def test_huge_messages_are_cut() -> None:
    deep = PoseArray(poses=[PoseMessage()] * 5_000)
    assert str(tree(deep)).count("'x'") < 200
    text = field(tree(String("x" * 100_000)), "data")
    assert len(text) < 3_000 and text.endswith("...")


def test_a_frozen_view_stays_with_its_message(
    make_node: Callable[..., Any], watch: Callable[..., Any], robot: Robot
) -> None:
    watched = watch("message", topic="/scan")
    came: queue.SimpleQueue[Any] = queue.SimpleQueue()
    end = robot.listen("/scan", came.put)  # it is called after the view
    publisher = make_node("laser").advertise("/scan", LaserScan)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(LaserScan(scan_time=1.0, ranges=[1.0] * 100))
    first = watched.until(lambda data: data["count"] == 1)
    assert first["type"] == "sensor_msgs/LaserScan" and first["publisher"] == "/laser" and not first["latched"]
    watched.view.change({"topic": "/scan", "frozen": True})
    publisher.publish(LaserScan(scan_time=2.0, ranges=[2.0] * 100))
    assert [came.get(timeout=20).message.scan_time for _ in range(2)] == [1.0, 2.0]
    again = watched.until(lambda _: True)
    assert again["count"] == 2 and field(again["value"], "scan_time") == 1.0
    assert again["age"] > first["age"] > 0.0  # of the message that is shown
    assert watched.view.poll() is None
    watched.view.change({"topic": "/scan", "frozen": True, "windows": {"ranges": 99}})
    assert field(watched.until(lambda _: True)["value"], "ranges")["items"] == [1.0]
    watched.view.change({"topic": "/scan"})
    assert field(watched.until(lambda _: True)["value"], "scan_time") == 2.0
    end()


@pytest.mark.parametrize(
    "args", [{"topic": "/other"}, {"topic": "/t", "windows": []}, {"topic": "/t", "windows": {"a": -1}}, {}]
)
def test_wrong_arguments(watch: Callable[..., Any], args: dict[str, Any]) -> None:
    with pytest.raises(RequestError):
        watch("message", topic="/t").view.change(args)
