"""The type of a topic, as used in connection headers."""

from __future__ import annotations

from typing import Any

from pyros1.wire.handshake import WILDCARD, TopicType


def topic_type(message_class: type[Any]) -> TopicType:
    """Return a message class's type, for use in connection headers."""
    if message_class._type == WILDCARD:
        return TopicType(WILDCARD, WILDCARD, "")
    return TopicType(message_class._type, message_class._md5sum, message_class._full_text)
