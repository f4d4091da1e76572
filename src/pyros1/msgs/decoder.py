"""Generates the decoders of message classes.

A decoder does not determine the cause of a failure: it only catches all errors that wrong bytes can cause. Then
``repair.py`` repairs faults that stock accepts, such as a string that is not UTF-8, and decoding is tried again. If
that fails, ``check.py`` goes through the bytes to find the position and the reason, which is slow. The decoder itself
only checks the number of elements against the remaining bytes, which limits memory and time, and where messages end.
Reading beyond ``end`` in a larger buffer is harmless, since the final position is wrong then. Bytes after the message
are ignored, as in stock ROS, unless ``exact`` is true.

Times keep both numbers as they were sent, even a billion nanoseconds or more. As in stock ROS, only times that are
fields of the top-level message are normalised, not the times in its header or in other nested messages.

The objects of an array of messages are created in bulk with ``map``, in half the time of separate calls.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from itertools import repeat
from typing import Any, NamedTuple

from pyros1.ground.errors import DeserializationError
from pyros1.msgs import arrays
from pyros1.msgs.base import Message
from pyros1.msgs.factory import MAX_EMPTY_ELEMENTS
from pyros1.msgs.generator import TIME_CLASSES, TIME_CODES, Fields, FunctionBuilder, field_groups, fields_of, split_type
from pyros1.msgs.repair import check_end, decode_repaired
from pyros1.msgs.spec import STRUCT_CODES

_DECODE_ERRORS = (struct.error, DeserializationError, ValueError, OverflowError, TypeError)


class _Arguments(NamedTuple):
    """Names of a decoder's parameters."""

    buffer: str
    start: str
    end: str
    view: str
    exact: str


