"""Messages as bytes and back, by the methods that programs know from stock."""

from __future__ import annotations

import io
import struct
from typing import Any


def encode(message: Any) -> bytes:
    """Return the encoded body of a message."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def encode_frame(message: Any) -> bytes:
    """Return a message as TCPROS sends it: length and body."""
    body = encode(message)
    return struct.pack("<I", len(body)) + body


def decode(cls: Any, body: bytes) -> Any:
    """Return the message of that class whose encoded body begins with these bytes."""
    return cls().deserialize(body)
