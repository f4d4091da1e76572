"""What has come from ROS 2 and waits."""

from __future__ import annotations

import pytest

from pyros1.ros2.bridge import arrivals
from pyros1.ros2.bridge.arrivals import Arrivals
from pyros1.ros2.zenoh.names import DataKey

KEY = DataKey(0, "/a", "std_msgs/msg/String", "RIHS01_x")


def test_tokens_go_first() -> None:
    waiting = Arrivals()
    assert waiting.is_empty and waiting.pop() == (None, None)
    waiting.put_message(KEY, b"1", b"a")
    waiting.put_token("x", True)
    assert [waiting.pop() for _ in range(3)] == [
        (("x", True), None),
        (None, (KEY, b"1", b"a", "")),
        (None, None),
    ]


def test_the_oldest_messages_are_dropped() -> None:
    waiting = Arrivals(max_bytes=10, max_messages=3)
    for number in range(4):
        waiting.put_message(KEY, b"%d" % number, b"")
    assert waiting.dropped == 1
    waiting.put_message(KEY, bytes(20), b"", "")
    assert waiting.dropped == 4
    assert waiting.pop()[1] == (KEY, bytes(20), b"", "") and waiting.is_empty
    waiting.put_message(KEY, bytes(10), b"")
    assert waiting.dropped == 4


def test_a_flood_of_tokens_is_bounded() -> None:
    waiting = Arrivals()
    for number in range(arrivals.MAX_TOKENS + 5):
        waiting.put_token(str(number), True)
    assert waiting.dropped == 5


@pytest.mark.slow
def test_that_somebody_is_gone_is_never_lost() -> None:
    waiting = Arrivals()
    waiting.put_token("x", True)
    assert waiting.pop() == (("x", True), None)
    for number in range(arrivals.MAX_TOKENS):
        waiting.put_token(str(number), True)
    waiting.put_token("x", False)
    tokens = []
    while not waiting.is_empty:
        tokens.append(waiting.pop()[0])
    assert tokens[-1] == ("x", False)
    waiting.put_token("y", True)
    assert waiting.pop() == (("y", True), None), "there is room again"


def test_only_the_last_word_about_a_token_waits() -> None:
    waiting = Arrivals()
    for _ in range(arrivals.MAX_TOKENS):
        waiting.put_token("x", True)
        waiting.put_token("x", False)
    assert waiting.is_empty and waiting.dropped == 0
    waiting.put_token("x", True)
    assert waiting.pop() == (("x", True), None)
    waiting.put_token("x", False)
    waiting.put_token("x", True)
    assert waiting.is_empty, "it is as it was"
    waiting.put_token("x", False)
    assert waiting.pop() == (("x", False), None) and waiting.is_empty
    waiting.put_token("x", False)
    assert waiting.is_empty, "it is known to be gone"


def test_what_is_too_long_to_be_a_token_does_not_wait() -> None:
    waiting = Arrivals()
    waiting.put_token("x" * 1001, True)
    assert waiting.is_empty
