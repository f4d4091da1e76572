"""The status of a bridge to ROS 2."""

from __future__ import annotations

import json
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import pytest

from pyros1 import __version__
from pyros1.bridge.exchange.services.call_packets import CallCounts
from pyros1.bridge.status import status_lines
from pyros1.ros2.bridge.counts import Counts
from pyros1.ros2.bridge.plan import Plan, TakenTopic
from pyros1.ros2.bridge.status import status_json
from pyros1.web.transforms.bridges import describe_bridge

PAIR: Any = SimpleNamespace(ros1="std_msgs/String", ros2="std_msgs/msg/String")


def status(plan: Plan, counts: Counts, provides: Mapping[str, Any] = {}, problems: Mapping[str, str] = {}) -> Any:
    services: Any = SimpleNamespace(
        plan=SimpleNamespace(offers={}, provides=provides), counts=lambda kind, name: CallCounts()
    )
    sender: Any = Mock(waiting_bytes=0)
    return json.loads(
        status_json("rclpy", 0, plan, ["/far"], ["/a"], "", sender, problems, counts, services, [], {}, 0)
    )


def test_rates_and_version() -> None:
    counts = Counts()
    counts.sample(0.0)
    counts.to_ros1("/a").count(10)
    counts.sample(2.0)
    found = status(Plan(takes={"/a": TakenTopic(PAIR)}), counts)
    (row,) = found["received"]
    assert (row["messages_per_second"], row["bytes_per_second"]) == (0.5, 5.0)
    assert (found["version"], found["via"], found["not_listed"]) == (__version__, "rclpy", {})
    shown = describe_bridge("/bridge", found)
    assert shown is not None and [(each["hz"], each["bytes"]) for each in shown["flows"]] == [(0.5, 5.0)]


def test_what_is_too_much_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.status.LISTED_BYTES", 3000)
    monkeypatch.setattr("pyros1.ros2.bridge.status.MAX_PROBLEMS", 3)
    plan = Plan(takes={f"/{number}": TakenTopic(PAIR) for number in range(50)})
    provides = {f"/s{number}": SimpleNamespace(pair=PAIR) for number in range(50)}
    found = status(plan, Counts(), provides, {f"/{number}": "why" for number in range(5)})
    listed = len(found["received"]) + len(found["called"])
    assert 3 <= listed <= 10 and found["not_listed"] == {"ROS 2": 100 - listed}
    assert len(found["problems"]) == 3
    assert found["trouble"] == {"topics and services with problems that are not listed": 2}
    assert f"  {100 - listed} more topics and services of ROS 2 are not listed" in [*status_lines(found)]
