"""Latched messages of publishers that ROS 2 does not see yet."""

from __future__ import annotations

from pyros1.bridge.exchange.actions import Send
from pyros1.ros2.bridge import early_messages
from pyros1.ros2.bridge.early_messages import EarlyMessages


def test_the_last_message_of_each_publisher_waits() -> None:
    waiting = EarlyMessages()
    for key, body in (("a", b"1"), ("b", b"2"), ("a", b"3")):
        waiting.put(Send(key, b"", body))
    assert waiting.pop({"c"}) == []
    assert waiting.pop({"a", "c"}) == [Send("a", b"", b"3")] and waiting.pop({"a"}) == []
    assert waiting.pop({"a", "b"}) == [Send("b", b"", b"2")]


def test_what_waits_is_bounded() -> None:
    waiting = EarlyMessages(max_bytes=10)
    for key in "abc":
        waiting.put(Send(key, b"", bytes(4)))
    waiting.put(Send("b", b"", bytes(3)))
    assert [packet.key for packet in waiting.pop("abc")] == ["c", "b"]
    waiting.put(Send("a", b"", bytes(20)))
    assert [packet.key for packet in waiting.pop("abc")] == ["a"], "one may always wait"
    waiting.put(Send("a", b"", bytes(10)))
    assert len(waiting.pop("a")) == 1
    many = EarlyMessages()
    for number in range(early_messages.MAX_MESSAGES + 3):
        many.put(Send(str(number), b"", b""))
    found = many.pop([str(number) for number in range(early_messages.MAX_MESSAGES + 3)])
    assert len(found) == early_messages.MAX_MESSAGES and found[0].key == "3"
