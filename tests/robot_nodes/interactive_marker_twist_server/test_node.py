"""marker_server as a node."""

from __future__ import annotations

from collections.abc import Callable
from math import nan
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.visualization_msgs.msg import (
    InteractiveMarkerFeedback,
    InteractiveMarkerInit,
    InteractiveMarkerUpdate,
)
from pyros1.robot_nodes.interactive_marker_twist_server.node import MarkerServer

Make = Callable[..., Any]
KEEP_ALIVE, POSE_UPDATE, MOUSE_UP = 0, 1, 5


def feedback(x: float, event: int = POSE_UPDATE, frame_id: str = "base_link", name: str = "robot_twist_marker") -> Any:
    message = InteractiveMarkerFeedback(marker_name=name, event_type=event)
    message.header.frame_id = frame_id
    message.pose.position.x, message.pose.orientation.w = x, 1.0
    return message


def test_dragging_and_releasing(
    make_node: Make, next_of: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Feature: marker_server stops the robot when the marker is released, or its program is gone"""
    monkeypatch.setattr("pyros1.robot_nodes.interactive_marker_twist_server.node.KEEP_ALIVE_PERIOD", 0.05)
    monkeypatch.setattr("pyros1.robot_nodes.interactive_marker_twist_server.node.MAX_SILENCE", 60.0)
    user = make_node("user")
    came: Queue[Any] = Queue()
    full: Queue[Any] = Queue()
    updates: Queue[Any] = Queue()
    commands = user.subscribe("twist_marker_server/cmd_vel", Twist, came.put)
    user.subscribe("twist_marker_server/update", InteractiveMarkerUpdate, updates.put)
    user.subscribe("twist_marker_server/update_full", InteractiveMarkerInit, full.put)
    MarkerServer(make_node("twist_marker_server"))
    first = full.get(timeout=20)
    assert (first.server_id, first.seq_num, first.markers[0].name) == ("/twist_marker_server", 0, "robot_twist_marker")
    assert next_of(updates, lambda update: update.type == KEEP_ALIVE).seq_num == 0
    hand = user.advertise("twist_marker_server/feedback", InteractiveMarkerFeedback)
    assert hand.wait_for_subscribers(timeout=20) and commands.wait_for_publishers(timeout=20)
    hand.publish(feedback(9.0, name="other"))
    hand.publish(feedback(nan))
    hand.publish(feedback(9.0, frame_id="map"))
    hand.publish(feedback(0.5, frame_id="/base_link"))
    assert came.get(timeout=20).linear.x == 0.5
    assert "ignored a pose in map, which is not base_link" in capfd.readouterr().err
    update = next_of(updates, lambda update: update.type != KEEP_ALIVE)
    assert (update.seq_num, update.poses[0].name, update.poses[0].pose.position.x) == (1, "robot_twist_marker", 0.0)
    assert full.get(timeout=20).seq_num == 1
    hand.publish(feedback(0.5, MOUSE_UP))
    assert came.get(timeout=20).linear.x == 0.0
    monkeypatch.setattr("pyros1.robot_nodes.interactive_marker_twist_server.node.MAX_SILENCE", 0.1)
    hand.publish(feedback(0.25, KEEP_ALIVE))
    assert [came.get(timeout=20).linear.x for _ in range(2)] == [0.25, 0.0]
