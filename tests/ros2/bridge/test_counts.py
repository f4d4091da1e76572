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


def test_rates() -> None:
    counted = Counts()
    counted.sample(0.0)
    assert counted.rate_to_ros2("/a") is None
    for _ in range(10):
        counted.to_ros2("/a").count(100)
    counted.to_ros1("/a").count(6)
    counted.sample(0.5)  # too early
    counted.sample(2.0)
    assert counted.rate_to_ros2("/a") == (5.0, 500.0) and counted.rate_to_ros1("/a") == (0.5, 3.0)
    assert counted.rate_to_ros1("/b") == (0.0, 0.0)
