"""Encoded messages with faults that stock accepts: strings that are not UTF-8, and a wrong end.

A message is not lost because of a letter in one of its strings. What is not UTF-8 becomes U+FFFD, as in stock (G20),
and this is reported once for each type: by the handler ``rosmsg`` of `codecs.register_error`, if a program has one (our
genpy has stock's), else as a UnicodeWarning. Programs that turn warnings into errors refuse such messages.

Bytes behind a message are ignored. If bytes are missing at the end of the last string or byte array, it is shorter; so
is an array of a fixed length, as in stock.
"""

from __future__ import annotations

import codecs
import contextlib
import warnings
from collections.abc import Iterator
from typing import Any

from pyros1.ground.errors import DeserializationError, LengthError, MessageError
from pyros1.msgs.base import Buffer, Message, View
from pyros1.msgs.check import Walk, decoding_error

HANDLER = "rosmsg"
"""Name of the error handler that genpy registers with `codecs`."""


def accept_end(cls: type[Message], surplus: int, exact: bool) -> None:
    """Check how many bytes are behind a message.

    Args:
        cls: its class.
        surplus: number of bytes; negative: this many are missing.
        exact: whether a surplus is an error.

    Raises:
        LengthError: there is a surplus, and it is an error.
        ValueError: bytes are missing.
    """
    if surplus < 0:
        raise ValueError("size")
    if exact:
        raise LengthError(cls._type, surplus)


def decode_repaired(
    cls: type[Message], buffer: Buffer, start: int, end: int, exact: bool, view: View | None = None
) -> Any:
    """Decode a message that could not be decoded as it is; arguments as for the decoders of message classes.

    Raises:
        LengthError: its last string or byte array is cut off, and ``exact`` is true.
        DeserializationError: there are other faults.
    """
    body = bytes(memoryview(buffer)[start:end])
    cut: list[int] = []
    try:
        repaired_body = repair_strings(cls, body)
    except DeserializationError as error:
        repaired_body, missing, cut = restore_end(cls, body)
        if not missing:
            raise error from error.__cause__
        if exact:
            raise LengthError(cls._type, -missing) from None
    if repaired_body == body:
        raise decoding_error(cls, body, 0, len(body))
    if view is None:
        message = cls._decode(repaired_body, 0, len(repaired_body), exact)
    else:
        message = cls._decode_arrays(repaired_body, 0, len(repaired_body), view, exact)
    if cut:
        _shorten(message, cut)
    return message


def repair_strings(cls: type[Message], data: Buffer) -> bytes:
    """Return an encoded message with UTF-8 in all its strings.

    Args:
        cls: its class.
        data: the encoded message; bytes behind it stay.

    Raises:
        DeserializationError: it is too short, or its strings must not be repaired.
    """
    walk = _RepairWalk(cls, data)
    try:
        walk.message(cls, "")
    except MessageError as error:
        raise DeserializationError(cls._type, walk.position, str(error)) from error
    return walk.result()


def restore_end(cls: type[Message], data: bytes) -> tuple[bytes, int, list[int]]:
    """Complete a message whose last string or byte array is cut off.

    Args:
        cls: the message's class.
        data: the encoded message.

    Returns:
        The message: the length of the string or array is corrected; behind it, those of fixed length are filled with
        zeros. Then the number of bytes that were missing; 0 if something else is wrong. Then the lengths that the last
        byte arrays of fixed length had.
    """
    walk = _TruncationWalk(memoryview(data))
    try:
        walk.message(cls, "")
    except MessageError:
        return data, 0, []
    if walk.count_at is not None:
        length = (walk.whole - walk.count_at - 4).to_bytes(4, "little")
        data = b"".join((data[: walk.count_at], length, data[walk.count_at + 4 :]))
    return data + bytes(walk.zeros), walk.missing, walk.cut


class _TruncationWalk(Walk):
    """A walk that finds the strings and byte arrays at the end that are cut off.

    Attributes:
        missing: the number of missing bytes.
        whole: the size of the data.
        count_at: where the length of a string or array is that is cut off, if it is not fixed.
        zeros: number of missing bytes in arrays of fixed length.
        cut: the lengths that are left of these.
    """

    def __init__(self, data: memoryview) -> None:
        super().__init__(data)
        self.whole = len(data)
        self.missing = self.zeros = 0
        self.count_at: int | None = None
        self.cut: list[int] = []

    def field(self, cls: type[Message], slot_type: str, name: str) -> None:
        base, bracket, count = slot_type.partition("[")
        if bracket and base in ("uint8", "char"):
            if count == "]":
                self._take(self.count(name))
            else:
                self._take_fixed(int(count[:-1]))
        else:
            super().field(cls, slot_type, name)

    def single(self, cls: type[Message], base: str, name: str) -> None:
        if base == "string":
            self._take(self.count(name))
        else:
            super().single(cls, base, name)

    def elements(self, cls: type[Message], base: str, number: int, what: str) -> None:
        """Also visit each element of an array of messages of fixed size, if it is cut off."""
        for _ in range(number):
            self.single(cls, base, what)

    def _take(self, size: int) -> None:
        if size > self.remaining:
            self.count_at = self.position - 4
        self._skip(size)

    def _take_fixed(self, size: int) -> None:
        if size > self.remaining:
            self.cut.append(self.remaining)
            self.zeros += size - self.remaining
        self._skip(size)

    def _skip(self, size: int) -> None:
        self.missing += max(size - self.remaining, 0)
        self.position += min(size, self.remaining)


def _shorten(message: Message, lengths: list[int]) -> None:
    """Cut the last byte arrays of fixed length to these lengths."""
    places = list(_fixed_bytes(message))
    for (owner, name), length in zip(places[-len(lengths) :], lengths, strict=True):
        setattr(owner, name, getattr(owner, name)[:length])


def _fixed_bytes(message: Message) -> Iterator[tuple[Message, str]]:
    """Yield the byte arrays of fixed length in a message: the messages that have them, and the fields' names."""
    for name, slot_type in zip(message.__slots__, message._slot_types, strict=True):
        base, bracket, count = slot_type.partition("[")
        value = getattr(message, name)
        if bracket and base in ("uint8", "char"):
            if count != "]":
                yield message, name
        elif base in message._classes:
            for part in value if bracket else [value]:
                yield from _fixed_bytes(part)


class _RepairWalk(Walk):
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
        """Return the name of the error handler, which has reported this, or will."""
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
