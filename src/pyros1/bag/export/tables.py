"""Prints messages as comma-separated values, byte for byte like stock ``rostopic echo -p``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any

from pyros1.ground.timing import Time, TVal
from pyros1.msgs import Message
from pyros1.msgs.base import nested_classes

Emit = Callable[[str], object]

_VALUES_PER_WRITE = 1000
"""A row is written in pieces of at most this many values."""

_UINT8_TYPES = ("uint8", "char")
_TIME_TYPES = ("time", "duration")


class Table:
    """Writes a table of a topic's messages, or of one of their fields, with one row per message.

    Times are in nanoseconds; booleans are 1 and 0. An array has one column per element in the first message; arrays
    of bytes have none. Strings are written unchanged, without quotes.

    Args:
        omits_strings: whether to leave out strings.
        omits_arrays: whether to leave out arrays.
        field_filter: returns the names of a message's fields to write; None writes all.
    """

    def __init__(
        self,
        *,
        omits_strings: bool = False,
        omits_arrays: bool = False,
        field_filter: Callable[[Message], Iterable[str]] | None = None,
    ) -> None:
        self._omits_strings, self._omits_arrays, self._field_filter = omits_strings, omits_arrays, field_filter
        self._fields_by_class: dict[type[Message], list[tuple[str, str, bool]]] = {}

    def emit_header(self, value: Any, emit: Emit) -> None:
        """Emit the row of column names in pieces.

        Args:
            value: the first message, or the field's value.
            emit: called with each piece of text.
        """
        emit_row(emit, "%time", self._value_names(value, "field"))

    def emit_message(self, value: Any, time: int, emit: Emit, offset: Time | None = None) -> None:
        """Emit a message's row in pieces.

        Args:
            value: the message, or the field's value.
            time: time in nanoseconds.
            emit: called with each piece of text.
            offset: subtracted from the times in the message.
        """
        emit_row(emit, str(time), self._value_texts(value, offset.to_nsec() if offset is not None else 0))

    def _value_names(self, value: Any, path: str) -> Iterator[str]:
        if isinstance(value, Message):
            yield from self._message_names(value, path)
        elif isinstance(value, (list, tuple, bytes)):
            for index, item in enumerate(value):
                yield from self._value_names(item, f"{path}{index}")
        else:
            yield path

    def _value_texts(self, value: Any, offset: int) -> Iterator[str]:
        if isinstance(value, Message):
            yield from self._message_texts(value, offset)
        elif isinstance(value, (list, tuple, bytes)):
            for item in value:
                yield from self._value_texts(item, offset)
        elif isinstance(value, TVal):
            yield _nanoseconds(value, offset)
        else:
            yield str(int(value) if isinstance(value, bool) else value)

    def _fields(self, message: Message) -> list[tuple[str, str, bool]]:
        """Return (name, type or element type, whether it is an array) of each field that is printed."""
        cls = type(message)
        if self._field_filter is not None:
            names = set(self._field_filter(message))
            return [field for field in self._all_fields(cls) if field[0] in names]
        return self._all_fields(cls)

    def _all_fields(self, cls: type[Message]) -> list[tuple[str, str, bool]]:
        fields = self._fields_by_class.get(cls)
        if fields is None:
            fields = self._fields_by_class[cls] = []
            for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
                element_type, bracket, _ = slot_type.partition("[")
                is_hidden = (bracket and (self._omits_arrays or element_type in _UINT8_TYPES)) or (
                    self._omits_strings and element_type == "string"
                )
                if not is_hidden:
                    fields.append((name, element_type, bool(bracket)))
        return fields

    def _message_names(self, message: Message, prefix: str) -> Iterator[str]:
        for name, element_type, is_array in self._fields(message):
            value, path = getattr(message, name), f"{prefix}.{name}"
            items = value if is_array else (value,)
            for index, item in enumerate(items):
                item_path = f"{path}{index}" if is_array else path
                if element_type in nested_classes(type(message)):
                    yield from self._message_names(item, item_path)
                else:
                    yield item_path

    def _message_texts(self, message: Message, offset: int) -> Iterator[str]:
        for name, element_type, is_array in self._fields(message):
            value: Any = getattr(message, name)
            items = value if is_array else (value,)
            if element_type in nested_classes(type(message)):
                for item in items:
                    yield from self._message_texts(item, offset)
            elif element_type == "bool":
                yield from ("1" if item else "0" for item in items)
            elif element_type in _TIME_TYPES:
                yield from (_nanoseconds(item, offset) for item in items)
            else:
                yield from map(str, items)


def _nanoseconds(value: TVal, offset: int) -> str:
    return str(value.to_nsec() - (offset if isinstance(value, Time) else 0))


def emit_row(emit: Emit, first: str, values: Iterator[str]) -> None:
    """Emit a row that begins with `first`, in pieces of a thousand values."""
    emit(f"{first},")
    separator = ""
    while batch := list(islice(values, _VALUES_PER_WRITE)):
        emit(separator)
        emit(",".join(batch) if len(batch) > 1 else batch[0])
        separator = ","
    emit("\n")
