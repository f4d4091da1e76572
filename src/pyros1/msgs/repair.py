"""Repairs encoded messages with faults that stock accepts: strings that are not UTF-8, and a wrong length.

A message is not lost because of one character in a string. Bytes that are not UTF-8 become U+FFFD, as in stock ROS
(G20). This is reported once per type: by the error handler ``rosmsg`` of `codecs.register_error`, if there is one
(our genpy module registers stock's handler), otherwise as a UnicodeWarning. Programs that turn warnings into errors
reject such messages.

Bytes after a message are ignored. If bytes are missing at the end of the last string or byte array, it becomes shorter,
even if it is an array of fixed length, as in stock ROS.
"""

from __future__ import annotations

import codecs
import contextlib
import warnings
from collections.abc import Iterator
from typing import Any

from pyros1.ground.errors import DeserializationError, LengthError, MessageError
from pyros1.msgs.base import Buffer, Message, View
from pyros1.msgs.check import MessageWalker, decoding_error
from pyros1.msgs.records import is_record_array

HANDLER_NAME = "rosmsg"
"""Name of the error handler that genpy registers with `codecs`."""


def check_end(cls: type[Message], surplus: int, exact: bool) -> None:
    """Check the number of bytes after a message.

    Args:
        cls: the message's class.
        surplus: number of bytes after the message; negative if bytes are missing.
        exact: whether a surplus is an error.

    Raises:
        LengthError: there is a surplus, and ``exact`` is true.
        ValueError: bytes are missing.
    """
    if surplus < 0:
        raise ValueError("size")
    if exact:
        raise LengthError(cls._type, surplus)


def decode_repaired(
    cls: type[Message], buffer: Buffer, start: int, end: int, exact: bool, view: View | None = None
) -> Any:
    """Repair and decode a message that could not be decoded; arguments as for the decoders of message classes.

    Raises:
        LengthError: the last string or byte array is truncated, and ``exact`` is true.
        DeserializationError: the message has other faults.
    """
    body = bytes(memoryview(buffer)[start:end])
    cut_lengths: list[int] = []
    try:
        repaired_body = repair_strings(cls, body)
    except DeserializationError as error:
        repaired_body, missing, cut_lengths = restore_end(cls, body)
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
    if cut_lengths:
        _shorten(message, cut_lengths)
    return message


def repair_strings(cls: type[Message], data: Buffer) -> bytes:
    """Return an encoded message in which all strings are valid UTF-8.

    Args:
        cls: the message's class.
        data: the encoded message; bytes after it are kept.

    Raises:
        DeserializationError: the message is too short, or its strings must not be repaired.
    """
    walker = _RepairWalker(cls, data)
    try:
        walker.visit_message(cls, "")
    except MessageError as error:
        raise DeserializationError(cls._type, walker.position, str(error)) from error
    return walker.result()


def restore_end(cls: type[Message], data: bytes) -> tuple[bytes, int, list[int]]:
    """Complete a message whose last string or byte array is truncated.

    Args:
        cls: the message's class.
        data: the encoded message.

    Returns:
        A tuple: the message, with the length of the string or array corrected and the arrays of fixed length after it
            filled with zeros; the number of missing bytes, 0 if something else is wrong; and the actual lengths of the
            last byte arrays of fixed length.
    """
    walker = _TruncationWalker(memoryview(data))
    try:
        walker.visit_message(cls, "")
    except MessageError:
        return data, 0, []
    if walker.length_position is not None:
        length = (walker.size - walker.length_position - 4).to_bytes(4, "little")
        data = b"".join((data[: walker.length_position], length, data[walker.length_position + 4 :]))
    return data + bytes(walker.zeros), walker.missing, walker.cut_lengths


