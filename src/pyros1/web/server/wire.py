"""The protocol between a page and its server, over one WebSocket (no I/O).

A page sends requests in JSON. A request is one of ::

    {"call": NAME, "id": N, "args": {...}}        make a single request
    {"open": VIEW, "stream": N, "args": {...}}    start a stream of a view's data
    {"change": N, "args": {...}}                  change the arguments of stream N
    {"next": N}                                   the last push of stream N was displayed: send the next one
    {"close": N}                                  end stream N

The server responds with ``{"id": N, "result": ...}`` or ``{"id": N, "error": TEXT}``, and pushes ``{"stream": N,
"data": ...}`` or ``{"stream": N, "error": TEXT}``. A stream has at most one push in flight, so a slow page gets fewer
pushes, each with the latest data. A push with numbers or images is binary: the header's length (4 bytes, little
endian), the header ``{"stream": N, "data": ...}`` in JSON, spaces up to a multiple of 8 bytes, and then the bytes of
the numbers or images.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Any

from pyros1.ground.errors import Error
from pyros1.web.client_json import loads

MAX_REQUEST_LENGTH = 1 << 20
"""Maximum number of characters in a request, which may contain a message to publish."""
MAX_ID = 1 << 31
_ALIGNMENT = 8


class RequestError(Error):
    """A page's request is invalid or has failed. The error message is displayed on the page."""


@dataclass(frozen=True)
class Call:
    """Make a single request."""

    id: int
    name: str
    args: dict[str, Any]


@dataclass(frozen=True)
class Open:
    """Start a stream of a view's data."""

    stream: int
    view: str
    args: dict[str, Any]


@dataclass(frozen=True)
class Change:
    """Change the arguments of a stream."""

    stream: int
    args: dict[str, Any]


@dataclass(frozen=True)
class Next:
    """Send the stream's next push, since the page has displayed the last one."""

    stream: int


@dataclass(frozen=True)
class Close:
    """End a stream."""

    stream: int


Request = Call | Open | Change | Next | Close


@dataclass(frozen=True)
class Push:
    """A view's current data.

    Attributes:
        data: a JSON value.
        blob: bytes that belong to the value; None for a text frame.
    """

    data: Any
    blob: bytes | None = None


def parse(text: str | bytes) -> Request:
    """Parse a frame from a page, and return the request in it.

    Raises:
        RequestError: the frame is not a valid request.
    """
    if not isinstance(text, str):
        raise RequestError("a request must be a text frame")
    if len(text) > MAX_REQUEST_LENGTH:
        raise RequestError(f"a request can have at most {MAX_REQUEST_LENGTH} characters")
    try:
        value = loads(text)
    except ValueError:
        raise RequestError("a request must be JSON") from None
    if not isinstance(value, dict):
        raise RequestError("a request must be a JSON object")
    args = value.get("args", {})
    if not isinstance(args, dict):
        raise RequestError("args must be a JSON object")
    match value:
        case {"call": str(name), "id": number}:
            return Call(_number(number), name, args)
        case {"open": str(name), "stream": number}:
            return Open(_number(number), name, args)
        case {"change": number}:
            return Change(_number(number), args)
        case {"next": number}:
            return Next(_number(number))
        case {"close": number}:
            return Close(_number(number))
    raise RequestError("a request must be a call, open, change, next or close")


def _number(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < MAX_ID:
        raise RequestError("ids of calls and streams must be integers that are not negative")
    return value


def result(call_id: int, value: Any) -> str:
    """Return the frame with a call's result."""
    return _dumps({"id": call_id, "result": value})


def failure(call_id: int, text: str) -> str:
    """Return the frame that says why a call failed."""
    return _dumps({"id": call_id, "error": text})


def push(stream: int, update: Push) -> str | bytes:
    """Return the frame that pushes a view's data to a page."""
    text = _dumps({"stream": stream, "data": update.data})
    if update.blob is None:
        return text
    header = text.encode("ascii")
    header += b" " * (-(4 + len(header)) % _ALIGNMENT)
    return struct.pack("<I", len(header)) + header + update.blob


def problem(stream: int, text: str) -> str:
    """Return the frame that reports a problem with a stream."""
    return _dumps({"stream": stream, "error": text})


_dumps = json.JSONEncoder(ensure_ascii=True, allow_nan=False, separators=(",", ":")).encode
