"""Decodes the frames of a client to operations: joins fragments and unpacks pictures. Pure and bounded."""

from __future__ import annotations

import json
from typing import Any

from pyros1.web.json_texts import loads
from pyros1.web.rosbridge import picture
from pyros1.web.rosbridge.operations import Action, BridgeError, Id, Part, parse

MAX_FRAME = 10_000_000
"""Maximum bytes of a frame, of a reassembled text, and of the contents of a picture."""
MAX_PARTS = 10_000
_MAX_TEXTS = 32
"""Maximum number of texts being reassembled at the same time; the oldest is dropped for a new one."""
_MAX_NESTING = 3
"""Maximum nesting: a picture may come in fragments; deeper nesting has no use."""


class FrameDecoder:
    """The frames of one client."""

    def __init__(self) -> None:
        self._texts: dict[tuple[str, Id], _Text] = {}

    def decode(self, frame: str | bytes) -> tuple[Id, Action] | None:
        """Return the operation that a frame completes, with its id; None if more fragments are missing.

        Raises:
            BridgeError: the frame is not a valid operation.
        """
        for _ in range(_MAX_NESTING):
            text = _text(frame)
            value = _load(text)
            id, found = parse(value)
            if not isinstance(found, Part):
                if "\\ud" in text or "\\uD" in text:
                    _check_unicode(value, id)
                return id, found
            try:
                joined = self._join(id, found)
                if joined is None:
                    return None
                frame = picture.unpack(joined, MAX_FRAME) if found.op == "png" else joined
            except BridgeError as error:
                raise BridgeError(f"{found.op}: {error}", id) from None
        raise BridgeError("fragments and pictures are nested too deeply")

    def _join(self, id: Id, part: Part) -> str | None:
        if part.total == 1:
            return part.data
        if part.total > MAX_PARTS:
            raise BridgeError(f"a text has at most {MAX_PARTS} parts")
        key = (part.op, id)
        text = self._texts.get(key)
        if text is None or text.total != part.total:
            while len(self._texts) >= _MAX_TEXTS:
                self._texts.pop(next(iter(self._texts)))
            text = self._texts[key] = _Text(part.total)
        text.add(part)
        while sum(each.size for each in self._texts.values()) > MAX_FRAME:
            oldest = next(iter(self._texts))
            del self._texts[oldest]
            if oldest == key:
                raise BridgeError(f"the parts have more than {MAX_FRAME} bytes")
        if len(text.parts) < text.total:
            return None
        del self._texts[key]
        return "".join(text.parts[number] for number in range(text.total))


class _Text:
    def __init__(self, total: int) -> None:
        self.total = total
        self.parts: dict[int, str] = {}
        self.size = 0

    def add(self, part: Part) -> None:
        self.size += len(part.data) - len(self.parts.get(part.number, ""))
        self.parts[part.number] = part.data


def _text(frame: str | bytes) -> str:
    if len(frame) > MAX_FRAME:
        raise BridgeError(f"a frame has at most {MAX_FRAME} bytes")
    try:
        if isinstance(frame, bytes):
            return frame.decode("utf-8")
        # A JavaScript program may have split a text in the middle of a character.
        return frame if frame.isascii() else frame.encode("utf-16-le", "surrogatepass").decode("utf-16-le")
    except ValueError:
        raise BridgeError("a frame must be JSON, in UTF-8") from None


def _load(text: str) -> Any:
    try:
        return loads(text)
    except ValueError:
        raise BridgeError("a frame must be JSON, in UTF-8") from None


def _check_unicode(value: Any, id: Id) -> None:
    try:
        json.dumps(value, ensure_ascii=False).encode("utf-8")
    except ValueError:
        raise BridgeError("a string has half a character, such as \\ud800", id) from None
