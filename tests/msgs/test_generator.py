"""msgs.generator: how much code is generated."""

from __future__ import annotations

from pyros1.msgs.generator import inline_size
from pyros1.msgs.geometry_msgs.msg import Point, PoseStamped, PoseWithCovariance
from pyros1.msgs.std_msgs.msg import Empty, Header


def test_values_and_messages_are_counted() -> None:
    assert (inline_size(Empty), inline_size(Point), inline_size(Header)) == (0, 3, 3)
    assert inline_size(PoseStamped) == (1 + 3) + 1 + (1 + 3) + (1 + 4)
    assert inline_size(PoseWithCovariance) == 1 + (1 + 3) + (1 + 4) + 1  # an array is one value
