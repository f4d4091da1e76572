"""The messages of actions that are the same for all actions, at both sides."""

from __future__ import annotations

import struct
from io import BytesIO
from typing import Any

import pytest

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time
from pyros1.msgs import load_message
from pyros1.ros2.bridge.actions import ros1_messages, ros2_messages
from pyros1.ros2.bridge.actions.ros1_messages import GoalStatus
from pyros1.ros2.bridge.actions.ros2_messages import GoalInfo, ReportedGoal

UUID = bytes(range(16))
STATUSES = [GoalStatus("a", (1, 2), 3, "text"), GoalStatus("ü", (3, 4), 1, "")]


def encode(message: Any) -> bytes:
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def ros1_status(status: GoalStatus) -> Any:
    goal_id = load_message("actionlib_msgs/GoalID")(Time(*status.stamp), status.name)
    return load_message("actionlib_msgs/GoalStatus")(goal_id, status.status, status.text)


def test_ros1s_messages() -> None:
    goal: Any = load_message("actionlib_tutorials/FibonacciActionGoal")()
    goal.goal_id.id, goal.goal_id.stamp, goal.header.frame_id, goal.goal.order = "a", Time(1, 2), "map", 7
    body = struct.pack("<i", 7)
    assert ros1_messages.decode_goal(encode(goal)) == ("a", (1, 2), body)
    goal.header.frame_id, goal.goal_id.stamp, goal.header.stamp = "", Time(), Time(8, 9)
    assert ros1_messages.encode_goal((8, 9), "a", body) == encode(goal)
    goal_id = load_message("actionlib_msgs/GoalID")(Time(1, 2), "a")
    assert ros1_messages.encode_cancel("a", (1, 2)) == encode(goal_id)
    assert ros1_messages.decode_cancel(encode(goal_id)) == ("a", (1, 2))
    result: Any = load_message("actionlib_tutorials/FibonacciActionResult")(status=ros1_status(STATUSES[0]))
    result.header.stamp, result.result.sequence = Time(8, 9), [5]
    assert ros1_messages.decode_result(encode(result)) == (STATUSES[0], struct.pack("<Ii", 1, 5))
    assert ros1_messages.encode_result((8, 9), STATUSES[0], struct.pack("<Ii", 1, 5)) == encode(result)
    statuses: Any = load_message("actionlib_msgs/GoalStatusArray")(status_list=[*map(ros1_status, STATUSES)])
    statuses.header.stamp = Time(8, 9)
    assert ros1_messages.encode_statuses((8, 9), STATUSES) == encode(statuses)
    assert ros1_messages.decode_statuses(encode(statuses)) == STATUSES


def test_ros2s_messages() -> None:
    info = GoalInfo(UUID, (1, 2))
    assert ros2_messages.decode_uuid(ros2_messages.encode_uuid(UUID)) == UUID
    assert ros2_messages.decode_cancel(ros2_messages.encode_cancel(info)) == info
    assert ros2_messages.decode_goal_response(ros2_messages.encode_goal_response(True, (1, 2))) == (True, (1, 2))
    assert ros2_messages.decode_goal_response(b"\0\0\0\0" + struct.pack(">?3xiI", True, 1, 2)) == (True, (1, 2))
    assert ros2_messages.decode_goal_response(b"\0\1\0\0" + struct.pack("<?3xiI", True, -1, 2)) == (True, (0, 2))
    goals = [info, GoalInfo(UUID[::-1], (3, 4))]
    assert ros2_messages.decode_cancel_response(ros2_messages.encode_cancel_response(2, goals)) == (2, goals)
    reported = [ReportedGoal(info, 4), ReportedGoal(goals[1], 5), ReportedGoal(info, -1)]
    body = ros2_messages.encode_statuses(reported)
    assert ros2_messages.decode_statuses(body) == reported


@pytest.mark.parametrize(
    "read",
    [
        ros1_messages.decode_goal,
        ros1_messages.decode_cancel,
        ros1_messages.decode_result,
        ros1_messages.decode_statuses,
        ros2_messages.decode_uuid,
        ros2_messages.decode_cancel,
        ros2_messages.decode_goal_response,
        ros2_messages.decode_cancel_response,
        ros2_messages.decode_statuses,
    ],
)
@pytest.mark.parametrize("body", [b"", b"\0\1\0\0", b"\0\1\0\0" + b"\1" * 5])
def test_messages_that_are_not_valid(read: Any, body: bytes) -> None:
    with pytest.raises(MessageError):
        read(body)


def test_messages_that_are_too_large() -> None:
    many = [ReportedGoal(GoalInfo(UUID), 1)] * 1001
    with pytest.raises(MessageError, match="more than 1000"):
        ros2_messages.decode_statuses(ros2_messages.encode_statuses(many))
    with pytest.raises(MessageError, match="more than 1000"):
        ros1_messages.decode_statuses(ros1_messages.encode_statuses((0, 0), [STATUSES[0]] * 1001))
    with pytest.raises(MessageError, match="more than 1000"):
        ros1_messages.decode_cancel(ros1_messages.encode_cancel("x" * 1001, (0, 0)))


def test_lengths_that_are_not_valid() -> None:
    with pytest.raises(MessageError, match="ends too early"):
        ros1_messages.decode_cancel(bytes(8) + b"\xff\xff\xff\x7f")
    with pytest.raises(MessageError, match="more than 1000"):
        ros2_messages.decode_cancel_response(b"\0\1\0\0" + bytes(4) + b"\xff" * 4)
    with pytest.raises(MessageError, match="is not CDR"):
        ros2_messages.decode_uuid(b"\7" * 20)
