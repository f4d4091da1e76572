"""Explains why a value cannot be encoded, or bytes cannot be decoded, after a generated codec has failed.

It goes slowly through the fields in the order of the class's ``_slot_types``, and finds the first wrong one.
"""

from __future__ import annotations

import operator
import struct
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from pyros1.ground.errors import DeserializationError, MessageError, SerializationError
from pyros1.msgs.base import Buffer, Message, message_class
from pyros1.msgs.factory import MAX_EMPTY
from pyros1.msgs.spec import BUILTINS, STRUCT_CODES


class _TooLargeError(SerializationError, OverflowError):
    """A float does not fit its field. Programs for stock expect OverflowError."""


def encoding_error(cls: type[Message], message: Any, error: Exception) -> SerializationError:
    """Return the error for a message that could not be encoded.

    Args:
        cls: its class.
        message: the value.
        error: the encoder's error; its text is used if no wrong field is found.
    """
    try:
        _check_message(cls, message, "")
    except SerializationError as found:
        return found
    return SerializationError(f"cannot encode {cls._type}: {error}")


def check(message: Message, error: Exception | None = None) -> None:
    """Check all fields of a message.

    Raises:
        SerializationError: the text names the first field whose value does not fit, or is that of ``error``, if given.
    """
    _check_message(message_class(type(message)), message, "")
    if error is not None:
        raise SerializationError(f"{type(error)}: '{error}' when writing '{message}'")


def check_value(name: str, slot_type: str, value: Any, find: Callable[[str], type[Message] | None]) -> None:
    """Check the value of a field.

    Args:
        name: name of the field.
        slot_type: its type, as in ``_slot_types``.
        value: the value.
        find: returns the class of a message type, None if there is none.

    Raises:
        SerializationError: the value does not fit; the message names the field.
    """
    base = slot_type.partition("[")[0]
    if base not in BUILTINS:
        cls = find(base)
        if cls is None:
            raise SerializationError(f"field {name} has the type {slot_type}, which is unknown")
        value_class = SimpleNamespace(_classes={base: cls})
    else:
        value_class = SimpleNamespace(_classes={})
    _check_field(value_class, slot_type, value, name)


def _check_message(cls: type[Message], message: Any, prefix: str) -> None:
    for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
        if not hasattr(message, name):
            where = f"field {prefix.rstrip('.')}" if prefix else "the message"
            raise SerializationError(f"{where} must be of type {cls._type}, it has no [{name}]: {_quoted(message)}")
        _check_field(cls, slot_type, getattr(message, name), prefix + name)


def _check_field(cls: Any, slot_type: str, value: Any, name: str) -> None:
    base, bracket, count = slot_type.partition("[")
    if not bracket:
        _check_single(cls, base, value, name)
        return
    length = int(count[:-1]) if count != "]" else -1
    is_octets = base in ("uint8", "char")
    if isinstance(value, str):
        if base != "string":
            raise SerializationError(f"field {name} must be a list or tuple type. Only uint8[] can be a string")
    elif is_octets and isinstance(value, (bytes, bytearray, memoryview)):
        if 0 <= length < len(value):
            raise SerializationError(f"field {name} has {len(value)} bytes, {slot_type} takes {length}")
        return
    elif is_octets and getattr(getattr(value, "dtype", None), "itemsize", 1) != 1:
        raise SerializationError(
            f"field {name} takes bytes or an array of uint8, not of {value.dtype}: give its tobytes(), or convert it"
        )
    elif not isinstance(value, (list, tuple, bytes)) and not hasattr(value, "__len__"):
        raise SerializationError(f"field {name} must be a list or tuple type, not {_quoted(value)}")
    if length >= 0 and len(value) != length:
        raise SerializationError(f"field {name} has {len(value)} elements, {slot_type} takes {length}")
    for element in value:
        _check_single(cls, base, element, name + "[]")


def _check_single(cls: Any, base: str, value: Any, name: str) -> None:
    code = STRUCT_CODES.get(base)
    if code is None:
        _check_other(cls, base, value, name)
    elif base == "bool":
        try:
            known = value in (0, 1)
        except ValueError:  # an array of numpy's
            known = False
        if not known:
            raise SerializationError(f"field {name} is not a bool, but {_quoted(value)}")
    elif code in "fd":
        try:
            struct.pack("<" + code, float(value) if isinstance(value, int) else value)
        except OverflowError:
            raise _TooLargeError(f"field {name} exceeds specified width [{base}]") from None
        except (struct.error, TypeError, ValueError):
            raise SerializationError(f"field {name} must be float type, not {_quoted(value)}") from None
    else:
        try:
            number = operator.index(value)  # arrays also have __index__, but most are no integers
        except TypeError:
            kind = "an integer" if code.islower() else "unsigned integer"
            raise SerializationError(f"field {name} must be {kind} type, not {_quoted(value)}") from None
        if code.isupper() and number < 0:
            raise SerializationError(f"field {name} must be unsigned integer type, not {_quoted(value)}")
        try:
            struct.pack("<" + code, number)
        except (struct.error, OverflowError):
            raise SerializationError(f"field {name} exceeds specified width [{base}]") from None


