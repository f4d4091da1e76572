"""Which ROS 2 publishers are gone, so that their last messages are not kept any longer."""

from __future__ import annotations

import pytest

from pyros1.ros2.bridge import sources
from pyros1.ros2.bridge.sources import GRACE, Ros2Publishers, Tokens
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2.zenoh.tokens import Entity, Kind, encode_token, gid

FOREIGN = bytes(range(16))
"""A GID that is not made from a token."""


def tokens(*publishers: tuple[str, int], latched: bool = True) -> Tokens:
    """Return the publishers with these sessions and numbers."""
    entities = [
        Entity(0, zid, 0, number, Kind.PUBLISHER, "n", topic="/a", type="p/msg/T", hash="h", qos=Qos(True, latched))
        for zid, number in publishers
    ]
    return {encode_token(entity): entity for entity in entities}


def own_gid(zid: str, number: int) -> bytes:
    return gid(next(iter(tokens((zid, number)))))


def gone(known: Ros2Publishers, there: Tokens, now: float) -> list[int]:
    return [each.source[2] for each in known.pop_gone(lambda topic: there, now)]


def test_a_gid_that_is_made_from_a_token() -> None:
    known = Ros2Publishers()
    numbers = [known.get("/a", own_gid("ab", number), "ab", 0.0)[0][2] for number in (1, 2)]
    assert gone(known, tokens(("ab", 1), ("ab", 2)), GRACE) == []
    assert gone(known, tokens(("ab", 2), ("ab", 3)), GRACE) == numbers[:1], "another one of its session is there"
    assert gone(known, tokens(("ab", 2)), GRACE) == []


def test_a_foreign_gid_lasts_as_long_as_its_session() -> None:
    known = Ros2Publishers()
    number = known.get("/a", FOREIGN, "ab", 0.0)[0][2]
    assert gone(known, tokens(("ab", 1), ("cd", 2)), GRACE) == []
    assert gone(known, tokens(("cd", 2)), GRACE) == [number]


def test_a_foreign_gid_of_an_unknown_session_lasts_as_long_as_any_latched_publisher() -> None:
    known = Ros2Publishers()
    number = known.get("/a", FOREIGN, "", 0.0)[0][2]
    assert gone(known, tokens(("cd", 2)), GRACE) == []
    assert gone(known, tokens(("cd", 2), latched=False), GRACE) == [number]


def test_a_new_message_is_kept_for_a_while() -> None:
    known = Ros2Publishers()
    number = known.get("/a", FOREIGN, "ab", 0.0)[0][2]
    known.get("/a", FOREIGN, "ab", 10.0)
    assert known.must_check
    assert gone(known, {}, 10.0 + GRACE / 2) == [] and known.must_check
    assert gone(known, {}, 10.0 + GRACE) == [number] and not known.must_check


def test_what_is_not_latched_is_not_forgotten() -> None:
    known = Ros2Publishers()
    source, _ = known.get("/a", b"", "ab", 0.0)
    assert gone(known, {}, 100.0) == [] and known.get("/a", b"", "ab", 101.0) == (source, None)


def test_the_oldest_is_forgotten_if_there_are_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "MAX_SOURCES", 2)
    known = Ros2Publishers()
    first, second = (known.get("/a", bytes([number]) * 16, "", 0.0)[0] for number in (1, 2))
    assert known.get("/a", b"\1" * 16, "", 1.0) == (first, None)
    assert known.get("/a", b"\3" * 16, "", 1.0)[1] == ("/a", second)
