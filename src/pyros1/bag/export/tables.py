"""Messages as rows of comma-separated values, byte for byte as stock ``rostopic echo -b BAG -p`` prints them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pyros1.msgs import Message

_BYTES = ("uint8", "char")
_TIMES = ("time", "duration")


class Table:
    """The rows of a topic.

    Times are in nanoseconds, truth values 1 and 0. Arrays have a column for each element of the first message's;
    arrays of bytes have none. Texts stand there as they are, without quotes.

    Args:
        nostr: leave out texts.
        noarr: leave out arrays.
    """

    def __init__(self, *, nostr: bool = False, noarr: bool = False) -> None:
        self._nostr, self._noarr = nostr, noarr
        self._slots: dict[type[Message], list[tuple[str, str, bool]]] = {}

    def head(self, message: Message) -> str:
        """Return the row of names."""
        return f"%time,{','.join(self._names(message, 'field'))}\n"

    def row(self, message: Message, time: int) -> str:
        """Return a message's row.

        Args:
            time: in nanoseconds.
        """
        values: list[str] = []
        self._values(message, values)
        return f"{time},{','.join(values)}\n"

    def _fields(self, cls: type[Message]) -> list[tuple[str, str, bool]]:
        """Name, type of the elements, and whether it is an array, of the fields that are shown."""
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
            items = [(f"{path}{number}", item) for number, item in enumerate(value)] if array else [(path, value)]
            for where, item in items:
                if kind in type(message)._classes:
                    yield from self._names(item, where)
                else:
                    yield where

    def _values(self, message: Message, values: list[str]) -> None:
        for name, kind, array in self._fields(type(message)):
            value: Any = getattr(message, name)
            items = value if array else (value,)
            if kind in type(message)._classes:
                for item in items:
                    self._values(item, values)
            elif kind == "bool":
                values += ["1" if item else "0" for item in items]
            elif kind in _TIMES:
                values += [str(item.to_nsec()) for item in items]
            else:
                values += map(str, items)