class Decoder(FunctionBuilder):
    """Emits the statements of a decoder in field order.

    Args:
        cls: the message class.
        uses_view: whether numeric arrays are created by the function ``view``, a fourth argument of the decoder.
        outer: the decoder for whose function this decoder emits a loop over messages of ``cls``; None for a function of
            its own.
        is_top_level: whether ``cls`` is the class of the top-level message, not of a nested one.

    Attributes:
        position: name of the variable that holds the current position. There are two such variables: each step stores
            the next position in the other one, so that the bytes between them can be sliced out.
        begin: name of the variable that held the position at first.
        has_moved: whether the position has changed since then.
        created: in a loop, names of the objects to create in each iteration and of their classes; otherwise None.
    """

    def __init__(
        self, cls: type[Message], *, uses_view: bool = False, outer: Decoder | None = None, is_top_level: bool = False
    ) -> None:
        super().__init__(cls, None if outer is None else outer.scope)
        self.uses_view, self.is_top_level = uses_view, is_top_level
        self._position_names = self.unique_name("p"), self.unique_name("q")
        self.created: list[tuple[str, str]] | None
        if outer is None:
            self.arguments = _Arguments(*map(self.unique_name, _Arguments._fields))
            self.position, self.created = self.arguments.start, None
            self.root = self.unique_name("m")
        else:
            self.arguments = outer.arguments
            self.root = self.unique_name("m")
            self.position, self.created = self._position_names[0], [(self.root, self.ref(cls, "cls"))]
        self.begin, self.has_moved = self.position, False
        self.codes: list[str] = []
        self._targets: list[str] = []
        self.epilogue: list[str] = []

    # Positions --------------------------------------------------------------------------------------------------------

    def switch_position(self) -> str:
        """Switch to the other variable, which the caller must set to the next position; return the previous
        variable.
        """
        begin, self.position, self.has_moved = (
            self.position,
            self._position_names[self.position == self._position_names[0]],
            True,
        )
        return begin

    def advance(self, size: str | int) -> str:
        """Emit code that advances by ``size`` bytes; return the variable with the position before that."""
        begin = self.switch_position()
        self.emit(f"{self.position} = {begin} + {size}")
        return begin

    def checked_advance(self, count: str, size: int) -> str:
        """Emit code that advances by ``count`` values of ``size`` bytes if there are enough; return the variable with
        their position.
        """
        begin = self.advance(f"{count} * {size}" if size != 1 else count)
        self.emit(f"if {self.position} > {self.arguments.end}: raise ValueError('count')")
        return begin

    # Values of fixed size, which are unpacked together ----------------------------------------------------------------

    def add_value(self, code: str, target: str) -> None:
        self.codes.append(code)
        self._targets.append(target)

    def read_length(self) -> str:
        """Emit code that reads a length; return the name of its variable."""
        count = self.unique_name("n")
        self.add_value("I", count)
        self.flush()
        return count

    def assignment(self, values: str) -> list[str]:
        """Return the statements that assign the collected values to their targets."""
        return [f"{', '.join(self._targets)}, = {values}", *self.epilogue]

    def flush(self, *, last: bool = False) -> None:
        """Emit code that unpacks the collected values and advances the position.

        Args:
            last: whether the position is no longer needed afterwards.
        """
        if not self.codes:
            return
        struct_format = "".join(self.codes)
        self.lines += self.assignment(f"{self.unpack(struct_format)}({self.arguments.buffer}, {self.position})")
        if not last:
            self.advance(struct.calcsize("<" + struct_format))
        self.codes, self._targets, self.epilogue = [], [], []

    # Fields -----------------------------------------------------------------------------------------------------------

    def add_message(self, cls: type[Message], owner: str, fields: Fields | None = None) -> None:
        """Emit code that decodes a message's fields, by default all of them."""
        for name, slot_type in fields_of(cls) if fields is None else fields:
            base, length = split_type(slot_type)
            target = f"{owner}.{name}"
            if length is None:
                self._add_single(base, cls._classes.get(base), target)
            else:
                self._add_array(base, length, cls._classes.get(base), target)

    def _add_single(self, base: str, nested: type[Message] | None, target: str) -> None:
        if base in STRUCT_CODES:
            self.add_value("?" if base == "bool" else STRUCT_CODES[base], target)
        elif base == "string":
            size = self.read_length()
            begin = self.advance(size)
            slice_expression = f"{self.arguments.buffer}[{begin}:{self.position}]"
            large_code = (
                f"{self.ref(arrays.read_large_string, 'text')}({self.arguments.buffer}, {begin}, {self.position})"
            )
            self.emit(
                f"{target} = {slice_expression}.decode() if {size} < {arrays.LARGE_STRING_SIZE} else {large_code}"
            )
        elif nested is None:
            variable = self._emit_new_object(self.class_ref(base, nested), target)
            self.add_value(TIME_CODES[base], f"{variable}.secs")
            self.add_value(TIME_CODES[base], f"{variable}.nsecs")
            if self.is_top_level and target.startswith(f"{self.root}."):
                self.epilogue.append(f"if not -1 < {variable}.nsecs < 1000000000: {variable}.canon()")
        elif self.reserve_inline(nested):
            self.add_message(nested, self._emit_new_object(self.class_ref(base, nested), target))
        else:
            self.flush()
            self._emit_call(self._reader_name(nested), target)

    def _emit_new_object(self, cls: str, target: str) -> str:
        """Emit code that creates an object; return the name of its variable."""
        variable = self.unique_name("m")
        if self.created is None:
            self.emit(f"{target} = {variable} = {self.new_object(cls)}")
        else:
            self.created.append((variable, cls))
            self.emit(f"{target} = {variable}")
        return variable

    def _emit_call(self, function: str, target: str, *arguments: str) -> None:
        """Emit a call to a function that returns a value and the position after it."""
        begin = self.switch_position()
        parameters = ", ".join([self.arguments.buffer, begin, *arguments, self.arguments.end, *self._view_arguments])
        self.emit(f"{target}, {self.position} = {function}({parameters})")

    @property
    def _view_arguments(self) -> list[str]:
        """The additional argument for nested decoders: the name of ``view``, if it is used."""
        return [self.arguments.view] if self.uses_view else []

    def _reader_name(self, nested: type[Message]) -> str:
        return self.ref(nested._read_arrays if self.uses_view else nested._read, "read")

    def _element_expression(self, nested: type[Message], begin: str, end: str) -> str:
        """Return the expression that decodes a message of fixed size."""
        return (
            f"{self._reader_name(nested)}({', '.join([self.arguments.buffer, begin, end, *self._view_arguments])})[0]"
        )

    # Arrays -----------------------------------------------------------------------------------------------------------

    def _add_array(self, base: str, length: int, nested: type[Message] | None, target: str) -> None:
        code = "?" if base == "bool" else STRUCT_CODES.get(base)
        if code == "B" and length >= 0 and not self.uses_view:
            self.add_value(f"{length}s", target)
            return
        if length < 0:
            count = self.read_length()
        else:
            count = str(length)
            self.flush()
        if code is not None:
            self._emit_number_array(code, count, length, target)
        elif base == "string":
            self._emit_string_array(count, target)
        elif nested is None:
            begin = self.checked_advance(count, 8)
            cls = TIME_CLASSES[base]
            arguments = f"{self.arguments.buffer}, {begin}, {count}, '{TIME_CODES[base]}', {self.ref(cls, 'cls')}"
            self.emit(f"{target} = {self.ref(arrays.read_times, 'times')}({arguments})")
        elif nested._fixed_size:
            self._emit_fixed_size_array(nested, nested._fixed_size, count, target)
        elif nested._min_size:
            self._emit_variable_size_array(nested, nested._min_size, count, target)
        else:
            self.emit(f"if {count} > {MAX_EMPTY_ELEMENTS}: raise ValueError('count')")
            element = self._element_expression(nested, self.position, self.position)
            self.emit(f"{target} = [{element} for {self.unique_name('i')} in range({count})]")

    def _emit_number_array(self, code: str, count: str, length: int, target: str) -> None:
        buffer, size = self.arguments.buffer, struct.calcsize("<" + code)
        if self.uses_view:
            begin = self.checked_advance(count, size)
            self.emit(f"{target} = {self.arguments.view}({buffer}, {begin}, {count}, '{code}')")
            return
        if code == "B":  # arrays of fixed length were handled as single values
            begin = self.advance(count)
            self.emit(f"{target} = {buffer}[{begin}:{self.position}]")
            return
        if length >= 0:
            begin = self.position
            read_code = f"{self.unpack(f'{length}{code}')}({buffer}, {begin})"
        else:
            begin = self.checked_advance(count, size)
            unpackers = self.ref(arrays.Unpackers(code), "unpackers", ("unpackers", code))
            read_code = f"{unpackers}[{count}]({buffer}, {begin})"
        self.emit(f"{target} = list({read_code})" if code == "?" else f"{target} = {read_code}")
        if length >= 0:
            self.advance(length * size)

    def _emit_string_array(self, count: str, target: str) -> None:
        begin = self.switch_position()
        function, end = self.ref(arrays.read_strings, "strings"), self.arguments.end
        self.emit(f"{target}, {self.position} = {function}({self.arguments.buffer}, {begin}, {count}, {end})")

    def _emit_fixed_size_array(self, nested: type[Message], size: int, count: str, target: str) -> None:
        """Emit code that decodes an array of messages of one fixed size."""
        begin = self.checked_advance(count, size)
        if not self.uses_view:
            self._emit_objects(nested, size, count, begin, target)
            return
        arguments = f"{self.arguments.buffer}, {begin}, {count}, {self.ref(nested, 'cls')}"
        records = self.assign("records", f"{self.arguments.view}({arguments})")
        lines, self.lines = self.lines, []
        self._emit_objects(nested, size, count, begin, target)
        loop_lines, self.lines = self.lines, lines
        self.block(f"if {records} is None:", loop_lines)
        self.block("else:", [f"{target} = {records}"])

    def _emit_objects(self, nested: type[Message], size: int, count: str, begin: str, target: str) -> None:
        """Emit code that creates a list of ``count`` messages of ``size`` bytes from the bytes up to the position."""
        loop = self._make_loop(nested)
        if loop is None or loop.has_moved:  # decoding an element takes more than unpacking values
            offset_name = self.unique_name("i")
            element = self._element_expression(nested, offset_name, f"{offset_name} + {size}")
            self.emit(f"{target} = [{element} for {offset_name} in range({begin}, {self.position}, {size})]")
            return
        values = self.unique_name("values")
        unpack = struct.Struct("<" + "".join(loop.codes)).iter_unpack
        name = self.ref(unpack, "unpack", ("iter_unpack", *loop.codes))
        body = [*loop.lines, *loop.assignment(values)]
        self._emit_loop(
            loop, count, target, body, (values, f"{name}({self.arguments.buffer}[{begin}:{self.position}])")
        )

    def _emit_variable_size_array(self, nested: type[Message], min_size: int, count: str, target: str) -> None:
        """Emit code that decodes an array of messages of different sizes, at least ``min_size`` bytes each."""
        self.emit(f"if {count} > ({self.arguments.end} - {self.position}) // {min_size}: raise ValueError('count')")
        loop = self._make_loop(nested)
        if loop is None:
            position, items, item = (
                self.assign("p", self.position),
                self.assign("items", "[]"),
                self.unique_name("item"),
            )
            arguments = ", ".join([self.arguments.buffer, position, self.arguments.end, *self._view_arguments])
            read_code = f"{item}, {position} = {self._reader_name(nested)}({arguments})"
            self.block(f"for {self.unique_name('i')} in range({count}):", [read_code, f"{items}.append({item})"])
            self.emit(f"{target} = {items}")
            self.position = position
            return
        loop.flush()
        if loop.position != loop.begin:
            loop.emit(f"{loop.begin} = {loop.position}")
        self.emit(f"{loop.begin} = {self.position}")
        self._emit_loop(loop, count, target, loop.lines)
        self.position = loop.begin

    def _make_loop(self, nested: type[Message]) -> Decoder | None:
        """Return the decoder for a loop over the elements of an array, or None if a separate function is better."""
        if self.created is not None or not self.can_inline(nested) or not _has_no_message_arrays(nested):
            return None
        self.reserve_inline(nested)
        loop = Decoder(nested, uses_view=self.uses_view, outer=self)
        loop.add_message(nested, loop.root)
        return loop

    def _emit_loop(
        self, loop: Decoder, count: str, target: str, body: list[str], *iterables_by_name: tuple[str, str]
    ) -> None:
        """Emit a loop that creates ``count`` objects, runs ``body`` for each, and assigns their list to ``target``.

        Args:
            iterables_by_name: further iterables to loop over in parallel: (loop variable, expression).
        """
        assert loop.created is not None
        sources = [(name, self._objects_expression(cls, count)) for name, cls in loop.created]
        items = self.assign("items", f"list({sources[0][1]})")
        sources[0] = sources[0][0], items
        names, iterables = zip(*sources, *iterables_by_name, strict=True)
        self.block(f"for {', '.join(names)}, in zip({', '.join(iterables)}):", body)
        self.emit(f"{target} = {items}")

    def _objects_expression(self, cls: str, count: str) -> str:
        return f"map({self.ref(object.__new__, 'new')}, {self.ref(repeat, 'repeat')}({cls}, {count}))"


