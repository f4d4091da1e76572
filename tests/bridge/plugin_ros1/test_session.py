"""The session of a bridge of the dialect: replies to calls."""

from __future__ import annotations

import weakref

from pyros1.bridge.plugin_ros1.session import FirstReply


class Reply:
    """A reply that may be large."""


def test_only_the_first_reply_is_kept() -> None:
    reply = FirstReply()
    first, second = Reply(), Reply()
    reply.put(first)
    reply.put(second)
    reply.put(None)
    reference = weakref.ref(second)
    del second
    assert reference() is None
    assert reply.get(0.0) is first and reply.get(0.0) is None
    reply.put(Reply())
    assert reply.get(0.0) is None


def test_no_reply() -> None:
    reply = FirstReply()
    assert reply.get(0.0) is None
    reply.put(Reply())
    assert reply.get(0.0) is None
