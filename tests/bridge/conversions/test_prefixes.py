"""The prefixes of frames and nodes in messages that are taken."""

from __future__ import annotations

from typing import Any

import pytest
from tests.bodies import decode, encode

from pyros1.bridge.conversions.prefixes import Prefixer
from pyros1.ground.errors import MessageError
from pyros1.msgs import load_message
from pyros1.msgs.geometry_msgs.msg import PoseStamped, TransformStamped
from pyros1.msgs.nav_msgs.msg import Odometry, Path
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.sensor_msgs.msg import Image, JointState
from pyros1.msgs.tf2_msgs.msg import TFMessage


def prefixed(message: Any, frames: str = "red", kept: tuple[str, ...] = (), nodes: str = "/red") -> Any:
    prefixer = Prefixer(frames, kept, nodes)
    assert prefixer.learn(message._type, message._full_text) == ""
    return decode(type(message), prefixer.change(encode(message)))


def transform(parent: str, child: str) -> Any:
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = parent, child
    message.transform.translation.x = 1.5
    return message


@pytest.mark.parametrize(
    ("frame", "expected"),
    [
        ("base_link", "red/base_link"),
        ("/base_link", "red/base_link"),  # as tf wrote it
        ("", ""),
        ("/", "/"),
        ("map", "map"),
        ("/map", "/map"),
        ("red/base_link", "red/red/base_link"),
    ],
)
def test_frames(frame: str, expected: str) -> None:
    message = prefixed(TFMessage([transform(frame, "a"), transform("b", frame)]), kept=("map", "world"))
    assert [(each.header.frame_id, each.child_frame_id) for each in message.transforms] == [
        (expected, "red/a"),
        ("red/b", expected),
    ]
    assert message.transforms[1].transform.translation.x == 1.5


def test_other_types_with_frames() -> None:
    odometry = Odometry(child_frame_id="base")
    odometry.header.frame_id = "odom"
    odometry.twist.twist.linear.x = 2.0
    odometry = prefixed(odometry)
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("red/odom", "red/base")
    assert odometry.twist.twist.linear.x == 2.0
    pose = PoseStamped()
    pose.header.frame_id = "map"
    path = prefixed(Path(poses=[pose, pose]))
    assert (path.header.frame_id, [each.header.frame_id for each in path.poses]) == ("", ["red/map"] * 2)
    image = Image(data=bytes(1000), encoding="mono8")
    image.header.frame_id = "camera"
    image = prefixed(image, frames="fleet/red")
    assert (image.header.frame_id, image.encoding, len(image.data)) == ("fleet/red/camera", "mono8", 1000)


@pytest.mark.parametrize(
    ("nodes", "name", "expected"),
    [("/red", "/driver", "/red/driver"), ("/red", "driver", "/red/driver"), ("", "/driver", "/driver")],
)
def test_nodes_in_log_messages(nodes: str, name: str, expected: str) -> None:
    log = Log(name=name, msg="hot", file="name")
    log.header.frame_id = "laser"
    log = prefixed(log, frames="", nodes=nodes)
    assert (log.name, log.msg, log.file, log.header.frame_id) == (expected, "hot", "name", "laser")


def test_messages_without_frames_stay_as_they_are() -> None:
    prefixer = Prefixer("red", (), "/red")
    assert prefixer.learn("std_msgs/String", "string data\n") == ""
    assert prefixer.change(b"whatever") == b"whatever"
    for type_name in ("nav_msgs/Odometry", "rosgraph_msgs/Log"):
        nothing = Prefixer("", (), "/red")
        assert nothing.learn(type_name, "") == "" and nothing.change(b"whatever") == b"whatever"
    joints = prefixed(JointState(name=["wheel"]), frames="")
    assert joints.name == ["wheel"]


def test_a_definition_that_comes_later() -> None:
    prefixer = Prefixer("red", (), "")
    assert "the definition of its type is not known" in prefixer.learn("nav_msgs/Odometry", "")
    assert "prefixes cannot be added" in prefixer.learn("nav_msgs/Odometry", "nonsense")
    cls: Any = load_message("nav_msgs/Odometry")
    assert prefixer.learn("nav_msgs/Odometry", cls._full_text) == ""
    with pytest.raises(MessageError):
        prefixer.change(b"short")