def _has_no_message_arrays(cls: type[Message]) -> bool:
    """Return whether a class has no arrays of messages at any depth."""
    for slot_type in cls._slot_types:
        base, length = split_type(slot_type)
        nested = cls._classes.get(base)
        if nested is not None and (length is not None or not _has_no_message_arrays(nested)):
            return False
    return True


def make_decode(cls: type[Message]) -> Callable[[Any, int, int], Any]:
    """Generate and return ``_decode``."""
    return _make_decode(Decoder(cls, is_top_level=True))


def make_decode_arrays(cls: type[Message]) -> Callable[..., Any]:
    """Generate and return ``_decode_arrays``."""
    return _make_decode(Decoder(cls, uses_view=True, is_top_level=True))


def make_read(cls: type[Message]) -> Callable[[Any, int, int], tuple[Any, int]]:
    """Generate and return ``_read``. Its caller explains errors, since only the caller knows where the top-level
    message begins.
    """
    return _make_read(Decoder(cls))


def make_read_arrays(cls: type[Message]) -> Callable[..., tuple[Any, int]]:
    """Generate and return ``_read_arrays``."""
    return _make_read(Decoder(cls, uses_view=True))


def _make_decode(decoder: Decoder) -> Callable[..., Any]:
    cls = decoder.cls
    buffer, start, end, view, exact = decoder.arguments
    cls_name = decoder.ref(cls, "cls")
    if cls._fixed_size is not None:
        _emit_message(decoder, last=True)
        surplus = f"{end} - {start} - {cls._fixed_size}"
        decoder.emit(
            f"if {end} - {start} != {cls._fixed_size}: {decoder.ref(check_end)}({cls_name}, {surplus}, {exact})"
        )
    else:
        _emit_message(decoder)
        surplus = f"{end} - {decoder.position}"
        decoder.emit(f"if {decoder.position} != {end}: {decoder.ref(check_end)}({cls_name}, {surplus}, {exact})")
    decoder.emit(f"return {decoder.root}")
    repaired = f"{decoder.ref(decode_repaired)}({cls_name}, {buffer}, {start}, {end}, {exact}"
    repaired += f", {view})" if decoder.uses_view else ")"
    return decoder.compile_function(
        "decode", [*_parameters(decoder), f"{exact}=False"], _DECODE_ERRORS, lambda _: repaired
    )


