"""Generates functions that copy messages from a publisher to subscribers in the same process.

A copy is equal to the message that a receiver would decode: numbers are checked against the ranges of their types and
rounded to float32, and sequences become tuples. Immutable values are shared: strings, and the bytes of uint8 arrays,
even large ones. Wrong values are rejected, as in the encoder.
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
from pyros1.msgs.records import unpack_messages
from pyros1.msgs.spec import STRUCT_CODES


class Copier(FunctionBuilder):
    """Emits the statements of a copy function in field order; all single numbers share one struct, which is packed and
    unpacked at the end.

    Attributes:
        original, copy, is_top_level: names of the function's parameters. Times that are direct fields of ``copy`` are
            normalised if ``is_top_level`` is true.
    """

    def __init__(self, cls: type[Message]) -> None:
        super().__init__(cls)
        self.original, self.copy, self.is_top_level = map(self.unique_name, ("message", "copy", "is_top_level"))
        self.codes: list[str] = []
        self.sources: list[str] = []
        self.targets: list[str] = []
        self.epilogue: list[str] = []

    def add_message(self, cls: type[Message], source: str, target: str, fields: Fields | None = None) -> None:
        """Emit code that copies a message's fields, by default all of them."""
        for name, slot_type in fields_of(cls) if fields is None else fields:
            base, length = split_type(slot_type)
            nested = cls._classes.get(base)
            if length is None:
                self._add_single(base, nested, f"{source}.{name}", f"{target}.{name}")
            else:
                self._add_array(base, length, nested, f"{source}.{name}", f"{target}.{name}")

    def flush(self) -> None:
        """Emit code that converts the collected numbers."""
        if self.codes:
            packed = self.pack("".join(code.replace("?", "B") for code in self.codes))
            unpack = self.unpack("".join(self.codes))
            self.emit(f"{', '.join(self.targets)}, = {unpack}({packed}({', '.join(self.sources)}))")
            self.lines += self.epilogue

    def add_number(self, code: str, source: str, target: str) -> None:
        self.codes.append(code)
        self.sources.append(source)
        self.targets.append(target)

    def _add_single(self, base: str, nested: type[Message] | None, source: str, target: str) -> None:
        code = STRUCT_CODES.get(base)
        if code == "d":
            variable = self.assign("number", source)
            converted = f"{self.unpack('d')}({self.pack('d')}({variable}))"
            self.emit(f"if {variable}.__class__ is not float: {variable}, = {converted}")
            self.emit(f"{target} = {variable}")
        elif base == "bool":
            variable = self.assign("truth", source)
            self.emit(
                f"if {variable}.__class__ is not bool: {variable} = {self.ref(arrays.to_bool, 'to_bool')}({variable})"
            )
            self.add_number("?", variable, target)
        elif code is not None:
            self.add_number(code, source, target)
        elif base == "string":
            variable = self.assign("text", source)
            converted = f"{variable}.encode().decode()"
            self.emit(f"if {variable}.__class__ is not str or not {variable}.isascii(): {variable} = {converted}")
            self.emit(f"{target} = {variable}")
        elif nested is None or self.reserve_inline(nested):
            original, copy = self.assign("m", source), self.unique_name("copy")
            self.emit(f"{target} = {copy} = {self.new_object(self.class_ref(base, nested))}")
            if nested is not None:
                self.add_message(nested, original, copy)
                return
            for attribute in ("secs", "nsecs"):
                self.add_number(TIME_CODES[base], f"{original}.{attribute}", f"{copy}.{attribute}")
            if target.startswith(f"{self.copy}."):
                self.epilogue.append(f"if {self.is_top_level} and not -1 < {copy}.nsecs < 1000000000: {copy}.canon()")
        else:
            self.emit(f"{target} = {self._copier_name(nested)}({source}, False)")

    def _copier_name(self, nested: type[Message]) -> str:
        return self.ref(nested._copy, "copy")

    def _add_array(self, base: str, length: int, nested: type[Message] | None, source: str, target: str) -> None:
        code = STRUCT_CODES.get(base)
        variable = self.assign("array", source)
        if code == "B" and base != "bool":
            as_bytes = f"{self.ref(arrays.as_bytes, 'as_bytes')}({variable}, {length})"
            self.emit(f"if {variable}.__class__ is not bytes: {variable} = {as_bytes}")
            if length >= 0:
                self.emit(f"if len({variable}) > {length}: raise ValueError('too long')")
                variable += f".ljust({length}, b'\\0')"
            self.emit(f"{target} = {variable}")
            return
        if length >= 0:
            self.emit(f"if len({variable}) != {length}: raise ValueError('wrong length')")
        if code is not None:
            packers = self.packers(base, code)
            unpack_code = "?" if base == "bool" else code
            unpackers = self.ref(arrays.Unpackers(unpack_code), "unpackers", ("unpackers", unpack_code))
            copied_code = f"{unpackers}[len({variable})]({packers}.pack({variable}), 0)"
            self.emit(f"{target} = {f'list({copied_code})' if base == 'bool' else copied_code}")
        elif base == "string":
            self.emit(f"{target} = {self.ref(_copy_strings, 'strings')}({variable})")
        elif nested is None:
            codes, element = TIME_CODES[base] * 2, self.unique_name("each")
            arguments = f"{element}, {self.class_ref(base, nested)}, {self.pack(codes)}, {self.unpack(codes)}"
            self.emit(f"{target} = [{self.ref(_copy_time, 'time')}({arguments}) for {element} in {variable}]")
        else:
            top_level_flags = f"{self.ref(repeat, 'repeat')}(False)"
            if nested._fixed_size:  # it may be a numpy array
                unpacked = f"{self.ref(unpack_messages, 'unpack')}({variable}, {self.ref(nested, 'cls')})"
                self.emit(f"if {variable}.__class__ is not list: {variable} = {unpacked}")
            self.emit(f"{target} = list(map({self._copier_name(nested)}, {variable}, {top_level_flags}))")


def _copy_time(
    value: Any, cls: type[Time | Duration], pack: Callable[..., bytes], unpack: Callable[..., tuple[int, int]]
) -> Time | Duration:
    copy = cls.__new__(cls)
    copy.secs, copy.nsecs = unpack(pack(value.secs, value.nsecs))
    return copy


def _copy_strings(values: Sequence[str]) -> list[str]:
    return list(map(bytes.decode, map(str.encode, values)))


def make_copy(cls: type[Message]) -> Callable[..., Any]:
    """Generate and return ``_copy``; its second argument says whether the message is a top-level message, rather than
    part of another.
    """
    copier = Copier(cls)
    message, copy, is_top_level = copier.original, copier.copy, copier.is_top_level
    copier.emit(f"{copy} = {copier.new_object(copier.ref(cls, 'cls'))}")
    groups = field_groups(cls)
    if len(groups) < 2:
        copier.add_message(cls, message, copy)
        copier.flush()
    for group in groups if len(groups) > 1 else ():
        copier.emit(f"{copier.ref(_make_part(cls, group), 'part')}({message}, {copy}, {is_top_level})")
    copier.emit(f"return {copy}")
    parameters = [message, f"{is_top_level}=True"]
    return copier.compile_function("copy", parameters, ENCODE_ERRORS, retry_expression(copier, cls, "_copy", message))


def _make_part(cls: type[Message], fields: Fields) -> Callable[[Any, Any, bool], None]:
    """Generate and return a function that copies some fields of a message to another."""
    copier = Copier(cls)
    copier.add_message(cls, copier.original, copier.copy, fields)
    copier.flush()
    return copier.compile_function("part", [copier.original, copier.copy, copier.is_top_level])
