"""QoS profiles of rclpy."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pyros1.ros2.rclpy_side.qos import UNKNOWN_DEPTH, from_rclpy, to_rclpy
from pyros1.ros2.zenoh.qos import Qos

from .fake_rclpy import QOS


@pytest.mark.parametrize(
    "qos", [Qos(), Qos(reliable=False), Qos(transient_local=True, depth=1), Qos(keep_all=True, depth=5)]
)
def test_there_and_back(qos: Qos) -> None:
    assert from_rclpy(to_rclpy(qos, QOS)) == qos


def test_what_dds_does_not_tell() -> None:
    """Numbers of rmw for "unknown" and "best available", and no depth."""
    unknown = SimpleNamespace(reliability=4, durability=3, history=3, depth=0)
    assert from_rclpy(unknown) == Qos(depth=UNKNOWN_DEPTH)
