"""Generates the functions that copy messages from a publisher to subscribers in the same process.

A copy equals the message that a receiver would decode: numbers are checked against the ranges of their types and
rounded to float32, sequences become tuples. Values that cannot change are shared: strings, and the bytes of uint8
arrays, even if large. Wrong values are refused as by the encoder.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import repeat
from typing import Any

from pyros1.ground.timing import Duration, Time
from pyros1.msgs import arrays
from pyros1.msgs.base import Message
from pyros1.msgs.encoder import ENCODE_ERRORS, retry_expression
from pyros1.msgs.generator import TIME_CODES, Fields, Source, fields_of, parts_of, split_type
from pyros1.msgs.spec import STRUCT_CODES


class Copier(Source):
    """Emits statements in field order; the single numbers share one struct, packed and unpacked at the end.

    Attributes:
        original, copy, whole: the function's parameters. Times that are fields of ``copy`` itself are normalised if
            ``whole`` is true.
    """

    def __init__(self, cls: type[Message]) -> None:
        super().__init__(cls)
        self.original, self.copy, self.whole = map(self.fresh, ("message", "copy", "whole"))
        self.codes: list[str] = []
        self.sources: list[str] = []
        self.targets: list[str] = []
        self.after: list[str] = []

    def message(self, cls: type[Message], source: str, target: str, fields: Fields | None = None) -> None:
        """Emit code that copies a message's fields, by default all of them."""
        for name, slot_type in fields_of(cls) if fields is None else fields:
            base, length = split_type(slot_type)
            nested = cls._classes.get(base)
            if length is None:
                self._single(base, nested, f"{source}.{name}", f"{target}.{name}")
            else:
                self._array(base, length, nested, f"{source}.{name}", f"{target}.{name}")

    def flush(self) -> None:
        """Emit code that converts the collected numbers."""
        if self.codes:
            packed = self.pack("".join(code.replace("?", "B") for code in self.codes))
            unpack = self.unpack("".join(self.codes))
            self.emit(f"{', '.join(self.targets)}, = {unpack}({packed}({', '.join(self.sources)}))")
            self.lines += self.after

    def convert(self, code: str, source: str, target: str) -> None:
        self.codes.append(code)
        self.sources.append(source)
        self.targets.append(target)

    def _single(self, base: str, nested: type[Message] | None, source: str, target: str) -> None:
        code = STRUCT_CODES.get(base)
        if code == "d":
            local = self.assign("number", source)
            converted = f"{self.unpack('d')}({self.pack('d')}({local}))"
            self.emit(f"if {local}.__class__ is not float: {local}, = {converted}")
            self.emit(f"{target} = {local}")
        elif base == "bool":
            local = self.assign("truth", source)
            self.emit(f"if {local}.__class__ is not bool: {local} = {self.ref(arrays.to_bool, 'as_bool')}({local})")
            self.convert("?", local, target)
        elif code is not None:
            self.convert(code, source, target)
        elif base == "string":
            local = self.assign("text", source)
            converted = f"{local}.encode().decode()"
            self.emit(f"if {local}.__class__ is not str or not {local}.isascii(): {local} = {converted}")
            self.emit(f"{target} = {local}")
        elif nested is None or self.inlines(nested):
            original, copy = self.assign("m", source), self.fresh("copy")
            self.emit(f"{target} = {copy} = {self.new(self.class_of(base, nested))}")
            if nested is not None:
                self.message(nested, original, copy)
                return
            for part in ("secs", "nsecs"):
                self.convert(TIME_CODES[base], f"{original}.{part}", f"{copy}.{part}")
            if target.startswith(f"{self.copy}."):
                self.after.append(f"if {self.whole} and not -1 < {copy}.nsecs < 1000000000: {copy}.canon()")
        else:
            self.emit(f"{target} = {self._copy(nested)}({source}, False)")

    def _copy(self, nested: type[Message]) -> str:
        return self.ref(nested._copy, "copy")

    def _array(self, base: str, length: int, nested: type[Message] | None, source: str, target: str) -> None:
        code = STRUCT_CODES.get(base)
        local = self.assign("array", source)
        if code == "B" and base != "bool":
            octets = f"{self.ref(arrays.octets, 'octets')}({local}, {length})"
            self.emit(f"if {local}.__class__ is not bytes: {local} = {octets}")
            if length >= 0:
                self.emit(f"if len({local}) > {length}: raise ValueError('too long')")
                local += f".ljust({length}, b'\\0')"
            self.emit(f"{target} = {local}")
            return
        if length >= 0:
            self.emit(f"if len({local}) != {length}: raise ValueError('wrong length')")
        if code is not None:
            packers = self.packers(base, code)
            unpack_code = "?" if base == "bool" else code
            unpackers = self.ref(arrays.Unpackers(unpack_code), "unpackers", ("unpackers", unpack_code))
            copied = f"{unpackers}[len({local})]({packers}.pack({local}), 0)"
            self.emit(f"{target} = {f'list({copied})' if base == 'bool' else copied}")
        elif base == "string":
            self.emit(f"{target} = {self.ref(_copy_strings, 'strings')}({local})")
        elif nested is None:
            codes, each = TIME_CODES[base] * 2, self.fresh("each")
            given = f"{each}, {self.class_of(base, nested)}, {self.pack(codes)}, {self.unpack(codes)}"
            self.emit(f"{target} = [{self.ref(_copy_time, 'time')}({given}) for {each} in {local}]")
        else:
            parts = f"{self.ref(repeat, 'repeat')}(False)"
            self.emit(f"{target} = list(map({self._copy(nested)}, {local}, {parts}))")


def _copy_time(
    value: Any, cls: type[Time | Duration], pack: Callable[..., bytes], unpack: Callable[..., tuple[int, int]]
) -> Time | Duration:
    copy = cls.__new__(cls)
    copy.secs, copy.nsecs = unpack(pack(value.secs, value.nsecs))
    return copy


def _copy_strings(values: Sequence[str]) -> list[str]:
    return list(map(bytes.decode, map(str.encode, values)))


def make_copy(cls: type[Message]) -> Callable[..., Any]:
    """Generate ``_copy``; its second argument is whether the message is a whole one, no part of another."""
    source = Copier(cls)
    message, copy, whole = source.original, source.copy, source.whole
    source.emit(f"{copy} = {source.new(source.ref(cls, 'cls'))}")
    parts = parts_of(cls)
    if len(parts) < 2:
        source.message(cls, message, copy)
        source.flush()
    for part in parts if len(parts) > 1 else ():
        source.emit(f"{source.ref(_make_part(cls, part), 'part')}({message}, {copy}, {whole})")
    source.emit(f"return {copy}")
    parameters = [message, f"{whole}=True"]
    return source.function("copy", parameters, ENCODE_ERRORS, retry_expression(source, cls, "_copy", message))


def _make_part(cls: type[Message], fields: Fields) -> Callable[[Any, Any, bool], None]:
    """Generate a function that copies some fields of a message to another."""
    source = Copier(cls)
    source.message(cls, source.original, source.copy, fields)
    source.flush()
    return source.function("part", [source.original, source.copy, source.whole])
