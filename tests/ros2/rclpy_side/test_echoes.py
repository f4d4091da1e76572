"""Own messages that come back."""

from __future__ import annotations

import pytest

from pyros1.ros2.rclpy_side import echoes as module
from pyros1.ros2.rclpy_side.echoes import Echoes

OURS, THEIRS = b"1" * 16, b"2" * 16


def test_by_publisher() -> None:
    asked = []

    def look_up(topic: str) -> dict[bytes, bool]:
        asked.append(topic)
        return {OURS: True, THEIRS: False}

    echoes = Echoes(look_up, True)
    assert echoes.is_echo("/a", b"", OURS) and not echoes.is_echo("/a", b"", THEIRS)
    assert asked == ["/a"], "it remembers them"
    assert not echoes.is_echo("/a", b"", b"3" * 16) and not echoes.is_echo("/a", b"", b"3" * 16)
    assert asked == ["/a"] * 3, "one that is not known may be known soon"


def test_not_all_publishers_are_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_GIDS", 3)
    asked = []

    def look_up(topic: str) -> dict[bytes, bool]:
        asked.append(topic)
        return {topic.encode(): True}

    echoes = Echoes(look_up, True)
    for topic in ("/0", "/0", "/1", "/2", "/3", "/0"):
        assert echoes.is_echo(topic, b"", topic.encode())
    assert asked == ["/0", "/1", "/2", "/3", "/0"]


def test_by_bytes() -> None:
    echoes = Echoes(lambda _: {}, False)
    echoes.on_send("/a", b"early")
    echoes.set_topics({"/a"})
    for body in (b"x", b"x", b"y"):
        echoes.on_send("/a", body)
    echoes.on_send("/b", b"x")
    came = [echoes.is_echo("/a", body, b"") for body in (b"early", b"x", b"y", b"x", b"x", b"z")]
    assert came == [False, True, True, True, False, False]
    assert not echoes.is_echo("/b", b"x", b""), "nobody here subscribes to it"
    echoes.on_send("/a", b"x")
    echoes.set_topics({"/a", "/b"})
    assert echoes.is_echo("/a", b"x", b""), "it goes on expecting"
    echoes.on_send("/a", b"x")
    echoes.set_topics(set())
    echoes.set_topics({"/a"})
    assert not echoes.is_echo("/a", b"x", b""), "it has forgotten them"


def test_not_all_messages_are_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_SENT", 2)
    echoes = Echoes(lambda _: {}, False)
    echoes.set_topics({"/a"})
    for body in (b"1", b"2", b"3"):
        echoes.on_send("/a", body)
    assert [echoes.is_echo("/a", body, b"") for body in (b"1", b"2", b"3")] == [False, True, True]


def test_a_middleware_that_does_not_tell_publishers() -> None:
    echoes = Echoes(lambda _: {}, True)
    echoes.set_topics({"/a"})
    echoes.on_send("/a", b"x")
    assert not echoes.is_echo("/a", b"x", b""), "it is noticed now"
    echoes.on_send("/a", b"y")
    assert echoes.is_echo("/a", b"y", b"")
