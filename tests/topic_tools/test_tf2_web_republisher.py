"""tf2_web_republisher: pages get the frames that they name, when these move.

Feature: ros3djs pages, with frames from `pyros1 run tf2_web_republisher tf2_web_republisher`
"""

from __future__ import annotations

import math
import queue
from collections.abc import Callable
from time import monotonic
from typing import Any

import pytest

from pyros1.actions import Client, GoalError, Status
from pyros1.ground.errors import ServiceError
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.tf2_web_republisher.msg import TFArray, TFSubscriptionAction, TFSubscriptionGoal
from pyros1.msgs.tf2_web_republisher.srv import RepublishTFs
from pyros1.tf import Buffer, TransformBroadcaster
from pyros1.topic_tools.tf2_web_republisher import MAX_FRAMES, MovedFrames, Republisher

MakeNode = Callable[..., Any]
PATIENCE = 20


def frame(x: float, yaw: float = 0.0, child: str = "base", seconds: int = 1) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = "map"
    message.header.stamp.secs = seconds
    message.transform.translation.x = x
    message.transform.rotation.z, message.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return message


def test_only_what_moved_is_told() -> None:
    buffer = Buffer()
    moves = MovedFrames(buffer, "/map", ["/base", "arm", "base"], 0.1, 0.5)
    assert moves.find_moved() == []
    steps = [(0.0, 0.0, 1), (0.4, 0.05, 0), (0.6, 0.05, 1), (0.6, 0.2, 1), (0.6, 0.2, 0), (0.6, 0.2 + math.tau, 0)]
    for seconds, (x, yaw, count) in enumerate(steps, 1):
        buffer.set_transform(frame(x, yaw, seconds=seconds))
        found: Any = moves.find_moved()
        assert [each.child_frame_id for each in found] == ["base"] * count, (x, yaw)
        assert all(each.header.frame_id == "map" and each.transform.translation.x == x for each in found)
    buffer.set_transform(frame(3.0, child="arm", seconds=9))
    assert [each.child_frame_id for each in moves.find_moved()] == ["arm"]


def test_the_least_movements_are_seen_with_limits_of_zero() -> None:
    buffer = Buffer()
    moves = MovedFrames(buffer, "map", ["base"], 0.0, 0.0)
    buffer.set_transform(frame(0.0, 0.0, seconds=1))
    assert len(moves.find_moved()) == 1
    assert moves.find_moved() == []
    buffer.set_transform(frame(0.0, 1e-9, seconds=2))
    assert len(moves.find_moved()) == 1


def test_too_many_frames() -> None:
    with pytest.raises(ValueError, match="are too many"):
        MovedFrames(Buffer(), "map", ["x"] * (MAX_FRAMES + 1), 0, 0)


@pytest.fixture
def robot(make_node: MakeNode) -> TransformBroadcaster:
    """The republisher runs, and something sends transforms."""
    Republisher(make_node("tf2_web_republisher"))
    return TransformBroadcaster(make_node("robot"))


def send_until(broadcaster: TransformBroadcaster, x: float, came: queue.Queue[Any]) -> Any:
    """Send a transform until someone got it."""
    for seconds in range(1, 2000):
        broadcaster.send_transform(frame(x, seconds=seconds))
        try:
            found = came.get(timeout=0.05)
        except queue.Empty:
            continue
        if found.transforms[0].transform.translation.x == x:
            return found
    raise AssertionError("nothing came")


def test_a_goal_is_fed_until_it_is_cancelled(robot: TransformBroadcaster, make_node: MakeNode) -> None:
    came: queue.Queue[Any] = queue.Queue()
    with Client(make_node("page"), "/tf2_web_republisher", TFSubscriptionAction) as client:
        assert client.wait_for_server(PATIENCE)
        goal = client.send(
            TFSubscriptionGoal(source_frames=["base"], target_frame="map", rate=100.0), on_feedback=came.put
        )
        send_until(robot, 1.0, came)
        found = send_until(robot, 2.0, came)
        assert [each.child_frame_id for each in found.transforms] == ["base"]
        goal.cancel()
        with pytest.raises(GoalError) as error:
            goal.result(PATIENCE)
        assert error.value.status is Status.PREEMPTED
        refused = client.send(TFSubscriptionGoal(source_frames=["x"] * (MAX_FRAMES + 1)))
        with pytest.raises(GoalError, match="too many"):
            refused.result(PATIENCE)


def test_a_topic_for_a_page_ends_when_nobody_listens(robot: TransformBroadcaster, make_node: MakeNode) -> None:
    page = make_node("page")
    page.wait_for_service("/republish_tfs", PATIENCE)
    service = page.service("/republish_tfs", RepublishTFs)
    topic = service(source_frames=["base"], target_frame="map", rate=100.0).topic_name
    first: queue.Queue[Any] = queue.Queue()
    subscriber = page.subscribe(topic, TFArray, first.put)
    send_until(robot, 1.0, first)
    second: queue.Queue[Any] = queue.Queue()
    late = make_node("late").subscribe(topic, TFArray, second.put)
    assert second.get(timeout=PATIENCE).transforms[0].transform.translation.x == 1.0, "nothing moves, but it is told"
    subscriber.unregister()
    late.unregister()
    until = monotonic() + PATIENCE
    while any(name == topic for name, _ in page.master.get_system_state()[0]):
        assert page.sleep(0.05) and monotonic() < until
    with pytest.raises(ServiceError, match="too many"):
        service(source_frames=["x"] * (MAX_FRAMES + 1))
