"""What is counted of topics, whose names others make up."""

from __future__ import annotations

import pytest

from pyros1.ros2.bridge import counts
from pyros1.ros2.bridge.counts import Counts


def test_both_directions_are_counted_apart() -> None:
    counted = Counts()
    counted.to_ros1("/a").count(3)
    counted.to_ros1("/a").count(4)
    assert (counted.to_ros1("/a").messages, counted.to_ros1("/a").bytes) == (2, 7)
    assert counted.to_ros2("/a").messages == 0


def test_names_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(counts, "MAX_TOPICS", 3)
    counted = Counts()
    for number in range(4):
        for flow in (counted.to_ros1, counted.to_ros2):
            flow(f"/{number}").count(1)
    for flow in (counted.to_ros1, counted.to_ros2):
        assert [flow(name).messages for name in ("/1", "/2", "/3", "/0")] == [1, 1, 1, 0]
