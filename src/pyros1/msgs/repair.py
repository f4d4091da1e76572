"""Messages with strings that are not UTF-8, such as Latin-1 from old programs: replacement characters make them so.

A message is not lost because of a letter in one of its strings. What is not UTF-8 becomes U+FFFD, as in stock (G20),
and this is told once for each type: by the handler ``rosmsg`` of `codecs.register_error`, if a program has one (our
genpy has stock's), else as a UnicodeWarning. Programs that make errors of warnings refuse such messages.

In programs that use genpy, `deserialize` also takes data that end within the last string or bytes; they become shorter.
"""

from __future__ import annotations

import codecs
import contextlib
import warnings
from typing import Any

from pyros1.ground.errors import DeserializationError, MessageError
from pyros1.msgs.base import Buffer, Message, View
from pyros1.msgs.check import Walk

HANDLER = "rosmsg"
"""Name of the error handler that genpy registers with `codecs`."""


def decode_repaired(cls: type[Message], buffer: Buffer, start: int, end: int, view: View | None = None) -> Any:
    """Decode a message with strings that are not UTF-8; arguments as for the decoders of message classes.

    Raises:
        DeserializationError: there are other faults.
    """
    body = repaired(cls, memoryview(buffer)[start:end])
    return cls._decode(body, 0, len(body)) if view is None else cls._decode_arrays(body, 0, len(body), view)


def repaired(cls: type[Message], data: Buffer) -> bytes:
    """Return an encoded message with UTF-8 in all its strings.

    Args:
        cls: its class.
        data: the encoded message; bytes behind it stay.

    Raises:
        DeserializationError: it is too short, or its strings must not be repaired.
    """
    walk = _Repair(cls, data)
    try:
        walk.message(cls, "")
    except MessageError as error:
        raise DeserializationError(cls._type, walk.position, str(error)) from error
    return walk.result()


def completed(cls: type[Message], data: Buffer) -> bytes | None:
    """Return an encoded message of which only the end of its last string or bytes is missing, with the true length.

    Args:
        cls: its class.
        data: the encoded message.

    Returns:
        None if something else is wrong, or the program does not use genpy.
    """
    walk = _Cut(memoryview(data))
    try:
        codecs.lookup_error(HANDLER)
        walk.message(cls, "")
    except (LookupError, MessageError):
        return None
    if walk.cut is None:
        return None
    return b"".join((data[: walk.cut], (len(data) - walk.cut - 4).to_bytes(4, "little"), data[walk.cut + 4 :]))


class _Cut(Walk):
    """A walk that finds the length of the last string or bytes, if these are cut off."""

    cut: int | None = None

    def field(self, cls: type[Message], slot_type: str, name: str) -> None:
        if slot_type in ("string", "uint8[]", "char[]"):
            self._take(self.count(name))
        else:
            super().field(cls, slot_type, name)

    def single(self, cls: type[Message], base: str, name: str) -> None:
        if base == "string":
            self._take(self.count(name))
        else:
            super().single(cls, base, name)

    def _take(self, size: int) -> None:
        if size > self.left:
            self.cut = self.position - 4
        self.position += min(size, self.left)


class _Repair(Walk):
    """A walk that makes a copy of the message."""

    def __init__(self, cls: type[Message], data: Buffer) -> None:
        super().__init__(memoryview(data))
        self._type = cls._type
        self._pieces: list[Buffer] = []
        self._copied = 0

    def text(self, begin: int, what: str) -> None:
        data = self.data[begin : self.position]
        try:
            str(data, "utf-8")
        except UnicodeDecodeError as error:
            place, reason = error.start, error.reason  # without the error, which holds a copy of the data
        else:
            return
        try:
            handler = self._handler()
        except UnicodeWarning:
            self.position = begin + place
            raise MessageError(f"{what} is not UTF-8: {reason}") from None
        text = str(data, "utf-8", handler).encode("utf-8", "replace")
        self._pieces += (self.data[self._copied : begin - 4], len(text).to_bytes(4, "little"), text)
        self._copied = self.position

    def _handler(self) -> str:
        """Return the name of the error handler, which has told about this, or will."""
        try:
            handler = codecs.lookup_error(HANDLER)
        except LookupError:
            warnings.warn(f"{self._type}: bytes in texts that are not UTF-8 are replaced", UnicodeWarning, stacklevel=1)
            return "replace"
        with contextlib.suppress(AttributeError):
            handler.msg_type = self._type  # type: ignore[attr-defined]  # stock's handler names it
        return HANDLER

    def result(self) -> bytes:
        return b"".join([*self._pieces, self.data[self._copied :]])
