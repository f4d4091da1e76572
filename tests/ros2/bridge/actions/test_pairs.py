"""Which ROS 2 action type a ROS 1 action type is."""

from __future__ import annotations

import pytest

from pyros1.ground.errors import Error, MessageError, UnknownTypeError
from pyros1.msgs import load_message
from pyros1.ros2.bridge.actions.pairs import ActionPairs
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2.zenoh.names import HUMBLE_HASH
from pyros1.wire.handshake import TopicType

FIBONACCI = "actionlib_tutorials/Fibonacci"
UUID = bytes(range(16))
HEAD = b"\0\1\0\0"


@pytest.fixture(scope="module")
def pairs() -> ActionPairs:
    return TypePairs().actions


def test_an_action_of_ros1(pairs: ActionPairs) -> None:
    pair = pairs.for_ros1(FIBONACCI, {})
    assert (pair.ros1, pair.ros2) == (FIBONACCI, "actionlib_tutorials/action/Fibonacci")
    # As ROS 2 Kilted has them.
    assert pair.hashes.cancel_goal == "RIHS01_573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a"
    assert pair.hashes.status == "RIHS01_6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e"
    assert pair.goal.name == "actionlib_tutorials/FibonacciActionGoal"
    assert pair.goal.md5sum == load_message(pair.goal.name)._md5sum
    assert pair.to_goal.to_cdr(UUID + b"\5\0\0\0") == HEAD + UUID + b"\5\0\0\0"
    assert pair.to_feedback.from_cdr(HEAD + UUID + b"\1\0\0\0\7\0\0\0") == UUID + b"\1\0\0\0\7\0\0\0"
    assert pair.to_result.to_cdr(b"\4" + pair.empty_result) == HEAD + b"\4\0\0\0\0\0\0\0"
    assert pairs.for_ros2(pair.ros2, pair.hashes.send_goal).hashes == pair.hashes


@pytest.mark.parametrize(
    "name", ["control_msgs/FollowJointTrajectory", "move_base_msgs/MoveBase", "tf2_msgs/LookupTransform"]
)
def test_actions_with_headers_and_times(pairs: ActionPairs, name: str) -> None:
    pair = pairs.for_ros1(name, {})
    for transcoder in (pair.to_goal, pair.to_result, pair.to_feedback):
        assert transcoder.only_ros1 == transcoder.only_ros2 == []
    assert pair.to_result.from_cdr(pair.to_result.to_cdr(b"\6" + pair.empty_result))[:1] == b"\6"


def test_an_action_that_is_not_installed(pairs: ActionPairs) -> None:
    def topic(part: str, definition: str) -> TopicType:
        return TopicType(f"my_robot/DanceAction{part}", load_message(f"{FIBONACCI}Action{part}")._md5sum, definition)

    def text(part: str) -> str:
        full: str = load_message(f"{FIBONACCI}Action{part}")._full_text
        return (
            full.replace("actionlib_tutorials/Fibonacci", "my_robot/Dance")
            .replace(" Fibonacci", " Dance")
            .replace("\nFibonacci", "\nDance")
        )

    topics = {part.lower(): topic(part, text(part)) for part in ("Goal", "Result", "Feedback")}
    pair = pairs.for_ros1("my_robot/Dance", topics)
    assert pair.ros2 == "my_robot/action/Dance"
    assert pair.to_goal.to_cdr(UUID + b"\5\0\0\0") == HEAD + UUID + b"\5\0\0\0"
    del topics["goal"]
    with pytest.raises(Error, match="my_robot"):
        pairs.for_ros1("my_robot/Dance", topics)


def test_humble_has_no_hashes(pairs: ActionPairs) -> None:
    pair = pairs.for_ros2("actionlib_tutorials/action/Fibonacci", HUMBLE_HASH)
    assert {*pair.hashes} == {HUMBLE_HASH}


def test_types_that_are_not_the_same(pairs: ActionPairs) -> None:
    with pytest.raises(UnknownTypeError, match="another definition of actionlib_tutorials/action/Fibonacci"):
        pairs.for_ros2("actionlib_tutorials/action/Fibonacci", "RIHS01_" + "0" * 64)
    with pytest.raises(Error, match="example_interfaces"):
        pairs.for_ros2("example_interfaces/action/Fibonacci", "RIHS01_" + "0" * 64)
    wrong = TopicType(f"{FIBONACCI}ActionResult", "0" * 32, "")
    with pytest.raises(MessageError):
        pairs.for_ros1(FIBONACCI, {"result": wrong})
