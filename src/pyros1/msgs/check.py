"""Finds out why a value could not be encoded, or bytes could not be decoded, after a generated codec has failed.

The fields are checked one by one, in the order of the class's ``_slot_types``, to find the first wrong one. This is
slow.
"""

from __future__ import annotations

import operator
import struct
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from pyros1.ground.errors import DeserializationError, MessageError, SerializationError
from pyros1.msgs.base import Buffer, Message, message_class
from pyros1.msgs.factory import MAX_EMPTY_ELEMENTS
from pyros1.msgs.records import check_records, is_record_array
from pyros1.msgs.spec import BUILTINS, STRUCT_CODES


class _TooLargeError(SerializationError, OverflowError):
    """A float does not fit its field. Programs written for stock ROS expect OverflowError."""


def encoding_error(cls: type[Message], message: Any, error: Exception) -> SerializationError:
    """Return the error for a message that could not be encoded.

    Args:
        cls: the message's class.
        message: the message, which may be a value of any type.
        error: the encoder's error, used if no wrong field is found.
    """
    try:
        _check_message(cls, message, "")
    except SerializationError as field_error:
        return field_error
    return SerializationError(f"cannot encode {cls._type}: {error}")


def check(message: Message, error: Exception | None = None) -> None:
    """Check all fields of a message.

    Raises:
        SerializationError: a value does not fit its field, or ``error`` is given; the message names the first wrong
            field.
    """
    _check_message(message_class(type(message)), message, "")
    if error is not None:
        raise SerializationError(f"{type(error)}: '{error}' when writing '{message}'")


def check_value(name: str, slot_type: str, value: Any, find_class: Callable[[str], type[Message] | None]) -> None:
    """Check the value of a field.

    Args:
        name: name of the field.
        slot_type: its type, as in ``_slot_types``.
        value: the field's value.
        find_class: returns the class of a message type, or None if there is none.

    Raises:
        SerializationError: the value does not fit; the message names the field.
    """
    base = slot_type.partition("[")[0]
    if base not in BUILTINS:
        cls = find_class(base)
        if cls is None:
            raise SerializationError(f"field {name} has the type {slot_type}, which is unknown")
        owner = SimpleNamespace(_classes={base: cls})
    else:
        owner = SimpleNamespace(_classes={})
    _check_field(owner, slot_type, value, name)


def _check_message(cls: type[Message], message: Any, prefix: str) -> None:
    for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
        if not hasattr(message, name):
            location = f"field {prefix.rstrip('.')}" if prefix else "the message"
            raise SerializationError(
                f"{location} must be of type {cls._type}, but has no field [{name}]: {_describe(message)}"
            )
        _check_field(cls, slot_type, getattr(message, name), prefix + name)


def _check_field(cls: Any, slot_type: str, value: Any, name: str) -> None:
    base, bracket, length_text = slot_type.partition("[")
    if not bracket:
        _check_element(cls, base, value, name)
        return
    length = int(length_text[:-1]) if length_text != "]" else -1
    is_byte_array = base in ("uint8", "char")
    if isinstance(value, str):
        if base != "string":
            raise SerializationError(f"field {name} must be a list or tuple type. Only uint8[] can be a string")
    elif is_byte_array and isinstance(value, (bytes, bytearray, memoryview)):
        if 0 <= length < len(value):
            raise SerializationError(f"field {name} has {len(value)} bytes, {slot_type} takes {length}")
        return
    elif is_byte_array and getattr(getattr(value, "dtype", None), "itemsize", 1) != 1:
        raise SerializationError(
            f"field {name} takes bytes or an array of uint8, but got an array of {value.dtype}: pass array.tobytes(), "
            "or convert the array to uint8"
        )
    elif not isinstance(value, (list, tuple, bytes)) and not hasattr(value, "__len__"):
        raise SerializationError(f"field {name} must be a list or tuple type, not {_describe(value)}")
    holds_records = base in cls._classes and is_record_array(value)
    if holds_records:
        check_records(value, cls._classes[base], name)
    elif getattr(value, "ndim", 1) == 0:  # a numpy array without a length
        raise SerializationError(f"field {name} must be a list or tuple type, not {_describe(value)}")
    if length >= 0 and len(value) != length:
        raise SerializationError(f"field {name} has {len(value)} elements, {slot_type} takes {length}")
    if not holds_records:
        for element in value:
            _check_element(cls, base, element, name + "[]")


def _check_element(cls: Any, base: str, value: Any, name: str) -> None:
    code = STRUCT_CODES.get(base)
    if code is None:
        _check_non_number(cls, base, value, name)
    elif base == "bool":
        try:
            is_bool = value in (0, 1)
        except ValueError:  # a numpy array
            is_bool = False
        if not is_bool:
            raise SerializationError(f"field {name} is not a bool, but {_describe(value)}")
    elif code in "fd":
        try:
            struct.pack("<" + code, float(value) if isinstance(value, int) else value)
        except OverflowError:
            raise _TooLargeError(f"field {name} exceeds specified width [{base}]") from None
        except (struct.error, TypeError, ValueError):
            raise SerializationError(f"field {name} must be float type, not {_describe(value)}") from None
    else:
        try:
            number = operator.index(value)  # arrays also have __index__, but only some can be converted
        except TypeError:
            expected_type = "an integer" if code.islower() else "unsigned integer"
            raise SerializationError(f"field {name} must be {expected_type} type, not {_describe(value)}") from None
        if code.isupper() and number < 0:
            raise SerializationError(f"field {name} must be unsigned integer type, not {_describe(value)}")
        try:
            struct.pack("<" + code, number)
        except (struct.error, OverflowError):
            raise SerializationError(f"field {name} exceeds specified width [{base}]") from None


