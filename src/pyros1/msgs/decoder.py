"""Generates the decoders of message classes.

A decoder does not look for the cause of a failure: it catches all errors that wrong bytes cause, and ``check.py`` then
goes through the bytes slowly to find place and reason. Before that, ``repair.py`` mends what stock accepts, such as a
string that is not UTF-8, and the decoder begins again. The decoder itself checks only what limits memory and time (the
number of elements against the remaining bytes), and whether it ends at the end of the message. To read beyond
``end`` in a larger buffer does no harm: the final position is then wrong. Bytes behind the message are ignored, as in
stock, unless ``exact`` is true.

Times keep both numbers as they were sent, also a billion nanoseconds and more. Only those that are fields of the whole
message, not of its header or other parts, are normalised, as in stock.

The objects of an array of messages are made many at a time, by ``map``, which takes half the time of separate calls.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from itertools import repeat
from typing import Any, NamedTuple

from pyros1.ground.errors import DeserializationError
from pyros1.msgs import arrays
from pyros1.msgs.base import Message
from pyros1.msgs.factory import MAX_EMPTY
from pyros1.msgs.generator import TIME_CLASSES, TIME_CODES, Fields, Source, fields_of, parts_of, split_type
from pyros1.msgs.repair import accept_end, decode_repaired
from pyros1.msgs.spec import STRUCT_CODES

_DECODE_ERRORS = (struct.error, DeserializationError, ValueError, OverflowError, TypeError)


class _Arguments(NamedTuple):
    """Names of a decoder's parameters."""

    buffer: str
    start: str
    end: str
    view: str
    exact: str