def _check_other(cls: Any, base: str, value: Any, name: str) -> None:
    if base == "string":
        if not isinstance(value, str):
            raise SerializationError(f"field {name} must be of type bytes or an ascii string, not {_quoted(value)}")
        try:
            value.encode()
        except UnicodeEncodeError as error:
            raise SerializationError(f"field {name} cannot be written as UTF-8: {error}") from None
    elif base in ("time", "duration"):
        if not hasattr(value, "secs") or not hasattr(value, "nsecs"):
            raise SerializationError(f"field {name} must be a {base}, not {_quoted(value)}")
        try:
            struct.pack("<2I" if base == "time" else "<2i", value.secs, value.nsecs)
        except (struct.error, TypeError):
            raise SerializationError(f"field {name} exceeds specified width [{base}]: {_quoted(value)}") from None
    else:
        _check_message(cls._classes[base], value, name + ".")


def _quoted(value: object) -> str:
    text = f"{type(value).__name__} {value!r}"
    return text if len(text) <= 60 else text[:57] + "..."


def decoding_error(cls: type[Message], buffer: Buffer, start: int, end: int) -> DeserializationError:
    """Return the error for bytes that could not be decoded.

    Args:
        cls: the class of the expected message.
        buffer: the bytes.
        start: where the message begins in ``buffer``; the error's offset counts from here.
        end: where it should end.
    """
    walk = Walk(memoryview(buffer)[start:end])
    try:
        walk.message(cls, "")
    except MessageError as error:
        return DeserializationError(cls._type, walk.position, str(error))
    return DeserializationError(cls._type, walk.position, "the buffer ends here")


class Walk:
    """A walk through an encoded message that keeps no values.

    Args:
        data: the encoded message.

    Attributes:
        position: offset of the next byte.
    """

    def __init__(self, data: memoryview) -> None:
        self.data = data
        self.position = 0

    @property
    def remaining(self) -> int:
        return len(self.data) - self.position

    def skip(self, size: int, what: str) -> None:
        if size > self.remaining:
            raise MessageError(f"{what} needs {size} bytes, {self.remaining} are left")
        self.position += size

    def count(self, what: str) -> int:
        self.skip(4, f"the length of {what}")
        return int.from_bytes(self.data[self.position - 4 : self.position], "little")

    def message(self, cls: type[Message], prefix: str) -> None:
        for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
            self.field(cls, slot_type, prefix + name)

    def field(self, cls: type[Message], slot_type: str, name: str) -> None:
        base, bracket, count = slot_type.partition("[")
        what = f"field {name}"
        if not bracket:
            self.single(cls, base, name)
            return
        if count != "]":
            number = int(count[:-1])
        else:
            number = self.count(what)
            self._check_count(number, _min_size_of(cls, base), what)
        if base == "string" or (base in cls._classes and cls._classes[base]._fixed_size is None):
            for _ in range(number):
                self.single(cls, base, name + "[]")
        elif number * _min_size_of(cls, base) <= self.remaining:
            self.position += number * _min_size_of(cls, base)
        else:
            self.elements(cls, base, number, name)

    def elements(self, cls: type[Message], base: str, number: int, name: str) -> None:
        """Handle an array of values of fixed size that does not fit."""
        self.skip(number * _min_size_of(cls, base), f"field {name}")

    def text(self, begin: int, what: str) -> None:
        """Handle a string from ``begin`` to the position; ignored by this walk."""

    def _check_count(self, number: int, min_size: int, what: str) -> None:
        if min_size == 0:
            if number > MAX_EMPTY:
                raise MessageError(f"{what} claims {number} elements without content; the limit is {MAX_EMPTY}")
        elif number > self.remaining // min_size:
            raise MessageError(
                f"{what} claims {number} elements of at least {min_size} bytes, {self.remaining} bytes are left"
            )

    def single(self, cls: type[Message], base: str, name: str) -> None:
        what = f"field {name}"
        if base == "string":
            size = self.count(what)
            self.skip(size, what)
            self.text(self.position - size, what)
        elif base in cls._classes:
            nested = cls._classes[base]
            if nested._fixed_size is not None and nested._fixed_size <= self.remaining:
                self.position += nested._fixed_size
            else:
                self.message(nested, name + ".")
        else:
            self.skip(_min_size_of(cls, base), what)


def _min_size_of(cls: type[Message], base: str) -> int:
    """Return the smallest number of bytes of one value of a type."""
    if base in STRUCT_CODES:
        return struct.calcsize("<" + STRUCT_CODES[base])
    return {"string": 4, "time": 8, "duration": 8}.get(base) or cls._classes[base]._min_size
