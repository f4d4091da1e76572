"""Log messages, whose fields and levels are others in ROS 2, through a ROS 2 bag and back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from rosbags.highlevel import AnyReader

from pyros1.bag.errors import BagError
from pyros1.bag.export.imports import import_bag
from pyros1.bag.export.ros2 import Ros2Writer
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.writer import BagWriter
from pyros1.ground.timing import Time
from pyros1.msgs import load_message

from ...bodies import encode
from ..made import header_of

LOG: Any = load_message("rosgraph_msgs/Log")


def write_log(path: Path, **header: str) -> Path:
    message = LOG(level=LOG.WARN, name="/driver", msg="hot", file="d.py", function="run", line=7, topics=["/a"])
    message.header.stamp = Time(5, 6)
    message.header.frame_id = "f"
    with BagWriter(path) as writer:
        writer.write(writer.add_connection("/rosout", header_of(LOG, **header)), 9, encode(message))
    return path


def export(source: Path, target: Path) -> None:
    writer = Ros2Writer(target)
    with BagReader(source) as bag:
        for stored in bag.messages():
            writer.write_raw(stored)
    writer.close()


def test_log_messages_through_a_ros2_bag(tmp_path: Path) -> None:
    export(write_log(tmp_path / "a.bag"), tmp_path / "ros2")
    with AnyReader([tmp_path / "ros2"]) as reader:
        ((connection, _, data),) = reader.messages()
        message: Any = reader.deserialize(data, connection.msgtype)
    assert (connection.msgtype, message.level, message.name, message.msg) == (
        "rcl_interfaces/msg/Log",
        30,
        "/driver",
        "hot",
    )
    assert (message.stamp.sec, message.stamp.nanosec, message.line) == (5, 6, 7)
    import_bag(tmp_path / "ros2", tmp_path / "b.bag")
    with BagReader(tmp_path / "b.bag") as bag:
        (stored,) = bag.messages()
    assert (stored.connection.type, stored.connection.md5sum) == ("rosgraph_msgs/Log", LOG._md5sum)
    back = LOG().deserialize(bytes(stored.data))
    assert (back.level, back.name, back.header.stamp, back.topics) == (LOG.WARN, "/driver", Time(5, 6), [])


def test_a_log_message_of_another_definition(tmp_path: Path) -> None:
    source = write_log(tmp_path / "a.bag", message_definition="string level\n", md5sum="0" * 32)
    with pytest.raises(BagError, match=r"message on /rosout at .* cannot be converted: .*no field 'header'"):
        export(source, tmp_path / "ros2")