class Decoder(Source):
    """Emits statements in field order.

    Args:
        cls: the message class.
        views: whether numeric arrays are made by the function ``view``, a fourth argument of the decoder.
        outer: the decoder that this one is a loop of, over messages of ``cls``; None: it begins a function.
        whole: whether ``cls`` is the class of the whole message, not of a part of it.

    Attributes:
        at: name of the variable that holds the position. A step puts the next position into the other one of two
            variables, so that the bytes between both can be cut out.
        begin: the variable that held the position first.
        moved: whether the position has moved since.
        made: in a loop, names of the object to make in each turn and of its class; else None.
    """

    def __init__(
        self, cls: type[Message], *, views: bool = False, outer: Decoder | None = None, whole: bool = False
    ) -> None:
        super().__init__(cls, None if outer is None else outer.scope)
        self.views, self.whole = views, whole
        self._places = self.fresh("p"), self.fresh("q")
        self.made: list[tuple[str, str]] | None
        if outer is None:
            self.arguments = _Arguments(*map(self.fresh, _Arguments._fields))
            self.at, self.made = self.arguments.start, None
            self.root = self.fresh("m")
        else:
            self.arguments = outer.arguments
            self.root = self.fresh("m")
            self.at, self.made = self._places[0], [(self.root, self.ref(cls, "cls"))]
        self.begin, self.moved = self.at, False
        self.codes: list[str] = []
        self._targets: list[str] = []
        self.after: list[str] = []

    # Positions --------------------------------------------------------------------------------------------------------

    def move(self) -> str:
        """Switch to the other variable, which the caller must set to the next position; return the former variable."""
        begin, self.at, self.moved = self.at, self._places[self.at == self._places[0]], True
        return begin

    def step(self, size: str | int) -> str:
        """Emit a step over ``size`` bytes; return the variable that holds their first position."""
        begin = self.move()
        self.emit(f"{self.at} = {begin} + {size}")
        return begin

    def reserve(self, count: str, size: int) -> str:
        """Emit a checked step over ``count`` values of ``size`` bytes each; return the variable of their position."""
        begin = self.step(f"{count} * {size}" if size != 1 else count)
        self.emit(f"if {self.at} > {self.arguments.end}: raise ValueError('count')")
        return begin

    # Values of fixed size, which are unpacked together ----------------------------------------------------------------

    def value(self, code: str, target: str) -> None:
        self.codes.append(code)
        self._targets.append(target)

    def number(self) -> str:
        """Emit code that reads a length; return its name."""
        count = self.fresh("n")
        self.value("I", count)
        self.flush()
        return count

    def assignment(self, values: str) -> list[str]:
        """Return the statement that assigns the collected values to their targets."""
        return [f"{', '.join(self._targets)}, = {values}", *self.after]

    def flush(self, *, last: bool = False) -> None:
        """Emit code that unpacks the collected values and moves the position behind them.

        Args:
            last: whether the position is not needed afterwards.
        """
        if not self.codes:
            return
        fmt = "".join(self.codes)
        self.lines += self.assignment(f"{self.unpack(fmt)}({self.arguments.buffer}, {self.at})")
        if not last:
            self.step(struct.calcsize("<" + fmt))
        self.codes, self._targets, self.after = [], [], []

    # Fields -----------------------------------------------------------------------------------------------------------

    def message(self, cls: type[Message], owner: str, fields: Fields | None = None) -> None:
        """Emit code that decodes a message's fields, by default all of them."""
        for name, slot_type in fields_of(cls) if fields is None else fields:
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
            size = self.number()
            begin = self.step(size)
            where = f"{self.arguments.buffer}[{begin}:{self.at}]"
            large = f"{self.ref(arrays.read_large_string, 'text')}({self.arguments.buffer}, {begin}, {self.at})"
            self.emit(f"{target} = {where}.decode() if {size} < {arrays.LARGE_STRING} else {large}")
        elif nested is None:
            local = self._make(self.class_of(base, nested), target)
            self.value(TIME_CODES[base], f"{local}.secs")
            self.value(TIME_CODES[base], f"{local}.nsecs")
            if self.whole and target.startswith(f"{self.root}."):
                self.after.append(f"if not -1 < {local}.nsecs < 1000000000: {local}.canon()")
        elif self.inlines(nested):
            self.message(nested, self._make(self.class_of(base, nested), target))
        else:
            self.flush()
            self._call(self._read(nested), target)

    def _make(self, cls: str, target: str) -> str:
        """Emit code that makes an object; return its name."""
        local = self.fresh("m")
        if self.made is None:
            self.emit(f"{target} = {local} = {self.new(cls)}")
        else:
            self.made.append((local, cls))
            self.emit(f"{target} = {local}")
        return local

    def _call(self, function: str, target: str, *arguments: str) -> None:
        """Emit the call of a function that returns a value and the position behind it."""
        begin = self.move()
        given = ", ".join([self.arguments.buffer, begin, *arguments, self.arguments.end, *self._view])
        self.emit(f"{target}, {self.at} = {function}({given})")

    @property
    def _view(self) -> list[str]:
        """The additional argument of nested decoders."""
        return [self.arguments.view] if self.views else []

    def _read(self, nested: type[Message]) -> str:
        return self.ref(nested._read_arrays if self.views else nested._read, "read")

    def _element(self, nested: type[Message], begin: str, end: str) -> str:
        """Return the expression that decodes a message of fixed size."""
        return f"{self._read(nested)}({', '.join([self.arguments.buffer, begin, end, *self._view])})[0]"

    # Arrays -----------------------------------------------------------------------------------------------------------

    def _array(self, base: str, length: int, nested: type[Message] | None, target: str) -> None:
        code = "?" if base == "bool" else STRUCT_CODES.get(base)
        if code == "B" and length >= 0 and not self.views:
            self.value(f"{length}s", target)
            return
        if length < 0:
            count = self.number()
        else:
            count = str(length)
            self.flush()
        if code is not None:
            self._numbers(code, count, length, target)
        elif base == "string":
            self._strings(count, target)
        elif nested is None:
            begin = self.reserve(count, 8)
            cls = TIME_CLASSES[base]
            given = f"{self.arguments.buffer}, {begin}, {count}, '{TIME_CODES[base]}', {self.ref(cls, 'cls')}"
            self.emit(f"{target} = {self.ref(arrays.read_times, 'times')}({given})")
        elif nested._fixed_size:
            self._fixed(nested, nested._fixed_size, count, target)
        elif nested._min_size:
            self._variable(nested, nested._min_size, count, target)
        else:
            self.emit(f"if {count} > {MAX_EMPTY}: raise ValueError('count')")
            element = self._element(nested, self.at, self.at)
            self.emit(f"{target} = [{element} for {self.fresh('i')} in range({count})]")

    def _numbers(self, code: str, count: str, length: int, target: str) -> None:
        buffer, size = self.arguments.buffer, struct.calcsize("<" + code)
        if self.views:
            begin = self.reserve(count, size)
            self.emit(f"{target} = {self.arguments.view}({buffer}, {begin}, {count}, '{code}')")
            return
        if code == "B":  # those of a fixed length are values
            begin = self.step(count)
            self.emit(f"{target} = {buffer}[{begin}:{self.at}]")
            return
        if length >= 0:
            begin = self.at
            read = f"{self.unpack(f'{length}{code}')}({buffer}, {begin})"
        else:
            begin = self.reserve(count, size)
            unpackers = self.ref(arrays.Unpackers(code), "unpackers", ("unpackers", code))
            read = f"{unpackers}[{count}]({buffer}, {begin})"
        self.emit(f"{target} = list({read})" if code == "?" else f"{target} = {read}")
        if length >= 0:
            self.step(length * size)

    def _strings(self, count: str, target: str) -> None:
        begin = self.move()
        read, end = self.ref(arrays.read_strings, "strings"), self.arguments.end
        self.emit(f"{target}, {self.at} = {read}({self.arguments.buffer}, {begin}, {count}, {end})")

    def _fixed(self, nested: type[Message], size: int, count: str, target: str) -> None:
        """Emit code that decodes an array of messages of one fixed size."""
        begin = self.reserve(count, size)
        loop = self._loop(nested)
        if loop is None or loop.moved:  # more than values to unpack
            i = self.fresh("i")
            element = self._element(nested, i, f"{i} + {size}")
            self.emit(f"{target} = [{element} for {i} in range({begin}, {self.at}, {size})]")
            return
        values = self.fresh("values")
        unpack = struct.Struct("<" + "".join(loop.codes)).iter_unpack
        name = self.ref(unpack, "unpack", ("iter_unpack", *loop.codes))
        body = [*loop.lines, *loop.assignment(values)]
        self._emit_loop(loop, count, target, body, (values, f"{name}({self.arguments.buffer}[{begin}:{self.at}])"))

    def _variable(self, nested: type[Message], min_size: int, count: str, target: str) -> None:
        """Emit code that decodes an array of messages of different sizes, at least ``min_size`` bytes each."""
        self.emit(f"if {count} > ({self.arguments.end} - {self.at}) // {min_size}: raise ValueError('count')")
        loop = self._loop(nested)
        if loop is None:
            place, items, item = self.assign("p", self.at), self.assign("items", "[]"), self.fresh("item")
            given = ", ".join([self.arguments.buffer, place, self.arguments.end, *self._view])
            read = f"{item}, {place} = {self._read(nested)}({given})"
            self.block(f"for {self.fresh('i')} in range({count}):", [read, f"{items}.append({item})"])
            self.emit(f"{target} = {items}")
            self.at = place
            return
        loop.flush()
        if loop.at != loop.begin:
            loop.emit(f"{loop.begin} = {loop.at}")
        self.emit(f"{loop.begin} = {self.at}")
        self._emit_loop(loop, count, target, loop.lines)
        self.at = loop.begin

    def _loop(self, nested: type[Message]) -> Decoder | None:
        """Return the loop that decodes the elements; None if a separate function is better."""
        if self.made is not None or not self.fits(nested) or not _is_plain(nested):
            return None
        self.inlines(nested)
        loop = Decoder(nested, views=self.views, outer=self)
        loop.message(nested, loop.root)
        return loop

    def _emit_loop(self, loop: Decoder, count: str, target: str, body: list[str], *more: tuple[str, str]) -> None:
        """Emit a loop over new objects, and over the iterables given with their names."""
        assert loop.made is not None
        sources = [(name, self._objects(cls, count)) for name, cls in loop.made]
        items = self.assign("items", f"list({sources[0][1]})")
        sources[0] = sources[0][0], items
        names, iterables = zip(*sources, *more, strict=True)
        self.block(f"for {', '.join(names)}, in zip({', '.join(iterables)}):", body)
        self.emit(f"{target} = {items}")

    def _objects(self, cls: str, count: str) -> str:
        return f"map({self.ref(object.__new__, 'new')}, {self.ref(repeat, 'repeat')}({cls}, {count}))"


