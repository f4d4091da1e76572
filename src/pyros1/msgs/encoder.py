"""Generates the encoders of message classes: one function call from a message to its frame or body.

An encoder does not look for the cause of a failure: it catches whatever a wrong value raises, and ``check.py`` then
walks the message slowly to say which field is to blame.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from pyros1.errors import SerializationError
from pyros1.msgs import arrays
from pyros1.msgs.base import Message
from pyros1.msgs.check import refusal
from pyros1.msgs.source import TIME_CODES, Source, split_type
from pyros1.msgs.spec import STRUCT_CODES

LARGE = 16384
"""Bodies from this size on are sent as a list of buffers, their large arrays not copied."""

WRONG_VALUE = (struct.error, SerializationError, AttributeError, TypeError, ValueError, OverflowError)


class Encoder(Source):
    """Collects the parts of the body: runs of fixed values, and pieces of bytes between them."""

    def __init__(self, cls: type[Message]) -> None:
        super().__init__(cls)
        self.parts: list[tuple[str, list[str]] | str] = []
        self.fixed = 0
        self.pieces: list[str] = []
        self.large = False

    def value(self, code: str, expression: str) -> None:
        if not self.parts or isinstance(self.parts[-1], str):
            self.parts.append(("", []))
        run = self.parts[-1]
        assert not isinstance(run, str)
        self.parts[-1] = (run[0] + code, [*run[1], expression])
        self.fixed += struct.calcsize("<" + code)

    def piece(self, expression: str) -> str:
        local = self.local()
        self.lines.append(f"{local} = {expression}")
        self.pieces.append(local)
        return local

    def message(self, cls: type[Message], owner: str) -> None:
        for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
            base, length = split_type(slot_type)
            expression = f"{owner}.{name}"
            if length is None:
                self._single(base, cls._classes.get(base), expression)
            else:
                self._array(base, length, cls._classes.get(base), expression)

    def _single(self, base: str, nested: type[Message] | None, expression: str) -> None:
        if base in STRUCT_CODES:
            self.value(STRUCT_CODES[base], expression)
        elif base == "string":
            text = self.piece(f"{expression}.encode()")
            self.value("I", f"len({text})")
            self.parts.append(text)
        elif nested is None:
            local = self.local()
            self.lines.append(f"{local} = {expression}")
            self.value(TIME_CODES[base], f"{local}.secs")
            self.value(TIME_CODES[base], f"{local}.nsecs")
        elif self.inlines(nested):
            local = self.local()
            self.lines.append(f"{local} = {expression}")
            self.message(nested, local)
        else:
            self.parts.append(self.piece(f"{self.ref(nested._encode)}({expression})"))

    def _array(self, base: str, length: int, nested: type[Message] | None, expression: str) -> None:
        code = STRUCT_CODES.get(base)
        local = self.local()
        self.lines.append(f"{local} = {expression}")
        if code == "B" and base != "bool":
            self.lines.append(
                f"if {local}.__class__ is not bytes: {local} = {self.ref(arrays.octets)}({local}, {length})"
            )
            if length >= 0:
                # Stock pads bytes that are too short; too many it would cut, which hides an error.
                self.lines.append(f"if len({local}) > {length}: raise ValueError('too long')")
                self.value(f"{length}s", local)
                return
            self.large = True
            self.pieces.append(local)
            self.value("I", f"len({local})")
            self.parts.append(local)
            return
        if length >= 0:
            self.lines.append(f"if len({local}) != {length}: raise ValueError('wrong length')")
            if code is not None and base != "bool" and length:
                self.value(f"{length}{code}", f"*{local}")
                return
        else:
            self.value("I", f"len({local})")
        if code is not None:
            packers = self.ref(arrays.Packers(code), ("packers", code))
            self.large = True
            # numpy's booleans do not pass for integers, its arrays of them do as a whole.
            whole = f"{local}.__class__ is not list" if base == "bool" else f"len({local}) > 256"
            piece = self.piece(f"{packers}.pack({local}) if {whole} else {packers}[len({local})](*{local})")
        elif base == "string":
            piece = self.piece(f"{self.ref(arrays.pack_strings)}({local})")
        elif nested is None:
            piece = self.piece(f"{self.ref(arrays.pack_times)}({local}, '{TIME_CODES[base]}')")
        else:
            encode = self.ref(nested._encode)
            piece = self.piece(f"b''.join([{encode}(e) for e in {local}])")
        self.parts.append(piece)


def make_encode_frame(cls: type[Message]) -> Callable[[Any], Any]:
    """Generate ``_encode_frame``."""
    return _make_encoder(cls, frame=True)


def make_encode(cls: type[Message]) -> Callable[[Any], bytes]:
    """Generate ``_encode``."""
    return _make_encoder(cls, frame=False)


def _make_encoder(cls: type[Message], *, frame: bool) -> Callable[[Any], Any]:
    source = Encoder(cls)
    if frame:
        source.value("I", "size")
    source.message(cls, "m")
    sizes = [f"len({piece})" for piece in source.pieces]
    total = " + ".join([str(source.fixed - 4), *sizes] if source.fixed > 4 or not sizes else sizes)
    expressions = []
    for part in source.parts:
        if isinstance(part, str):
            expressions.append(part)
        else:
            values = ", ".join("size" if value == "size" else value for value in part[1])
            expressions.append(f"{source.pack(part[0])}({values})")
    if frame:
        source.lines.append(f"size = {total}")
    joined = ", ".join(expressions)
    if len(expressions) <= 2 and not source.large:
        source.lines.append(f"return {' + '.join(expressions) or repr(b'')}")
    elif frame and source.large:
        source.lines.append(f"if size < {LARGE}: return b''.join(({joined}))")
        source.lines.append(f"return {source.ref(arrays.gather)}(({joined}), {LARGE})")
    else:
        source.lines.append(f"return b''.join(({joined},))")
    source.names.update(WrongValue=WRONG_VALUE, refusal=refusal)
    return source.function("encode(m)", ("WrongValue", f"refusal({source.ref(cls)}, m, error)"))
