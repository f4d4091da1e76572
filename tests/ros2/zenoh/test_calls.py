"""Replies to calls of services that nobody waits for."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from pyros1.ground.errors import ServiceRefusal
from pyros1.ros2.zenoh.calls import LaterReply


def reply(body: bytes) -> Any:
    return SimpleNamespace(ok=SimpleNamespace(payload=SimpleNamespace(to_bytes=lambda: body)), err=None)


def test_only_the_first_reply_counts() -> None:
    got: list[bytes | ServiceRefusal] = []
    later = LaterReply(got.append)
    assert not later.is_done
    later.put(reply(b"first"))
    later.put(reply(b"second"))
    later.put(None)
    assert got == [b"first"] and later.is_done


def test_no_reply() -> None:
    got: list[bytes | ServiceRefusal] = []
    LaterReply(got.append).put(None)
    assert isinstance(got[0], ServiceRefusal) and "does not respond" in str(got[0])


def test_what_was_withdrawn_passes_on_nothing() -> None:
    got: list[bytes | ServiceRefusal] = []
    later = LaterReply(got.append)
    assert later.withdraw() and later.is_done and not later.withdraw()
    later.put(reply(b"late"))
    assert got == []
