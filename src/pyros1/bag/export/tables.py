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
"""Number of values of a row that are joined for one write."""

_BYTES = ("uint8", "char")
_TIMES = ("time", "duration")


class Table:
    """The rows of a topic, or of a field of its messages.

    Times are in nanoseconds; booleans are 1 and 0. Arrays have a column for each element of the first message; arrays
    of bytes have none. Strings are written unchanged, without quotes.

    Args:
        nostr: whether to leave out strings.
        noarr: whether to leave out arrays.
        field_filter: returns the names of the fields of a message to write; None for all.
    """

    def __init__(
        self,
        *,
        nostr: bool = False,
        noarr: bool = False,
        field_filter: Callable[[Message], Iterable[str]] | None = None,
    ) -> None:
        self._nostr, self._noarr, self._field_filter = nostr, noarr, field_filter
        self._fields_by_class: dict[type[Message], list[tuple[str, str, bool]]] = {}

    def head(self, value: Any, emit: Emit) -> None:
        """Emit the row of column names in pieces.

        Args:
            value: the first message, or the field's value.
            emit: called with each piece of text.
        """
        emit_row(emit, "%time", self._value_names(value, "field"))

    def row(self, value: Any, time: int, emit: Emit, offset: Time | None = None) -> None:
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
            yield from self._names(value, path)
        elif isinstance(value, (list, tuple, bytes)):
            for number, item in enumerate(value):
                yield from self._value_names(item, f"{path}{number}")
        else:
            yield path

    def _value_texts(self, value: Any, offset: int) -> Iterator[str]:
        if isinstance(value, Message):
            yield from self._values(value, offset)
        elif isinstance(value, (list, tuple, bytes)):
            for item in value:
                yield from self._value_texts(item, offset)
        elif isinstance(value, TVal):
            yield _nanoseconds(value, offset)
        else:
            yield str(int(value) if isinstance(value, bool) else value)

    def _fields(self, message: Message) -> list[tuple[str, str, bool]]:
        """Return (name, type of the elements, whether it is an array) of the fields that are printed."""
        cls = type(message)
        if self._field_filter is not None:
            names = set(self._field_filter(message))
            return [field for field in self._all_fields(cls) if field[0] in names]
        return self._all_fields(cls)

    def _all_fields(self, cls: type[Message]) -> list[tuple[str, str, bool]]:
        found = self._fields_by_class.get(cls)
        if found is None:
            found = self._fields_by_class[cls] = []
            for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
                kind, bracket, _ = slot_type.partition("[")
                is_hidden = (bracket and (self._noarr or kind in _BYTES)) or (self._nostr and kind == "string")
                if not is_hidden:
                    found.append((name, kind, bool(bracket)))
        return found

    def _names(self, message: Message, prefix: str) -> Iterator[str]:
        for name, kind, is_array in self._fields(message):
            value, path = getattr(message, name), f"{prefix}.{name}"
            items = value if is_array else (value,)
            for number, item in enumerate(items):
                item_path = f"{path}{number}" if is_array else path
                if kind in nested_classes(type(message)):
                    yield from self._names(item, item_path)
                else:
                    yield item_path

    def _values(self, message: Message, offset: int) -> Iterator[str]:
        for name, kind, is_array in self._fields(message):
            value: Any = getattr(message, name)
            items = value if is_array else (value,)
            if kind in nested_classes(type(message)):
                for item in items:
                    yield from self._values(item, offset)
            elif kind == "bool":
                yield from ("1" if item else "0" for item in items)
            elif kind in _TIMES:
                yield from (_nanoseconds(item, offset) for item in items)
            else:
                yield from map(str, items)


def _nanoseconds(value: TVal, offset: int) -> str:
    return str(value.to_nsec() - (offset if isinstance(value, Time) else 0))


def emit_row(emit: Emit, first: str, values: Iterator[str]) -> None:
    """Emit a row of values, in pieces of a thousand values."""
    emit(f"{first},")
    separator = ""
    while chunk := list(islice(values, _VALUES_PER_WRITE)):
        emit(separator)
        emit(",".join(chunk) if len(chunk) > 1 else chunk[0])
        separator = ","
    emit("\n")
