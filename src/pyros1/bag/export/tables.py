"""Messages as rows of comma-separated values, byte for byte as stock ``rostopic echo -b BAG -p`` prints them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any

from pyros1.msgs import Message
from pyros1.msgs.base import nested_classes

Emit = Callable[[str], object]

_VALUES_PER_WRITE = 1000
"""Number of values of a row that are joined at a time."""

_BYTES = ("uint8", "char")
_TIMES = ("time", "duration")


class Table:
    """The rows of a topic.

    Times are in nanoseconds, truth values 1 and 0. Arrays have a column for each element in the first
    message; arrays of bytes have none. Strings are written unchanged, without quotes.

    Args:
        nostr: whether to leave out strings.
        noarr: whether to leave out arrays.
    """

    def __init__(self, *, nostr: bool = False, noarr: bool = False) -> None:
        self._nostr, self._noarr = nostr, noarr
        self._slots: dict[type[Message], list[tuple[str, str, bool]]] = {}

    def head(self, message: Message, emit: Emit) -> None:
        """Emit the row of column names in pieces."""
        emit_row(emit, "%time", self._names(message, "field"))

    def row(self, message: Message, time: int, emit: Emit) -> None:
        """Emit a message's row in pieces.

        Args:
            time: time in nanoseconds.
            emit: called with each piece of text.
        """
        emit_row(emit, str(time), self._values(message))

    def _fields(self, cls: type[Message]) -> list[tuple[str, str, bool]]:
        """Return (name, type of the elements, whether it is an array) of the fields that are printed."""
        found = self._slots.get(cls)
        if found is None:
            found = self._slots[cls] = []
            for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
                kind, bracket, _ = slot_type.partition("[")
                hidden = (bracket and (self._noarr or kind in _BYTES)) or (self._nostr and kind == "string")
                if not hidden:
                    found.append((name, kind, bool(bracket)))
        return found

    def _names(self, message: Message, prefix: str) -> Iterator[str]:
        for name, kind, array in self._fields(type(message)):
            value, path = getattr(message, name), f"{prefix}.{name}"
            items = value if array else (value,)
            for number, item in enumerate(items):
                path_ = f"{path}{number}" if array else path
                if kind in nested_classes(type(message)):
                    yield from self._names(item, path_)
                else:
                    yield path_

    def _values(self, message: Message) -> Iterator[str]:
        for name, kind, array in self._fields(type(message)):
            value: Any = getattr(message, name)
            items = value if array else (value,)
            if kind in nested_classes(type(message)):
                for item in items:
                    yield from self._values(item)
            elif kind == "bool":
                yield from ("1" if item else "0" for item in items)
            elif kind in _TIMES:
                yield from (str(item.to_nsec()) for item in items)
            else:
                yield from map(str, items)


def emit_row(emit: Emit, first: str, others: Iterator[str]) -> None:
    """Emit a row of values, in pieces of a thousand values."""
    emit(f"{first},")
    separator = ""
    while part := list(islice(others, _VALUES_PER_WRITE)):
        emit(separator)
        emit(",".join(part) if len(part) > 1 else part[0])
        separator = ","
    emit("\n")
