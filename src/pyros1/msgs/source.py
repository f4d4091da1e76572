"""Python source for the constructor and the codec of a message class: what constructor, encoder and decoder share.

The source is built from field names that the parser has checked (``[A-Za-z][A-Za-z0-9_]*``) and from names made here,
never from other text. Neighbouring values of fixed size share one ``struct.Struct``, across nested messages: these are
inlined up to a limit. The length prefixes of strings and arrays are part of the struct before them.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from pyros1.msgs.base import Message
from pyros1.timing import Duration, Time

MAX_INLINE = 200
"""Most values that one function handles inline; what nested messages have beyond is left to their own functions."""

TIME_CODES = {"time": "I", "duration": "i"}
"""Struct codes of both parts of a time."""


def split_type(slot_type: str) -> tuple[str, int | None]:
    """Return base type and length of a ``_slot_types`` entry; the length is as in :class:`pyros1.msgs.spec.Field`."""
    base, bracket, count = slot_type.partition("[")
    return base, None if not bracket else -1 if count == "]" else int(count[:-1])


def inline_size(cls: type[Message]) -> int:
    """Return how many values a function handles that inlines all of ``cls``, counted up to the limit."""
    total = 0
    for slot_type in cls._slot_types:
        base, length = split_type(slot_type)
        total += inline_size(cls._classes[base]) if length is None and base in cls._classes else 1
        if total > MAX_INLINE:
            return total
    return total


class Source:
    """Lines of a function body and the objects that they refer to."""

    def __init__(self, cls: type[Message]) -> None:
        self.cls = cls
        self.lines: list[str] = []
        self.names: dict[str, Any] = {"new": object.__new__, "Time": Time, "Duration": Duration}
        self._known: dict[Any, str] = {}
        self._count = 0
        self.budget = MAX_INLINE

    def local(self) -> str:
        self._count += 1
        return f"x{self._count}"

    def ref(self, value: Any, key: Any = None) -> str:
        """Return the name under which the function sees ``value``."""
        key = id(value) if key is None else key
        if key not in self._known:
            self._known[key] = f"_{len(self._known)}"
            self.names[self._known[key]] = value
        return self._known[key]

    def pack(self, fmt: str) -> str:
        return self.ref(struct.Struct("<" + fmt).pack, ("pack", fmt))

    def unpack(self, fmt: str) -> str:
        return self.ref(struct.Struct("<" + fmt).unpack_from, ("unpack", fmt))

    def inlines(self, cls: type[Message]) -> bool:
        """Tell whether a nested message of this class is inlined, and count it."""
        size = inline_size(cls)
        if size > self.budget:
            return False
        self.budget -= size
        return True

    def function(self, header: str, guard: tuple[str, str] | None = None) -> Callable[..., Any]:
        lines = [f"def {header}:"]
        if guard is None:
            lines += [f"    {line}" for line in self.lines]
        else:
            lines += ["    try:", *(f"        {line}" for line in self.lines)]
            lines += [f"    except {guard[0]} as error:", f"        raise {guard[1]} from error"]
        code = compile("\n".join(lines), f"<codec of {self.cls._type}>", "exec")
        exec(code, self.names)
        function: Callable[..., Any] = self.names[header.partition("(")[0]]
        return function