def _is_plain(cls: type[Message]) -> bool:
    """Return whether a class has no arrays of messages at any depth."""
    for slot_type in cls._slot_types:
        base, length = split_type(slot_type)
        nested = cls._classes.get(base)
        if nested is not None and (length is not None or not _is_plain(nested)):
            return False
    return True


def make_decode(cls: type[Message]) -> Callable[[Any, int, int], Any]:
    """Generate ``_decode``."""
    return _make_decode(Decoder(cls, whole=True))


def make_decode_arrays(cls: type[Message]) -> Callable[..., Any]:
    """Generate ``_decode_arrays``."""
    return _make_decode(Decoder(cls, views=True, whole=True))


def make_read(cls: type[Message]) -> Callable[[Any, int, int], tuple[Any, int]]:
    """Generate ``_read``, whose errors the caller explains, since it knows where the whole message begins."""
    return _make_read(Decoder(cls))


def make_read_arrays(cls: type[Message]) -> Callable[..., tuple[Any, int]]:
    """Generate ``_read_arrays``."""
    return _make_read(Decoder(cls, views=True))


def _make_decode(source: Decoder) -> Callable[..., Any]:
    cls = source.cls
    buffer, start, end, view, exact = source.arguments
    cls_name = source.ref(cls, "cls")
    if cls._fixed_size is not None:
        _make_message(source, last=True)
        left = f"{end} - {start} - {cls._fixed_size}"
        source.emit(f"if {end} - {start} != {cls._fixed_size}: {source.ref(accept_end)}({cls_name}, {left}, {exact})")
    else:
        _make_message(source)
        source.emit(f"if {source.at} != {end}: {source.ref(accept_end)}({cls_name}, {end} - {source.at}, {exact})")
    source.emit(f"return {source.root}")
    mended = f"{source.ref(decode_repaired)}({cls_name}, {buffer}, {start}, {end}, {exact}"
    mended += f", {view})" if source.views else ")"
    return source.function("decode", [*_parameters(source), f"{exact}=False"], _DECODE_ERRORS, lambda _: mended)


