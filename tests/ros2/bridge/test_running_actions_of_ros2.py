"""ROS 2 actions that ROS 1 uses through a running bridge.

Feature: actions of ROS 2 nodes that use rmw_zenoh -- `pyros1 bridge ros2`, from ROS 1 to ROS 2
"""

from __future__ import annotations

import queue
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("zenoh")

from pyros1.actions import Client, Status
from pyros1.ros2.bridge.actions import ros2_messages
from pyros1.ros2.bridge.actions.ros2_messages import CancelCode, GoalInfo, Ros2Status

from ...bridge.conftest import PATIENCE, wait_until
from .test_running import RunningBridge
from .test_running_actions import (
    FIBONACCI,
    HEAD,
    NAME,
    ActionPeer,
    bridge,
    endpoint,
    keys,
    numbers,
    peer,
    result,
    send,
    values,
)

__all__ = ["bridge", "endpoint", "peer"]


@pytest.fixture
def client(bridge: RunningBridge, peer: ActionPeer) -> Iterator[Any]:
    peer.serve(keys())
    with Client(bridge.node, NAME, FIBONACCI) as client:
        assert client.wait_for_server(PATIENCE)
        yield client


def test_ros1_uses_an_action_of_ros2(bridge: RunningBridge, peer: ActionPeer, client: Any) -> None:
    feedback: queue.Queue[Any] = queue.Queue()
    goal = send(client, 5, on_feedback=feedback.put)
    uuid, order = peer.accept()
    assert order == 5
    peer.report(uuid, Ros2Status.EXECUTING)
    wait_until(lambda: goal.status is Status.ACTIVE, "it is active")
    asked = peer.asked("get_result")
    assert asked.body == ros2_messages.encode_uuid(uuid)
    peer.send(peer.action.feedback, HEAD + uuid + numbers(0, 1))
    assert feedback.get(timeout=PATIENCE).sequence == (0, 1)
    asked.respond(result(Ros2Status.SUCCEEDED, 0, 1, 1))
    assert goal.wait(PATIENCE) and goal.status is Status.SUCCEEDED
    assert values(goal) == [0, 1, 1]
    assert bridge.status()["actions"][0]["server"] == "ROS 2"


def test_goals_of_ros1_that_ros2_rejects_or_aborts(peer: ActionPeer, client: Any) -> None:
    goal = send(client, 5)
    peer.accept(False)
    assert goal.wait(PATIENCE) and goal.status is Status.REJECTED
    goal = send(client, 6)
    peer.accept()
    peer.asked("get_result").respond(result(Ros2Status.ABORTED, 6))
    assert goal.wait(PATIENCE) and goal.status is Status.ABORTED and values(goal) == [6]
    goal = send(client, 7)
    peer.asked("send_goal").fail("broken")
    assert goal.wait(PATIENCE) and goal.status is Status.ABORTED and "broken" in goal.text
    assert peer.asked("cancel_goal"), "it must not run, whatever has become of it"


def test_ros1_cancels_a_goal_in_ros2(peer: ActionPeer, client: Any) -> None:
    goal = send(client, 5)
    uuid, _ = peer.accept()
    asked = peer.asked("get_result")
    goal.cancel()
    refused = peer.asked("cancel_goal")
    assert refused.body == ros2_messages.encode_cancel(GoalInfo(uuid))
    refused.respond(ros2_messages.encode_cancel_response(CancelCode.REJECTED, []))
    goal.cancel()
    peer.asked("cancel_goal").respond(ros2_messages.encode_cancel_response(CancelCode.NONE, [GoalInfo(uuid)]))
    wait_until(lambda: goal.status is Status.PREEMPTING, "it is being cancelled")
    asked.respond(result(Ros2Status.CANCELED, 1))
    assert goal.wait(PATIENCE) and goal.status is Status.PREEMPTED and values(goal) == [1]


def test_a_goal_of_ros1_that_is_cancelled_before_it_is_accepted(peer: ActionPeer, client: Any) -> None:
    goal = send(client, 5)
    asked = peer.asked("send_goal")
    goal.cancel()
    wait_until(lambda: goal.status is Status.RECALLING, "the bridge has noted it")
    asked.respond(ros2_messages.encode_goal_response(True, (0, 0)))
    calls = {call.key: call for call in (peer.calls.get(timeout=PATIENCE) for _ in range(2))}  # they may overtake
    calls[peer.action.cancel_goal].respond(ros2_messages.encode_cancel_response(CancelCode.NONE, []))
    calls[peer.action.get_result].respond(result(Ros2Status.CANCELED))
    assert goal.wait(PATIENCE) and goal.status is Status.PREEMPTED


def test_a_server_in_ros2_that_ends_and_starts_again(bridge: RunningBridge, peer: ActionPeer, client: Any) -> None:
    goal = send(client, 5)
    peer.accept()
    peer.asked("get_result")
    peer.stop()
    assert goal.wait(PATIENCE) and goal.status is Status.ABORTED
    assert goal.text == "the action server in ROS 2 is gone"
    peer.serve(keys())
    wait_until(lambda: bridge.status()["actions"], "the bridge sees it again")

    def is_accepted() -> bool:
        goal = send(client, 6)
        wait_until(lambda: goal.done or not peer.calls.empty(), "it ends, or it comes")
        return not goal.done

    wait_until(is_accepted, "it takes goals again")
    assert peer.accept()[1] == 6


def test_what_makes_no_sense(bridge: RunningBridge, peer: ActionPeer, client: Any) -> None:
    goal = send(client, 5)
    uuid, _ = peer.accept()
    asked = peer.asked("get_result")
    for body in (b"", HEAD, b"x" * 100, HEAD + b"\xff" * 40):
        peer.send(peer.action.feedback, body)
        peer.send(peer.action.status, body)
    peer.report(uuid, 77)
    peer.send(peer.action.feedback, HEAD + bytes(16) + numbers(1))
    asked.respond(result(99, 1))
    assert goal.wait(PATIENCE) and goal.status is Status.ABORTED
    goal = send(client, 6)
    peer.accept()
    peer.asked("get_result").respond(HEAD + b"\4")
    assert goal.wait(PATIENCE) and goal.status is Status.ABORTED
