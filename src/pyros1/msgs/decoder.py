"""Generates the decoders of message classes.

A decoder does not look for the cause of a failure: it catches whatever wrong bytes raise, and ``check.py`` then walks
them slowly to say where and why. What it must check itself is what bounds memory and time, the number of elements
against the bytes left, and that it ended exactly where the message ends. Reading behind ``end`` in a larger buffer is
harmless: the position is wrong then.

The objects of an array of messages are made many at a time, by ``map``: that takes half the time of making each by a
call of its own, and there may be many.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from itertools import repeat
from typing import Any

from pyros1.errors import DeserializationError
from pyros1.msgs import arrays
from pyros1.msgs.base import Message
from pyros1.msgs.check import explain
from pyros1.msgs.factory import MAX_EMPTY
from pyros1.msgs.source import TIME_CODES, Source, split_type
from pyros1.msgs.spec import STRUCT_CODES
from pyros1.timing import Duration, Time

_WRONG = (struct.error, DeserializationError, ValueError, OverflowError, TypeError)


class Decoder(Source):
    """Emits statements in field order; ``self.at`` is the name of the variable that holds the position.

    Args:
        cls: the message class.
        views: leave the making of numeric arrays to the function ``view``, a fourth argument of the decoder.
    """

    def __init__(self, cls: type[Message], views: bool = False) -> None:
        super().__init__(cls)
        self.views = views
        self.at = "start"
        self.objects: list[tuple[str, str]] | None = None  # in a loop: what to make for each turn, name and class
        self.codes: list[str] = []
        self.targets: list[str] = []
        self.after: list[str] = []

    def value(self, code: str, target: str) -> None:
        self.codes.append(code)
        self.targets.append(target)

    def flush(self) -> None:
        """Emit the unpacking of the values collected, and move the position behind them."""
        if not self.codes:
            return
        fmt = "".join(self.codes)
        self.lines.append(f"{', '.join(self.targets)}, = {self.unpack(fmt)}(buf, {self.at})")
        self.lines += self.after
        self.move(struct.calcsize("<" + fmt))
        self.codes, self.targets, self.after = [], [], []

    def move(self, size: int) -> None:
        self.lines.append(f"p = {self.at} + {size}")
        self.at = "p"

    def message(self, cls: type[Message], owner: str) -> None:
        for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
            base, length = split_type(slot_type)
            target = f"{owner}.{name}"
            if length is None:
                self._single(base, cls._classes.get(base), target)
            else:
                self._array(base, length, cls._classes.get(base), target)

    def _single(self, base: str, nested: type[Message] | None, target: str) -> None:
        if base in STRUCT_CODES:
            self.value("?" if base == "bool" else STRUCT_CODES[base], target)
        elif base == "string":
            self.value("I", "n")
            self.flush()
            self.lines.append(f"q = {self.at} + n")
            self.lines.append(f"{target} = buf[{self.at}:q].decode()")
            self.at = "q"
        elif nested is None:
            local = self.new(base.capitalize(), target)
            self.value(TIME_CODES[base], f"{local}.secs")
            self.value(TIME_CODES[base], f"{local}.nsecs")
            self.after.append(f"if not -1 < {local}.nsecs < 1000000000: {local}.canon()")
        elif self.inlines(nested):
            self.message(nested, self.new(self.ref(nested), target))
        else:
            self.flush()
            self.lines.append(f"{target}, q = {self.read(nested)}(buf, {self.at}, end{self.more})")
            self.at = "q"

    def new(self, cls: str, target: str) -> str:
        """Emit the making of an object; return its name."""
        local = self.local()
        if self.objects is None:
            self.lines.append(f"{target} = {local} = new({cls})")
        else:
            self.objects.append((local, cls))
            self.lines.append(f"{target} = {local}")
        return local

    @property
    def more(self) -> str:
        """The further argument of nested decoders."""
        return ", view" if self.views else ""

    def read(self, nested: type[Message]) -> str:
        return self.ref(nested._read_arrays if self.views else nested._read)

    def _array(self, base: str, length: int, nested: type[Message] | None, target: str) -> None:
        code = "?" if base == "bool" else STRUCT_CODES.get(base)
        count = "n" if length < 0 else str(length)
        if code == "B" and length >= 0 and not self.views:
            self.value(f"{length}s", target)
            return
        if length < 0:
            self.value("I", "n")
        self.flush()
        if code is not None:
            self._numbers(code, length, target)
        elif base == "string":
            self.lines.append(f"{target}, q = {self.ref(arrays.read_strings)}(buf, {self.at}, {count}, end)")
            self.at = "q"
        else:
            if self.at == "q":
                self.move(0)
            if nested is None:
                self._times(base, count)
            elif not nested._fixed_size:
                self._variable(nested, count)
            else:
                self._fixed(nested, count)
            self.lines.append(f"{target} = items")
            self.at = "q"

    def _times(self, base: str, count: str) -> None:
        time_class, fmt = {"time": Time, "duration": Duration}[base], TIME_CODES[base]
        self._reserve(count, 8)
        self.lines.append(f"items = {self.ref(arrays.read_times)}(buf, p, {count}, '{fmt}', {self.ref(time_class)})")

    def _reserve(self, count: str, size: int) -> None:
        self.lines.append(f"q = p + {count} * {size}")
        self.lines.append("if q > end: raise ValueError('count')")

    def _fixed(self, nested: type[Message], count: str) -> None:
        """An array of messages that are all of one size."""
        size = nested._fixed_size
        assert size is not None
        self._reserve(count, size)
        loop = self._loop(nested)
        if loop is None or any(" = " not in line or "(" in line for line in loop.lines):
            decode = self.ref(nested._decode_arrays if self.views else nested._decode)
            self.lines.append(f"items = [{decode}(buf, i, i + {size}{self.more}) for i in range(p, q, {size})]")
            return
        values = self.local()
        unpack = self.ref(struct.Struct("<" + "".join(loop.codes)).iter_unpack, ("iter_unpack", *loop.codes))
        assignment = f"{', '.join(loop.targets)}, = {values}"
        self._emit(loop, count, [*loop.lines, assignment, *loop.after], (values, f"{unpack}(buf[p:q])"))

    def _variable(self, nested: type[Message], count: str) -> None:
        """An array of messages of which each has a size of its own; or of messages without content."""
        least = nested._min_size
        if not least:
            self.lines.append(f"if {count} > {MAX_EMPTY}: raise ValueError('count')")
            self.lines.append(f"items = [{self.ref(nested)}() for _ in range({count})]")
            self.lines.append("q = p")
            return
        self.lines.append(f"if {count} > (end - p) // {least}: raise ValueError('count')")
        self.lines.append("q = p")
        loop = self._loop(nested)
        if loop is None:
            items = self.local()
            self.lines.append(f"{items} = []")
            self.lines.append(f"for _ in range({count}):")
            self.lines.append(f"    item, q = {self.read(nested)}(buf, q, end{self.more})")
            self.lines.append(f"    {items}.append(item)")
            self.lines.append(f"items = {items}")
            return
        loop.flush()
        self._emit(loop, count, loop.lines + (["q = p"] if loop.at == "p" else []))

    def _loop(self, nested: type[Message]) -> Decoder | None:
        """Return the decoding of one element, which begins at ``q``; None if that is better a function of its own."""
        if self.objects is not None or not self.inlines(nested) or not _is_plain(nested):
            return None
        loop = Decoder(nested, self.views)
        loop.names, loop._known, loop._count, loop.budget = self.names, self._known, self._count, self.budget
        loop.objects, loop.at = [(loop.local(), self.ref(nested))], "q"
        loop.message(nested, loop.objects[0][0])
        self._count = loop._count
        return loop

    def _emit(self, loop: Decoder, count: str, body: list[str], *more: tuple[str, str]) -> None:
        """Emit a loop over new objects, and over what else is given as names and iterables."""
        assert loop.objects is not None
        self.names["repeat"] = repeat
        self.lines.append(f"items = list(map(new, repeat({loop.objects[0][1]}, {count})))")
        sources = [*((name, f"map(new, repeat({cls}, {count}))") for name, cls in loop.objects[1:]), *more]
        names = ", ".join([loop.objects[0][0], *(name for name, _ in sources)])
        iterables = ", ".join(["items", *(iterable for _, iterable in sources)])
        self.lines.append(f"for {names}, in zip({iterables}):")
        self.lines += [f"    {line}" for line in body]

    def _numbers(self, code: str, length: int, target: str) -> None:
        if self.views:
            count = "n" if length < 0 else str(length)
            if self.at == "q":
                self.move(0)
            self.lines.append(f"q = {self.at} + {count} * {struct.calcsize('<' + code)}")
            self.lines.append("if q > end: raise ValueError('count')")
            self.lines.append(f"{target} = view(buf, {self.at}, {count}, '{code}')")
            self.at = "q"
            return
        if code == "B":  # those of a fixed length are values
            self.lines.append(f"q = {self.at} + n")
            self.lines.append(f"{target} = buf[{self.at}:q]")
            self.at = "q"
            return
        if length >= 0:
            read = f"{self.unpack(f'{length}{code}')}(buf, {self.at})"
            size = struct.calcsize(f"<{length}{code}")
        else:
            size = struct.calcsize("<" + code)
            self.lines.append(f"q = {self.at} + n * {size}" if size > 1 else f"q = {self.at} + n")
            self.lines.append("if q > end: raise ValueError('count')")
            unpackers = self.ref(arrays.Unpackers(code), ("unpackers", code))
            read = f"{unpackers}[n](buf, {self.at})"
        self.lines.append(f"{target} = list({read})" if code == "?" else f"{target} = {read}")
        if length >= 0:
            self.move(size)
        else:
            self.at = "q"


def _is_plain(cls: type[Message]) -> bool:
    """Tell whether a class has no arrays of messages, however deep."""
    for slot_type in cls._slot_types:
        base, length = split_type(slot_type)
        nested = cls._classes.get(base)
        if nested is not None and (length is not None or not _is_plain(nested)):
            return False
    return True


def make_decode(cls: type[Message]) -> Callable[[Any, int, int], Any]:
    """Generate ``_decode``."""
    return _make_decode(Decoder(cls))


def make_decode_arrays(cls: type[Message]) -> Callable[..., Any]:
    """Generate ``_decode_arrays``."""
    return _make_decode(Decoder(cls, views=True))


def make_read(cls: type[Message]) -> Callable[[Any, int, int], tuple[Any, int]]:
    """Generate ``_read``; its errors are for its caller to explain, who knows where the whole message begins."""
    return _make_read(Decoder(cls))


def make_read_arrays(cls: type[Message]) -> Callable[..., tuple[Any, int]]:
    """Generate ``_read_arrays``."""
    return _make_read(Decoder(cls, views=True))


def _make_decode(source: Decoder) -> Callable[..., Any]:
    cls = source.cls
    _fill(source)
    if cls._fixed_size is not None:
        source.lines.insert(0, f"if end - start != {cls._fixed_size}: raise ValueError('size')")
        # The position needs no second look: drop its last computation.
        if source.lines[-1].startswith("p = "):
            source.lines.pop()
    else:
        source.lines.append(f"if {source.at} != end: raise ValueError('size')")
    source.lines.append("return m")
    source.names.update(WrongBytes=_WRONG, explain=explain)
    guard = ("WrongBytes", f"explain({source.ref(cls)}, buf, start, end)")
    return source.function(f"decode(buf, start, end{source.more})", guard)


def _make_read(source: Decoder) -> Callable[..., tuple[Any, int]]:
    _fill(source)
    source.lines.append(f"if {source.at} > end: raise ValueError('size')")
    source.lines.append(f"return m, {source.at}")
    return source.function(f"read(buf, start, end{source.more})")


def _fill(source: Decoder) -> None:
    source.lines.append(f"m = new({source.ref(source.cls)})")
    source.message(source.cls, "m")
    source.flush()