def _make_read(source: Decoder) -> Callable[..., tuple[Any, int]]:
    _make_message(source)
    source.emit(f"if {source.at} > {source.arguments.end}: raise ValueError('size')")
    source.emit(f"return {source.root}, {source.at}")
    return source.function("read", _parameters(source))


def _make_message(source: Decoder, *, last: bool = False) -> None:
    """Emit code that decodes the whole message; ``last`` as in `Decoder.flush`."""
    cls = source.cls
    source.emit(f"{source.root} = {source.new(source.ref(cls, 'cls'))}")
    parts = parts_of(cls)
    if len(parts) < 2:
        source.message(cls, source.root)
        source.flush(last=last)
        return
    for part in parts:
        read, begin = source.ref(_make_part(source, part), "part"), source.move()
        buffer, _, end, *view = _parameters(source)
        source.emit(f"{source.at} = {read}({', '.join([buffer, begin, end, *view, source.root])})")


def _make_part(outer: Decoder, fields: Fields) -> Callable[..., int]:
    """Generate a function that decodes some fields of a message, its last argument; it returns the position behind."""
    source = Decoder(outer.cls, views=outer.views, whole=outer.whole)
    source.message(outer.cls, source.root, fields)
    source.flush()
    source.emit(f"return {source.at}")
    return source.function("part", [*_parameters(source), source.root])


def _parameters(source: Decoder) -> tuple[str, ...]:
    return source.arguments[: 4 if source.views else 3]
