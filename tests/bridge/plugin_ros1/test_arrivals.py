"""What has come and waits."""

from __future__ import annotations

import pytest

from pyros1.bridge.plugin_ros1 import arrivals
from pyros1.bridge.plugin_ros1.arrivals import Arrivals


def test_beacons_go_first_and_messages_in_order() -> None:
    waiting = Arrivals()
    waiting.put_message("a", b"1")
    waiting.put_message("a", b"2")
    waiting.put_beacon("b")
    assert [waiting.pop() for _ in range(4)] == [("b", None), ("a", b"1"), ("a", b"2"), None]


def test_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arrivals, "MAX_BEACONS", 2)
    waiting = Arrivals(max_bytes=10, max_messages=3)
    for number in range(4):
        waiting.put_beacon(str(number))
        waiting.put_message("a", bytes([number]))
    assert waiting.dropped == 3
    waiting.put_message("a", b"x" * 9)
    waiting.put_message("a", b"y" * 50)
    assert [waiting.pop() for _ in range(4)] == [("0", None), ("1", None), ("a", b"y" * 50), None]
    waiting.put_message("a", b"x" * 9)
    waiting.put_message("a", b"z")
    assert waiting.pop() == ("a", b"x" * 9), "what has gone counts no longer"