def _make_read(decoder: Decoder) -> Callable[..., tuple[Any, int]]:
    _emit_message(decoder)
    decoder.emit(f"if {decoder.position} > {decoder.arguments.end}: raise ValueError('size')")
    decoder.emit(f"return {decoder.root}, {decoder.position}")
    return decoder.compile_function("read", _parameters(decoder))


def _emit_message(decoder: Decoder, *, last: bool = False) -> None:
    """Emit code that decodes the message; ``last`` as in `Decoder.flush`."""
    cls = decoder.cls
    decoder.emit(f"{decoder.root} = {decoder.new_object(decoder.ref(cls, 'cls'))}")
    groups = field_groups(cls)
    if len(groups) < 2:
        decoder.add_message(cls, decoder.root)
        decoder.flush(last=last)
        return
    for group in groups:
        function, begin = decoder.ref(_make_part(decoder, group), "part"), decoder.switch_position()
        buffer, _, end, *view = _parameters(decoder)
        decoder.emit(f"{decoder.position} = {function}({', '.join([buffer, begin, end, *view, decoder.root])})")


def _make_part(outer: Decoder, fields: Fields) -> Callable[..., int]:
    """Generate and return a function that decodes some fields into a message, which is its last argument, and returns
    the position after these fields.
    """
    decoder = Decoder(outer.cls, uses_view=outer.uses_view, is_top_level=outer.is_top_level)
    decoder.add_message(outer.cls, decoder.root, fields)
    decoder.flush()
    decoder.emit(f"return {decoder.position}")
    return decoder.compile_function("part", [*_parameters(decoder), decoder.root])


def _parameters(decoder: Decoder) -> tuple[str, ...]:
    return decoder.arguments[: 4 if decoder.uses_view else 3]
