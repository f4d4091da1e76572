"""The views behind the 3D scene."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.msgs import AnyMsg, from_definition
from pyros1.msgs.geometry_msgs.msg import PoseStamped, TransformStamped
from pyros1.msgs.map_msgs.msg import OccupancyGridUpdate
from pyros1.msgs.nav_msgs.msg import OccupancyGrid
from pyros1.msgs.sensor_msgs.msg import PointCloud2, PointField
from pyros1.msgs.visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerInit,
    InteractiveMarkerUpdate,
    Marker,
    MarkerArray,
)
from pyros1.node.topic_type import topic_type
from pyros1.tf import StaticTransformBroadcaster
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.scene.frames import find_roots

PATIENCE = 20.0
Make = Callable[..., Any]


def test_a_parameter_that_is_a_text(make_node: Make, watch: Make) -> None:
    master = make_node("setter").master
    watched = watch("param", param="/robot_description")
    watched.until(lambda data: data == {"text": None, "why": "there is no parameter /robot_description"})
    master.set_param("/robot_description", "<robot/>")
    watched.until(lambda data: data == {"text": "<robot/>"})
    assert watched.view.poll() is None
    master.set_param("/robot_description", {"a": 1})
    watched.until(lambda data: data["why"] == "/robot_description is not a string")
    watched.view.change({"param": "/other"})
    watched.until(lambda data: "/other" in data["why"])


def test_a_parameter_that_pages_may_not_see(make_robot: Make, watch: Make) -> None:
    narrow = make_robot(topics=("/camera/*",))
    with pytest.raises(RequestError, match="this server does not show"):
        watch("param", narrow, param="/robot_description")


def test_a_message_comes_again_when_there_is_a_way_to_its_frame(make_node: Make, watch: Make) -> None:
    node = make_node("robot")
    message = PoseStamped()
    message.header.frame_id = "base"
    node.advertise("/pose", PoseStamped, latch=True).publish(message)
    watched = watch("scene_topic", topic="/pose", fixed="map")
    assert watched.until(lambda data: data["kind"] == "poses")["pose"] is None
    assert watched.view.polls_periodically
    assert watched.view.poll() is None
    link = TransformStamped(child_frame_id="base")
    link.header.frame_id, link.transform.translation.x, link.transform.rotation.w = "map", 2.0, 1.0
    StaticTransformBroadcaster(node).send_transform([link])
    assert watched.until(lambda data: data["pose"] is not None)["pose"][0] == 2.0
    assert not watched.view.polls_periodically


@pytest.mark.parametrize(
    ("parents", "roots"),
    [
        ({}, {}),
        ({"odom": "map", "base": "odom", "cup": ""}, {"odom": "map", "base": "map", "map": "map", "cup": "cup"}),
        ({"a": "b", "b": "c", "c": "a", "lost": "a", "one": ""}, {"one": "one"}),
    ],
)
def test_roots_of_frames(parents: dict[str, str], roots: dict[str, str]) -> None:
    assert find_roots(parents) == roots


def test_what_stands_still_is_the_chosen_frame_or_the_robots_root_or_that_of_the_largest_tree(
    make_node: Make, watch: Make
) -> None:
    pairs = [("world", "table"), ("table", "lamp"), ("base", "arm")]
    links = [TransformStamped(child_frame_id=child) for _, child in pairs]
    for link, (parent, _) in zip(links, pairs, strict=True):
        link.header.frame_id, link.transform.rotation.w = parent, 1.0
    StaticTransformBroadcaster(make_node("robot")).send_transform(links)
    for args, fixed, lost in [
        ({}, "world", ["base", "arm"]),
        ({"robot": "arm"}, "base", ["world", "table", "lamp"]),
        ({"robot": "nothing"}, "world", ["base", "arm"]),
        ({"fixed": "nowhere", "robot": "arm"}, "nowhere", ["world", "table", "lamp", "base", "arm"]),
    ]:
        data = watch("scene_frames", **args).until(lambda data: len(data["names"]) + len(data["lost"]) == 5)
        assert (data["fixed"], sorted(data["lost"])) == (fixed, sorted(lost))
        assert data["trees"] == [("world", 3), ("base", 2)]


def test_a_map_and_what_changes_in_it(make_node: Make, watch: Make) -> None:
    node = make_node("mapper")
    grid = OccupancyGrid(data=[0] * 6)
    grid.info.resolution = 1.0
    grid.info.width, grid.info.height = 3, 2
    grid.header.frame_id = "map"
    updates = node.advertise("/map_updates", OccupancyGridUpdate)
    node.advertise("/map", OccupancyGrid, latch=True).publish(grid)
    watched = watch("scene_topic", topic="/map", fixed="map")
    watched.until(lambda data: data["kind"] == "map" and data["width"] == 3)
    assert updates.wait_for_subscribers(timeout=PATIENCE)
    updates.publish(OccupancyGridUpdate(x=1, y=1, width=2, height=1, data=[100, -1]))
    part = watched.until(lambda data: data["kind"] == "patch")
    assert (part["x"], part["y"], part["width"], part["height"]) == (1, 1, 2, 1)
    watched.view.change({"topic": "/map", "fixed": "map"})
    push = watched.view.poll()
    assert (push.data["kind"], [*push.blob]) == ("map", [0, 0, 0, 0, 100, 255])
    updates.publish(OccupancyGridUpdate(x=5, width=1, height=1, data=[1]))
    with pytest.raises(RequestError, match="exceeds the map"):
        watched.until(lambda data: False)


def test_a_map_whose_frame_comes_late_has_what_changed_meanwhile(
    make_node: Make, watch: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.web.views.scene.topic.MAX_UPDATES", 2)
    node = make_node("mapper")
    grid = OccupancyGrid(data=[0] * 8)
    grid.info.resolution = 1.0
    grid.info.width, grid.info.height = 8, 1
    grid.header.frame_id = "map"
    updates = node.advertise("/map_updates", OccupancyGridUpdate, queue_size=100)
    node.advertise("/map", OccupancyGrid, latch=True).publish(grid)
    watched = watch("scene_topic", topic="/map", fixed="world")
    assert watched.until(lambda data: data["kind"] == "map")["pose"] is None
    has_data: queue.SimpleQueue[Any] = queue.SimpleQueue()
    end = watched.view.robot.listen("/map_updates", has_data.put)  # it is called after the view
    assert updates.wait_for_subscribers(timeout=PATIENCE)
    for x in range(7):
        updates.publish(OccupancyGridUpdate(x=x, width=1, height=1, data=[x + 1]))
        has_data.get(timeout=PATIENCE)
        assert watched.view.poll() is None
    link = TransformStamped(child_frame_id="map")
    link.header.frame_id, link.transform.rotation.w = "world", 1.0
    StaticTransformBroadcaster(node).send_transform([link])
    deadline = time.monotonic() + PATIENCE
    while (push := watched.view.poll()) is None or push.data["pose"] is None:
        assert time.monotonic() < deadline
    assert [*push.blob] == [1, 2, 3, 4, 5, 6, 7, 0]
    end()


def test_a_map_that_changes_faster_than_a_page_takes_it_loses_nothing(
    make_node: Make, watch: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.web.views.scene.topic.MAX_UPDATES", 2)
    node = make_node("mapper")
    grid = OccupancyGrid(data=[0] * 8)
    grid.info.resolution = 1.0
    grid.info.width, grid.info.height = 8, 1
    grid.header.frame_id = "map"
    updates = node.advertise("/map_updates", OccupancyGridUpdate, queue_size=100)
    node.advertise("/map", OccupancyGrid, latch=True).publish(grid)
    watched = watch("scene_topic", topic="/map", fixed="map")
    watched.until(lambda data: data["kind"] == "map")
    has_data: queue.SimpleQueue[Any] = queue.SimpleQueue()
    end = watched.view.robot.listen("/map_updates", has_data.put)
    assert updates.wait_for_subscribers(timeout=PATIENCE)
    for x in (0, 1, 9, 2, 3, 4, 5, 6):  # one of them does not fit
        updates.publish(OccupancyGridUpdate(x=x, width=1, height=1, data=[x + 1]))
        has_data.get(timeout=PATIENCE)
    with pytest.raises(RequestError, match="exceeds the map"):
        watched.view.poll()
    push = watched.view.poll()
    assert (push.data["x"], push.data["width"], [*push.blob]) == (0, 7, [1, 2, 3, 4, 5, 6, 7])
    end()


def test_a_map_whose_changes_pages_may_not_see(make_node: Make, watch: Make, make_robot: Make) -> None:
    narrow = make_robot(topics=("/map", "/tf", "/tf_static"))
    grid = OccupancyGrid(data=[0])
    grid.info.resolution = 1.0
    grid.info.width = grid.info.height = 1
    make_node("mapper").advertise("/map", OccupancyGrid, latch=True).publish(grid)
    watch("scene_topic", narrow, topic="/map", fixed="map").until(lambda data: data["kind"] == "map")


def test_markers_come_again_when_there_is_a_way_to_their_frame(make_node: Make, watch: Make) -> None:
    node = make_node("robot")
    marker = Marker(ns="n", id=1)
    marker.header.frame_id = "base"
    publisher = node.advertise("/markers", MarkerArray, latch=True)
    publisher.publish(MarkerArray(markers=[marker]))
    watched = watch("scene_topic", topic="/markers", fixed="map")
    first = watched.until(lambda data: data["new"])
    assert first["poses"] == {"base": None} and watched.view.polls_periodically
    assert watched.view.poll() is None
    other, gone = Marker(ns="n", id=2), Marker(ns="n", id=3)
    other.header.frame_id, gone.header.frame_id = "map", "nowhere"
    publisher.publish(MarkerArray(markers=[other, gone]))
    assert {*watched.until(lambda data: len(data["new"]) == 2)["poses"]} == {"map", "base", "nowhere"}
    gone.action = 2
    publisher.publish(MarkerArray(markers=[gone]))
    assert watched.until(lambda data: data["gone"])["poses"] == {"base": None}
    link = TransformStamped(child_frame_id="base")
    link.header.frame_id, link.transform.translation.x, link.transform.rotation.w = "map", 2.0, 1.0
    StaticTransformBroadcaster(node).send_transform([link])
    again = watched.until(lambda data: data["poses"]["base"] is not None)
    assert again["all"] and again["poses"]["base"][0] == 2.0 and [each["id"] for each in again["new"]] == [1, 2]
    assert watched.view.poll() is None


def test_a_topic_whose_type_changes_while_it_is_shown(make_node: Make, watch: Make) -> None:
    view = watch("scene_topic", topic="/thing", fixed="map").view
    has_data: queue.SimpleQueue[Any] = queue.SimpleQueue()
    end = view.robot.listen("/thing", has_data.put)  # it is called after the view
    marker = Marker(ns="n", id=1)
    marker.header.frame_id = "map"
    pose = PoseStamped()
    pose.header.frame_id = "map"
    for kind, message, raw_type, shown in (
        (MarkerArray, MarkerArray(), None, None),  # an empty one is no marker, and no fault
        (AnyMsg, AnyMsg(b"cut off"), topic_type(Marker), "a fault"),
        (Marker, marker, None, "markers"),
        (PoseStamped, pose, None, "poses"),
        (Marker, marker, None, "markers"),
    ):
        node = make_node("robot")
        node.advertise("/thing", kind, latch=True, raw_type=raw_type).publish(message)
        has_data.get(timeout=PATIENCE)
        if shown == "a fault":
            with pytest.raises(RequestError, match="cannot decode"):
                view.poll()
        else:
            push = view.poll()
            assert (push and push.data["kind"]) == shown
            assert shown != "markers" or (push.data["all"] and len(push.data["new"]) == 1)
        node.shutdown()
    end()


def test_an_array_without_markers(make_node: Make, watch: Make, capfd: pytest.CaptureFixture[str]) -> None:
    arrays = make_node("robot").advertise("/markers", MarkerArray, latch=True)
    arrays.publish(MarkerArray())
    watched = watch("scene_topic", topic="/markers", fixed="map")
    assert arrays.wait_for_subscribers(timeout=PATIENCE)
    arrays.publish(MarkerArray(markers=[Marker(id=7)]))
    watched.until(lambda data: [each["id"] for each in data["new"]] == [7])
    assert capfd.readouterr().err == ""


def test_markers_of_another_definition_are_told(
    make_node: Make, watch: Make, capfd: pytest.CaptureFixture[str]
) -> None:
    other = from_definition("visualization_msgs/Marker", Marker._full_text.replace("int32 id", "string[] id"))
    make_node("robot").advertise("/markers", other, latch=True).publish(other())
    watched = watch("scene_topic", topic="/markers", fixed="map")
    with pytest.raises(RequestError, match="a different definition of visualization_msgs/Marker"):
        watched.until(lambda data: False)
    assert capfd.readouterr().err == ""


def test_a_cloud_by_a_field_of_ones_choice(make_node: Make, watch: Make, robot: Robot) -> None:
    fields = [PointField(name, 4 * index, 7, 1) for index, name in enumerate(("x", "y", "z", "heat"))]
    cloud = PointCloud2(height=1, width=4, fields=fields, point_step=16, row_step=64, data=bytes(64))
    cloud.header.frame_id = "map"
    make_node("camera").advertise("/cloud", PointCloud2, latch=True).publish(cloud)
    watched = watch("scene_topic", topic="/cloud", fixed="map")
    assert watched.until(lambda data: data["kind"] == "cloud")["by"] == "z"
    watched.view.change({"topic": "/cloud", "fixed": "map", "by": "heat", "most": 2})
    assert watched.until(lambda data: data["by"] == "heat")["every"] == 2
    with pytest.raises(RequestError, match="most must be a number"):
        watched.view.change({"topic": "/cloud", "most": 0})


def test_interactive_markers(make_node: Make, watch: Make) -> None:
    node = make_node("server")
    full = node.advertise("/controls/update_full", InteractiveMarkerInit, latch=True)
    updates = node.advertise("/controls/update", InteractiveMarkerUpdate)
    full.publish(InteractiveMarkerInit(server_id="s", seq_num=1, markers=[InteractiveMarker(name="a")]))
    watched = watch("scene_interactive", topic="/controls/update")
    seen: list[str] = []
    watched.until(lambda data: seen.extend(each["name"] for each in data["new"]) or seen == ["a"])
    assert updates.wait_for_subscribers(timeout=PATIENCE)
    updates.publish(InteractiveMarkerUpdate(server_id="s", seq_num=2, type=1, erases=["a"]))
    watched.until(lambda data: data["gone"] == [["s", "a"]])


def test_interactive_markers_whose_update_was_missed_are_asked_for_again(
    make_node: Make, watch: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.web.views.scene.interactive.RESUBSCRIBE_PERIOD", 0.0)
    node = make_node("server")
    full = node.advertise("/controls/update_full", InteractiveMarkerInit, latch=True)
    updates = node.advertise("/controls/update", InteractiveMarkerUpdate)
    watched = watch("scene_interactive", topic="/controls/update")
    assert full.wait_for_subscribers(timeout=PATIENCE)
    assert updates.wait_for_subscribers(timeout=PATIENCE)
    updates.publish(InteractiveMarkerUpdate(server_id="s", seq_num=7, type=0))
    full.publish(InteractiveMarkerInit(server_id="s", seq_num=7, markers=[InteractiveMarker(name="b")]))
    watched.until(lambda data: [each["name"] for each in data["new"]] == ["b"])


def test_a_topic_of_something_else_says_so(make_node: Make, watch: Make) -> None:
    make_node("robot").advertise("/pose/update", PoseStamped, latch=True).publish(PoseStamped())
    with pytest.raises(RequestError, match="is not that of interactive markers, but geometry_msgs/PoseStamped"):
        watch("scene_interactive", topic="/pose/update").until(lambda data: False)
