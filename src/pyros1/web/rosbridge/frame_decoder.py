"""Decodes a client's frames into operations, joining fragments and unpacking PNG images (no I/O, bounded memory)."""

from __future__ import annotations

import json
from typing import Any

from pyros1.web.client_json import loads
from pyros1.web.rosbridge import png
from pyros1.web.rosbridge.operations import Action, BridgeError, Id, Part, parse

MAX_FRAME = 10_000_000
"""Maximum size in bytes of a frame, also after joining its fragments or unpacking it from a PNG image."""
MAX_PARTS = 10_000
_MAX_PARTIAL_FRAMES = 32
"""Maximum number of frames whose fragments are being collected; if another frame begins, the oldest is dropped."""
_MAX_NESTING = 3
"""Maximum nesting of frames: fragments of a PNG image that contains an operation. Deeper nesting is never needed."""


class FrameDecoder:
    """Decodes the frames of one client."""

    def __init__(self) -> None:
        self._partial_frames: dict[tuple[str, Id], _PartialFrame] = {}

    def decode(self, frame: str | bytes) -> tuple[Id, Action] | None:
        """Return the id and the operation that a frame contains or completes; None if fragments are still missing.

        Raises:
            BridgeError: the frame is not a valid operation.
        """
        for _ in range(_MAX_NESTING):
            text = _to_text(frame)
            value = _parse_json(text)
            id, action = parse(value)
            if not isinstance(action, Part):
                if "\\ud" in text or "\\uD" in text:
                    _check_unicode(value, id)
                return id, action
            try:
                joined = self._join(id, action)
                if joined is None:
                    return None
                frame = png.unpack(joined, MAX_FRAME) if action.op == "png" else joined
            except BridgeError as error:
                raise BridgeError(f"{action.op}: {error}", id) from None
        raise BridgeError("fragments and PNG images are nested too deeply")

    def _join(self, id: Id, part: Part) -> str | None:
        if part.total == 1:
            return part.data
        if part.total > MAX_PARTS:
            raise BridgeError(f"a frame can have at most {MAX_PARTS} fragments")
        key = (part.op, id)
        partial_frame = self._partial_frames.get(key)
        if partial_frame is None or partial_frame.total != part.total:
            while len(self._partial_frames) >= _MAX_PARTIAL_FRAMES:
                self._partial_frames.pop(next(iter(self._partial_frames)))
            partial_frame = self._partial_frames[key] = _PartialFrame(part.total)
        partial_frame.add(part)
        while sum(each.size for each in self._partial_frames.values()) > MAX_FRAME:
            oldest = next(iter(self._partial_frames))
            del self._partial_frames[oldest]
            if oldest == key:
                raise BridgeError(f"the fragments have more than {MAX_FRAME} bytes")
        if len(partial_frame.parts) < partial_frame.total:
            return None
        del self._partial_frames[key]
        return "".join(partial_frame.parts[number] for number in range(partial_frame.total))


class _PartialFrame:
    def __init__(self, total: int) -> None:
        self.total = total
        self.parts: dict[int, str] = {}
        self.size = 0

    def add(self, part: Part) -> None:
        self.size += len(part.data) - len(self.parts.get(part.number, ""))
        self.parts[part.number] = part.data


def _to_text(frame: str | bytes) -> str:
    if len(frame) > MAX_FRAME:
        raise BridgeError(f"a frame can have at most {MAX_FRAME} bytes")
    try:
        if isinstance(frame, bytes):
            return frame.decode("utf-8")
        # A JavaScript program may have split a string within a surrogate pair.
        return frame if frame.isascii() else frame.encode("utf-16-le", "surrogatepass").decode("utf-16-le")
    except ValueError:
        raise BridgeError("a frame must be JSON, in UTF-8") from None


def _parse_json(text: str) -> Any:
    try:
        return loads(text)
    except ValueError:
        raise BridgeError("a frame must be JSON, in UTF-8") from None


def _check_unicode(value: Any, id: Id) -> None:
    try:
        json.dumps(value, ensure_ascii=False).encode("utf-8")
    except ValueError:
        raise BridgeError("a string contains half of a surrogate pair, such as \\ud800", id) from None
