"""Generates the decoders of message classes.

A decoder does not look for the cause of a failure: it catches whatever wrong bytes raise, and ``check.py`` then walks
them slowly to say where and why. What it must check itself is what bounds memory and time, the number of elements
against the bytes left, and that it ended exactly where the message ends. Reading behind ``end`` in a larger buffer is
harmless: the position is wrong then.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
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
            self.lines.append(f"{target} = str(buf[{self.at}:q], 'utf-8')")
            self.at = "q"
        elif nested is None:
            local = self.local()
            self.lines.append(f"{target} = {local} = new({base.capitalize()})")
            self.value(TIME_CODES[base], f"{local}.secs")
            self.value(TIME_CODES[base], f"{local}.nsecs")
            self.after.append(f"if not -1 < {local}.nsecs < 1000000000: {local}.canon()")
        elif self.inlines(nested):
            local = self.local()
            self.lines.append(f"{target} = {local} = new({self.ref(nested)})")
            self.message(nested, local)
        else:
            self.flush()
            self.lines.append(f"{target}, q = {self.read(nested)}(buf, {self.at}, end{self.more})")
            self.at = "q"

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
        elif nested is None or nested._fixed_size is not None:
            size = 8 if nested is None else nested._fixed_size
            time_class = {"time": Time, "duration": Duration}.get(base)
            if not size:
                assert nested is not None
                self.lines.append(f"if {count} > {MAX_EMPTY}: raise ValueError('count')")
                self.lines.append(f"{target} = [{self.ref(nested)}() for _ in range({count})]")
                return
            if self.at == "q":
                self.move(0)
            self.lines.append(f"q = {self.at} + {count} * {size}" if length < 0 else f"q = {self.at} + {length * size}")
            self.lines.append("if q > end: raise ValueError('count')")
            if nested is None:
                times = self.ref(arrays.read_times)
                fmt = TIME_CODES[base]
                self.lines.append(f"{target} = {times}(buf, {self.at}, {count}, '{fmt}', {self.ref(time_class)})")
            else:
                decode = self.ref(nested._decode_arrays if self.views else nested._decode)
                elements = f"range({self.at}, q, {size})"
                self.lines.append(f"{target} = [{decode}(buf, i, i + {size}{self.more}) for i in {elements}]")
            self.at = "q"
        else:
            least = nested._min_size
            items = self.local()
            if length < 0:
                self.lines.append(f"if n > (end - {self.at}) // {least}: raise ValueError('count')")
            self.lines.append(f"{target} = {items} = []")
            self.lines.append(f"q = {self.at}")
            self.lines.append(f"for _ in range({count}):")
            self.lines.append(f"    item, q = {self.read(nested)}(buf, q, end{self.more})")
            self.lines.append(f"    {items}.append(item)")
            self.at = "q"

    def _numbers(self, code: str, length: int, target: str) -> None:
        if self.views:
            count = "n" if length < 0 else str(length)
            self.lines.append(f"q = {self.at} + {count} * {struct.calcsize('<' + code)}")
            self.lines.append("if q > end: raise ValueError('count')")
            self.lines.append(f"{target} = view(buf, {self.at}, {count}, '{code}')")
            self.at = "q"
            return
        if code == "B":  # those of a fixed length are values
            self.lines.append(f"q = {self.at} + n")
            self.lines.append(f"{target} = {self.ref(arrays.to_bytes)}(buf[{self.at}:q])")
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
