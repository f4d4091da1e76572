"""Changes some strings in encoded messages, such as frame ids, and copies all other bytes. No I/O.

The bytes to skip are computed once per type. A message then takes a few steps, whatever its size: everything after the
last string that may change is copied as is.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from pyros1.ground.errors import MessageError
from pyros1.msgs import Message
from pyros1.msgs.generator import fields_of, split_type
from pyros1.msgs.spec import STRUCT_CODES

MAX_STEPS = 100_000
"""Maximum number of steps for a message, such as strings to read: it may come from another site, and other messages
wait meanwhile. A transform takes four.
"""
_MAX_FIELDS = 5_000
"""Maximum number of fields of a type, including nested messages: its definition may be malicious, too."""
Change = Callable[[bytes], bytes]
"""Returns the replacement of a string."""
_LENGTH = struct.Struct("<I")
_VARIABLE = -1
"""Length of an array whose length is in the message."""


class _Skip(NamedTuple):
    """A fixed number of bytes."""

    size: int


class _Array(NamedTuple):
    """An array of variable length, whose elements have a fixed number of bytes."""

    element_size: int


class _String(NamedTuple):
    """A string, and the function that changes it, if any."""

    change: Change | None


class _Loop(NamedTuple):
    """A fixed or variable number of elements, each with its own steps."""

    length: int
    steps: list[Any]


class StringChanger:
    """Changes strings in the encoded messages of a type.

    Args:
        cls: the message class.
        changes: field name -> the function for its strings, wherever in the message a field with this name is.

    Attributes:
        is_useful: whether the type has such fields.

    Raises:
        MessageError: the type has too many fields.
    """

    def __init__(self, cls: type[Message], changes: Mapping[str, Change]) -> None:
        self._steps = _strip_tail(_Compiler(changes).steps(cls))
        self.is_useful = bool(self._steps)

    def change(self, body: bytes) -> bytes:
        """Return an encoded message with the changes.

        Raises:
            MessageError: it is not a message of this type, or it takes more than `MAX_STEPS` steps.
        """
        return _Pass(body).run(self._steps) if self._steps else body


class _Pass:
    """One pass over a message."""

    def __init__(self, body: bytes) -> None:
        self._body = body
        self._position = 0
        self._copied = 0
        self._pieces: list[bytes] = []
        self._steps_left = MAX_STEPS

    def run(self, steps: list[Any]) -> bytes:
        """Return the changed message."""
        try:
            self._take(steps)
        except struct.error:
            raise MessageError("a message that ends too early") from None
        if self._position > len(self._body):
            raise MessageError("a message that ends too early")
        return b"".join((*self._pieces, self._body[self._copied :]))

    def _take(self, steps: list[Any]) -> None:
        for step in steps:
            self._steps_left -= 1
            if self._steps_left < 0:
                raise MessageError("a message with too many strings")
            match step:
                case _Skip(size):
                    self._position += size
                case _Array(size):
                    self._position += 4 + size * self._length()
                case _String(change):
                    self._take_string(change)
                case _Loop(length, inner):
                    if length == _VARIABLE:
                        length = self._length()
                        self._position += 4
                    for _ in range(length):
                        self._take(inner)

    def _length(self) -> int:
        length: int = _LENGTH.unpack_from(self._body, self._position)[0]
        return length

    def _take_string(self, change: Change | None) -> None:
        begin = self._position
        self._position += 4 + self._length()
        if change is not None:
            old = self._body[begin + 4 : self._position]
            new = change(old)
            if new != old:
                self._pieces += (self._body[self._copied : begin], _LENGTH.pack(len(new)), new)
                self._copied = self._position


class _Compiler:
    """Compiles the steps for a type."""

    def __init__(self, changes: Mapping[str, Change]) -> None:
        self._changes = changes
        self._fields_left = _MAX_FIELDS

    def steps(self, cls: type[Message]) -> list[Any]:
        """Return the steps for a message class."""
        steps: list[Any] = []
        for name, slot_type in fields_of(cls):
            self._fields_left -= 1
            if self._fields_left < 0:
                raise MessageError("its type has too many fields")
            for step in self._field_steps(cls, *split_type(slot_type), self._changes.get(name)):
                if isinstance(step, _Skip) and steps and isinstance(steps[-1], _Skip):
                    steps[-1] = _Skip(steps[-1].size + step.size)
                else:
                    steps.append(step)
        return steps

    def _field_steps(self, cls: type[Message], base: str, length: int | None, change: Change | None) -> list[Any]:
        """Return the steps for a field; `length` is None for a single value, -1 for an array of variable length."""
        if base == "string":
            inner: list[Any] = [_String(change)]
        elif base in STRUCT_CODES:
            inner = [_Skip(struct.calcsize("<" + STRUCT_CODES[base]))]
        elif base in cls._classes:
            inner = self.steps(cls._classes[base])
        else:  # a time or duration
            inner = [_Skip(8)]
        if length is None:
            return inner
        if not inner or (len(inner) == 1 and isinstance(inner[0], _Skip)):
            size = inner[0].size if inner else 0
            return [_Array(size)] if length == _VARIABLE else [_Skip(size * length)]
        return [_Loop(length, inner)]


def _strip_tail(steps: list[Any]) -> list[Any]:
    """Return the steps up to the last one that may change something."""
    while steps and not _changes_something(steps[-1]):
        steps = steps[:-1]
    return steps


def _changes_something(step: Any) -> bool:
    if isinstance(step, _Loop):
        return any(map(_changes_something, step.steps))
    return isinstance(step, _String) and step.change is not None
