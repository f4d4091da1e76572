"""The classes of types, found by their names."""

from __future__ import annotations

from pathlib import Path

import pytest

from pyros1.ground.errors import UnknownTypeError
from pyros1.ros2.rclpy_side.type_classes import TypeClasses
from pyros1.ros2_types.rclpy_packages import RclpyPackages


@pytest.fixture
def classes(prefix: Path) -> TypeClasses:
    return TypeClasses(RclpyPackages())


def test_messages_and_services(classes: TypeClasses) -> None:
    assert classes.message("lab_msgs/msg/Bench").__name__ == "Bench"
    assert classes.service("lab_msgs/srv/Clean").__name__ == "Clean"


def test_the_parts_of_actions(classes: TypeClasses) -> None:
    assert classes.service("lab_msgs/action/Walk_SendGoal") == "send"
    assert classes.service("lab_msgs/action/Walk_GetResult") == "result"
    assert classes.message("lab_msgs/action/Walk_FeedbackMessage") == "feedback"


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("yard_msgs/msg/Tree", "package yard_msgs is not installed in this ROS 2 installation"),
        ("no_msgs/msg/Tree", "package no_msgs is not installed in this ROS 2 installation"),
        ("lab_msgs/msg/Chair", "rclpy cannot use lab_msgs/msg/Chair: module 'lab_msgs.msg' has no attribute 'Chair'"),
        ("bad_msgs/msg/Bench", "rclpy cannot use bad_msgs/msg/Bench: of another Python"),
        ("lab_msgs/srv/Clean", "lab_msgs/srv/Clean is not a message type"),
        ("lab_msgs/action/Walk", "lab_msgs/action/Walk is not a message type"),
    ],
)
def test_what_is_not_there(classes: TypeClasses, name: str, problem: str) -> None:
    with pytest.raises(UnknownTypeError) as raised:
        classes.message(name)
    assert str(raised.value) == problem


def test_a_message_is_no_service(classes: TypeClasses) -> None:
    with pytest.raises(UnknownTypeError, match="is not a service type"):
        classes.service("lab_msgs/msg/Bench")
