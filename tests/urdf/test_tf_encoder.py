"""Encoded transforms are those that the codec of messages makes."""

from __future__ import annotations

from robots import ALL

from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.urdf.kinematics import Kinematics
from pyros1.urdf.reading import read_robot
from pyros1.urdf.tf_encoder import TransformBatch


def test_bytes_are_a_message() -> None:
    moving = Kinematics(read_robot(ALL)).moving.values()
    batch = TransformBatch((joint.parent, joint.child + "é", place) for joint, place in moving)
    positions = [0.1 * index for index in range(len(batch))]
    for secs in (7, 2**32 - 1):
        message = TFMessage().deserialize(batch.encode(secs, 5, positions))
        assert len(message.transforms) == 6
        for each, (joint, place), position in zip(message.transforms, moving, positions, strict=True):
            assert (each.header.seq, each.header.stamp.secs, each.header.stamp.nsecs) == (0, secs, 5)
            assert (each.header.frame_id, each.child_frame_id) == (joint.parent, joint.child + "é")
            moved, turned = each.transform.translation, each.transform.rotation
            assert (moved.x, moved.y, moved.z, turned.x, turned.y, turned.z, turned.w) == place(position)
