"""The type of a topic, as used in connection headers."""

from __future__ import annotations

from typing import Any

from pyros1.wire.handshake import ANY, TopicType


def topic_type(message_class: type[Any]) -> TopicType:
    """Return the type of a message class for connection headers."""
    if message_class._type == ANY:
        return TopicType(ANY, ANY, "")
    return TopicType(message_class._type, message_class._md5sum, message_class._full_text)
