"""Encoded messages with faults that stock accepts: strings that are not UTF-8, and a wrong end.

A message is not lost because of a letter in one of its strings. What is not UTF-8 becomes U+FFFD, as in stock (G20),
and this is told once for each type: by the handler ``rosmsg`` of `codecs.register_error`, if a program has one (our
genpy has stock's), else as a UnicodeWarning. Programs that make errors of warnings refuse such messages.

Bytes behind a message are ignored. If bytes are missing at the end of the last string or byte array, it is shorter.
"""

from __future__ import annotations

import codecs
import contextlib
import warnings
from typing import Any

from pyros1.ground.errors import DeserializationError, LengthError, MessageError
from pyros1.msgs.base import Buffer, Message, View
from pyros1.msgs.check import Walk, explain

HANDLER = "rosmsg"
"""Name of the error handler that genpy registers with `codecs`."""


def accept_end(cls: type[Message], surplus: int, exact: bool) -> None:
    """Check how many bytes are behind a message.

    Args:
        cls: its class.
        surplus: number of bytes; negative: so many are missing.
        exact: whether a surplus is an error.

    Raises:
        LengthError: there is a surplus, and it is an error.
        ValueError: bytes are missing.
    """
    if surplus < 0:
        raise ValueError("size")
    if exact:
        raise LengthError(cls._type, surplus)


def decode_mended(
    cls: type[Message], buffer: Buffer, start: int, end: int, exact: bool, view: View | None = None
) -> Any:
    """Decode a message that could not be decoded as it is; arguments as for the decoders of message classes.

    Raises:
        LengthError: its last string or byte array is cut off, and ``exact`` is true.
        DeserializationError: there are other faults.
    """
    body = bytes(memoryview(buffer)[start:end])
    mended, missing = completed(cls, body)
    if missing and exact:
        raise LengthError(cls._type, -missing)
    if not missing:
        mended = repaired(cls, body)
        if mended == body:
            raise explain(cls, body, 0, len(body))
    if view is None:
        return cls._decode(mended, 0, len(mended), exact)
    return cls._decode_arrays(mended, 0, len(mended), view, exact)


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


def completed(cls: type[Message], data: bytes) -> tuple[bytes, int]:
    """Correct the length of a message's last string or byte array, if only its end is missing.

    Args:
        cls: the message's class.
        data: the encoded message.

    Returns:
        The message, and the number of bytes that are missing; the same bytes and 0 if something else is wrong.
    """
    walk = _Cut(memoryview(data))
    try:
        walk.message(cls, "")
    except MessageError:
        return data, 0
    if not walk.missing:
        return data, 0
    length = (len(data) - walk.cut - 4).to_bytes(4, "little")
    return b"".join((data[: walk.cut], length, data[walk.cut + 4 :])), walk.missing


class _Cut(Walk):
    """A walk that finds the length of the last string or bytes, if these are cut off."""

    cut = missing = 0

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
            self.cut, self.missing = self.position - 4, size - self.left
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
            warnings.warn(
                f"{self._type}: bytes in strings that are not UTF-8 are replaced", UnicodeWarning, stacklevel=1
            )
            return "replace"
        with contextlib.suppress(AttributeError):
            handler.msg_type = self._type  # type: ignore[attr-defined]  # stock's handler names it
        return HANDLER

    def result(self) -> bytes:
        return b"".join([*self._pieces, self.data[self._copied :]])
