"""Generates functions that copy messages from a publisher to subscribers in the same process.

A copy is equal to the message that a receiver would decode: numbers are checked against the ranges of their types and
rounded to float32, and sequences become tuples. Immutable values are shared: strings, and the bytes of uint8 arrays,
even large ones. Wrong values are rejected as by the encoder.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import repeat
from typing import Any

from pyros1.ground.timing import Duration, Time
from pyros1.msgs import arrays
from pyros1.msgs.base import Message
from pyros1.msgs.encoder import ENCODE_ERRORS, retry_expression
from pyros1.msgs.generator import TIME_CODES, Fields, FunctionBuilder, field_groups, fields_of, split_type
from pyros1.msgs.spec import STRUCT_CODES


class Copier(FunctionBuilder):
    """Emits statements in field order; all single numbers share one struct, which is packed and unpacked at the end.

    Attributes:
        original, copy, is_top_level: names of the function's parameters. Times that are fields of ``copy`` itself are
            normalised if ``is_top_level`` is true.
    """

    def __init__(self, cls: type[Message]) -> None:
        super().__init__(cls)
        self.original, self.copy, self.is_top_level = map(self.unique_name, ("message", "copy", "is_top_level"))
        self.codes: list[str] = []
        self.sources: list[str] = []
        self.targets: list[str] = []
        self.epilogue: list[str] = []

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
            self.lines += self.epilogue

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
        elif nested is None or self.reserve_inline(nested):
            original, copy = self.assign("m", source), self.unique_name("copy")
            self.emit(f"{target} = {copy} = {self.new_object(self.class_ref(base, nested))}")
            if nested is not None:
                self.message(nested, original, copy)
                return
            for attribute in ("secs", "nsecs"):
                self.convert(TIME_CODES[base], f"{original}.{attribute}", f"{copy}.{attribute}")
            if target.startswith(f"{self.copy}."):
                self.epilogue.append(f"if {self.is_top_level} and not -1 < {copy}.nsecs < 1000000000: {copy}.canon()")
        else:
            self.emit(f"{target} = {self._copy(nested)}({source}, False)")

    def _copy(self, nested: type[Message]) -> str:
        return self.ref(nested._copy, "copy")

    def _array(self, base: str, length: int, nested: type[Message] | None, source: str, target: str) -> None:
        code = STRUCT_CODES.get(base)
        local = self.assign("array", source)
        if code == "B" and base != "bool":
            as_bytes = f"{self.ref(arrays.as_bytes, 'octets')}({local}, {length})"
            self.emit(f"if {local}.__class__ is not bytes: {local} = {as_bytes}")
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
            codes, each = TIME_CODES[base] * 2, self.unique_name("each")
            arguments = f"{each}, {self.class_ref(base, nested)}, {self.pack(codes)}, {self.unpack(codes)}"
            self.emit(f"{target} = [{self.ref(_copy_time, 'time')}({arguments}) for {each} in {local}]")
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
    """Generate ``_copy``; its second argument tells whether the message is a top-level one, not part of another."""
    copier = Copier(cls)
    message, copy, is_top_level = copier.original, copier.copy, copier.is_top_level
    copier.emit(f"{copy} = {copier.new_object(copier.ref(cls, 'cls'))}")
    parts = field_groups(cls)
    if len(parts) < 2:
        copier.message(cls, message, copy)
        copier.flush()
    for part in parts if len(parts) > 1 else ():
        copier.emit(f"{copier.ref(_make_part(cls, part), 'part')}({message}, {copy}, {is_top_level})")
    copier.emit(f"return {copy}")
    parameters = [message, f"{is_top_level}=True"]
    return copier.function("copy", parameters, ENCODE_ERRORS, retry_expression(copier, cls, "_copy", message))


def _make_part(cls: type[Message], fields: Fields) -> Callable[[Any, Any, bool], None]:
    """Generate a function that copies some fields of a message to another."""
    copier = Copier(cls)
    copier.message(cls, copier.original, copier.copy, fields)
    copier.flush()
    return copier.function("part", [copier.original, copier.copy, copier.is_top_level])