def _check_non_number(cls: Any, base: str, value: Any, name: str) -> None:
    if base == "string":
        if not isinstance(value, str):
            raise SerializationError(f"field {name} must be of type bytes or an ascii string, not {_describe(value)}")
        try:
            value.encode()
        except UnicodeEncodeError as error:
            raise SerializationError(f"field {name} cannot be written as UTF-8: {error}") from None
    elif base in ("time", "duration"):
        if not hasattr(value, "secs") or not hasattr(value, "nsecs"):
            raise SerializationError(f"field {name} must be a {base}, not {_describe(value)}")
        try:
            struct.pack("<2I" if base == "time" else "<2i", value.secs, value.nsecs)
        except (struct.error, TypeError):
            raise SerializationError(f"field {name} exceeds specified width [{base}]: {_describe(value)}") from None
    else:
        _check_message(cls._classes[base], value, name + ".")


def _describe(value: object) -> str:
    text = f"{type(value).__name__} {value!r}"
    return text if len(text) <= 60 else text[:57] + "..."


def decoding_error(cls: type[Message], buffer: Buffer, start: int, end: int) -> DeserializationError:
    """Return the error for bytes that could not be decoded.

    Args:
        cls: the class of the expected message.
        buffer: the bytes that contain the message.
        start: offset in ``buffer`` at which the message begins; the error's offset is relative to it.
        end: offset at which it should end.
    """
    walker = MessageWalker(memoryview(buffer)[start:end])
    try:
        walker.visit_message(cls, "")
    except MessageError as error:
        return DeserializationError(cls._type, walker.position, str(error))
    return DeserializationError(cls._type, walker.position, "the buffer ends here")


class MessageWalker:
    """Walks through an encoded message without decoding its values.

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

    def skip(self, size: int, description: str) -> None:
        if size > self.remaining:
            raise MessageError(f"{description} needs {size} bytes, {self.remaining} are left")
        self.position += size

    def read_length(self, description: str) -> int:
        self.skip(4, f"the length of {description}")
        return int.from_bytes(self.data[self.position - 4 : self.position], "little")

    def visit_message(self, cls: type[Message], prefix: str) -> None:
        for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
            self.visit_field(cls, slot_type, prefix + name)

    def visit_field(self, cls: type[Message], slot_type: str, name: str) -> None:
        base, bracket, length_text = slot_type.partition("[")
        description = f"field {name}"
        if not bracket:
            self.visit_element(cls, base, name)
            return
        if length_text != "]":
            element_count = int(length_text[:-1])
        else:
            element_count = self.read_length(description)
            self._check_length(element_count, _min_size_of(cls, base), description)
        if base == "string" or (base in cls._classes and cls._classes[base]._fixed_size is None):
            for _ in range(element_count):
                self.visit_element(cls, base, name + "[]")
        elif element_count * _min_size_of(cls, base) <= self.remaining:
            self.position += element_count * _min_size_of(cls, base)
        else:
            self.visit_elements(cls, base, element_count, name)

    def visit_elements(self, cls: type[Message], base: str, element_count: int, name: str) -> None:
        """Visit an array of values of fixed size that is longer than the data."""
        self.skip(element_count * _min_size_of(cls, base), f"field {name}")

    def visit_string(self, begin: int, description: str) -> None:
        """Visit a string from ``begin`` to the current position; does nothing in this class."""

    def _check_length(self, count: int, min_size: int, description: str) -> None:
        if min_size == 0:
            if count > MAX_EMPTY_ELEMENTS:
                raise MessageError(
                    f"{description} claims {count} elements without content; the limit is {MAX_EMPTY_ELEMENTS}"
                )
        elif count > self.remaining // min_size:
            raise MessageError(
                f"{description} claims {count} elements of at least {min_size} bytes, {self.remaining} bytes are left"
            )

    def visit_element(self, cls: type[Message], base: str, name: str) -> None:
        description = f"field {name}"
        if base == "string":
            size = self.read_length(description)
            self.skip(size, description)
            self.visit_string(self.position - size, description)
        elif base in cls._classes:
            nested = cls._classes[base]
            if nested._fixed_size is not None and nested._fixed_size <= self.remaining:
                self.position += nested._fixed_size
            else:
                self.visit_message(nested, name + ".")
        else:
            self.skip(_min_size_of(cls, base), description)


def _min_size_of(cls: type[Message], base: str) -> int:
    """Return the minimum encoded size in bytes of one value of a type."""
    if base in STRUCT_CODES:
        return struct.calcsize("<" + STRUCT_CODES[base])
    return {"string": 4, "time": 8, "duration": 8}.get(base) or cls._classes[base]._min_size