class _TruncationWalker(MessageWalker):
    """Finds the strings and byte arrays that are truncated at the end of a message.

    Attributes:
        missing: the number of missing bytes.
        size: the size of the data.
        length_position: position of the length of the truncated string or array, unless its length is fixed.
        zeros: number of missing bytes in arrays of fixed length.
        cut_lengths: the remaining lengths of these arrays.
    """

    def __init__(self, data: memoryview) -> None:
        super().__init__(data)
        self.size = len(data)
        self.missing = self.zeros = 0
        self.length_position: int | None = None
        self.cut_lengths: list[int] = []

    def visit_field(self, cls: type[Message], slot_type: str, name: str) -> None:
        base, bracket, count = slot_type.partition("[")
        if bracket and base in ("uint8", "char"):
            if count == "]":
                self._skip_variable(self.read_length(name))
            else:
                self._skip_fixed(int(count[:-1]))
        else:
            super().visit_field(cls, slot_type, name)

    def visit_element(self, cls: type[Message], base: str, name: str) -> None:
        if base == "string":
            self._skip_variable(self.read_length(name))
        else:
            super().visit_element(cls, base, name)

    def visit_elements(self, cls: type[Message], base: str, element_count: int, description: str) -> None:
        """Visit each element of a truncated array, even if its messages have a fixed size."""
        for _ in range(element_count):
            self.visit_element(cls, base, description)

    def _skip_variable(self, size: int) -> None:
        if size > self.remaining:
            self.length_position = self.position - 4
        self._skip_available(size)

    def _skip_fixed(self, size: int) -> None:
        if size > self.remaining:
            self.cut_lengths.append(self.remaining)
            self.zeros += size - self.remaining
        self._skip_available(size)

    def _skip_available(self, size: int) -> None:
        self.missing += max(size - self.remaining, 0)
        self.position += min(size, self.remaining)


def _shorten(message: Message, lengths: list[int]) -> None:
    """Shorten the last byte arrays of fixed length to the given lengths."""
    fields = list(_fixed_bytes(message))
    for (owner, name), length in zip(fields[-len(lengths) :], lengths, strict=True):
        if owner is not None:
            setattr(owner, name, getattr(owner, name)[:length])


def _fixed_bytes(message: Message) -> Iterator[tuple[Message | None, str]]:
    """Yield the byte arrays of fixed length in a message, each as (message that contains it, name of the field); the
    message is None if it is an element of a numpy array.
    """
    for name, slot_type in zip(message.__slots__, message._slot_types, strict=True):
        base, bracket, count = slot_type.partition("[")
        value = getattr(message, name)
        if bracket and base in ("uint8", "char"):
            if count != "]":
                yield message, name
        elif is_record_array(value):  # its elements keep the zeros at their ends
            yield from [(None, name)] * (len(value) * _num_fixed_bytes(message._classes[base]))
        elif base in message._classes:
            for part in value if bracket else [value]:
                yield from _fixed_bytes(part)


def _num_fixed_bytes(cls: type[Message]) -> int:
    """Return the number of byte arrays of fixed length in a message of fixed size."""
    total = 0
    for slot_type in cls._slot_types:
        base, _, count = slot_type.partition("[")
        if base in cls._classes:
            total += _num_fixed_bytes(cls._classes[base]) * (int(count[:-1]) if count else 1)
        elif count and base in ("uint8", "char"):
            total += 1
    return total


class _RepairWalker(MessageWalker):
    """Walks through an encoded message, and copies it with repaired strings."""

    def __init__(self, cls: type[Message], data: Buffer) -> None:
        super().__init__(memoryview(data))
        self._type = cls._type
        self._pieces: list[Buffer] = []
        self._copied = 0

    def visit_string(self, begin: int, description: str) -> None:
        data = self.data[begin : self.position]
        try:
            str(data, "utf-8")
        except UnicodeDecodeError as error:
            offset, reason = error.start, error.reason  # does not keep the error, which contains a copy of the data
        else:
            return
        try:
            handler = self._handler()
        except UnicodeWarning:
            self.position = begin + offset
            raise MessageError(f"{description} is not UTF-8: {reason}") from None
        text = str(data, "utf-8", handler).encode("utf-8", "replace")
        self._pieces += (self.data[self._copied : begin - 4], len(text).to_bytes(4, "little"), text)
        self._copied = self.position

    def _handler(self) -> str:
        """Return the name of the error handler; if that handler does not report the repair, do so."""
        try:
            handler = codecs.lookup_error(HANDLER_NAME)
        except LookupError:
            warnings.warn(
                f"{self._type}: bytes in strings that are not UTF-8 are replaced", UnicodeWarning, stacklevel=1
            )
            return "replace"
        with contextlib.suppress(AttributeError):
            handler.msg_type = self._type  # type: ignore[attr-defined]  # stock's handler reports it
        return HANDLER_NAME

    def result(self) -> bytes:
        return b"".join([*self._pieces, self.data[self._copied :]])
