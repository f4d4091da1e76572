"""Generates the encoders of message classes: one function call from a message to its frame or body.

An encoder does not look for the cause of a failure: it catches all errors that wrong values cause, and ``check.py``
then goes through the message slowly to find the wrong field.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import SerializationError
from pyros1.msgs import arrays
from pyros1.msgs.base import Message
from pyros1.msgs.generator import TIME_CODES, Fields, Source, fields_of, parts_of, split_type
from pyros1.msgs.numpy_compat import with_plain_numbers
from pyros1.msgs.spec import STRUCT_CODES

LARGE = 16384
"""Size in bytes from which bodies are sent as a list of buffers, without a copy of their large arrays."""

_PREFIX = 4
"""Bytes of a frame's length."""
_SUMMANDS = 50
"""Maximum number of lengths in one sum: Python's compiler limits the length of expressions."""

ENCODE_ERRORS = (struct.error, SerializationError, AttributeError, TypeError, ValueError, OverflowError)


class _Run:
    """Adjacent values of fixed size, which one struct packs."""

    def __init__(self) -> None:
        self.codes: list[str] = []
        self.expressions: list[str] = []


class Encoder(Source):
    """Collects the parts of the body: runs of fixed values, and pieces of bytes between them.

    Attributes:
        parts: the runs, and the variables of the pieces, in order.
        fixed: size of all runs in bytes.
        large: whether a piece can be large.
    """

    def __init__(self, cls: type[Message]) -> None:
        super().__init__(cls)
        self.parts: list[_Run | str] = []
        self.fixed = 0
        self.large = False

    def value(self, code: str, expression: str) -> None:
        run = self.parts[-1] if self.parts else None
        if not isinstance(run, _Run):
            run = _Run()
            self.parts.append(run)
        run.codes.append(code)
        run.expressions.append(expression)
        self.fixed += struct.calcsize("<" + code)

    def piece(self, expression: str) -> None:
        self.parts.append(self.assign("piece", expression))

    def message(self, cls: type[Message], owner: str, fields: Fields | None = None) -> None:
        """Collect the values of a message's fields, by default of all."""
        for name, slot_type in fields_of(cls) if fields is None else fields:
            base, length = split_type(slot_type)
            expression = f"{owner}.{name}"
            if length is None:
                self._single(base, cls._classes.get(base), expression)
            else:
                self._array(base, length, cls._classes.get(base), expression)

    def _single(self, base: str, nested: type[Message] | None, expression: str) -> None:
        if base == "bool":
            local = self.assign("truth", expression)
            self.emit(f"if {local}.__class__ is not bool: {local} = {self.ref(arrays.to_bool, 'as_bool')}({local})")
            self.value(STRUCT_CODES[base], local)
        elif base in STRUCT_CODES:
            self.value(STRUCT_CODES[base], expression)
        elif base == "string":
            text = self.assign("text", f"{expression}.encode()")
            self.value("I", f"len({text})")
            self.parts.append(text)
        elif nested is None:
            local = self.assign("time", expression)
            self.value(TIME_CODES[base], f"{local}.secs")
            self.value(TIME_CODES[base], f"{local}.nsecs")
        elif self.inlines(nested):
            self.message(nested, self.assign("m", expression))
        else:
            self.piece(f"{self._encode(nested)}({expression})")

    def _encode(self, nested: type[Message]) -> str:
        return self.ref(nested._encode, "encode")

    def _array(self, base: str, length: int, nested: type[Message] | None, expression: str) -> None:
        code = STRUCT_CODES.get(base)
        local = self.assign("array", expression)
        if code == "B" and base != "bool":
            octets = f"{self.ref(arrays.octets, 'octets')}({local}, {length})"
            self.emit(f"if {local}.__class__ is not bytes: {local} = {octets}")
            if length >= 0:
                # Stock pads bytes that are too short. It also cuts those that are too long, which would hide an error.
                self.emit(f"if len({local}) > {length}: raise ValueError('too long')")
                self.value(f"{length}s", local)
                return
            self.large = True
            self.value("I", f"len({local})")
            self.parts.append(local)
            return
        if length >= 0:
            self.emit(f"if len({local}) != {length}: raise ValueError('wrong length')")
            if code is not None and base != "bool" and length:
                self.value(f"{length}{code}", f"*{local}")
                return
        else:
            self.value("I", f"len({local})")
        if code is not None:
            self.large = True
            packers = self.packers(base, code)
            if base == "bool":
                self.piece(f"{packers}.pack({local})")
            else:
                self.piece(f"{packers}.pack({local}) if len({local}) > 256 else {packers}[len({local})](*{local})")
        elif base == "string":
            self.piece(f"{self.ref(arrays.pack_strings, 'strings')}({local})")
        elif nested is None:
            self.piece(f"{self.ref(arrays.pack_times, 'times')}({local}, '{TIME_CODES[base]}')")
        else:
            each = self.fresh("each")
            self.piece(f"b''.join([{self._encode(nested)}({each}) for {each} in {local}])")


def make_encode_frame(cls: type[Message]) -> Callable[[Any], Any]:
    """Generate ``_encode_frame``."""
    return _make_encoder(cls, frame=True)


def make_encode(cls: type[Message]) -> Callable[[Any], bytes]:
    """Generate ``_encode``."""
    return _make_encoder(cls, frame=False)


def _make_encoder(cls: type[Message], *, frame: bool) -> Callable[[Any], Any]:
    source = Encoder(cls)
    message, size = source.fresh("message"), source.fresh("size")
    if frame:
        source.value("I", size)
    parts = parts_of(cls)
    if len(parts) < 2:
        source.message(cls, message)
    for part in parts if len(parts) > 1 else ():
        encode = _make_part(cls, part)
        source.piece(f"{source.ref(encode, 'part')}({message})")
    expressions = _expressions(source)
    if frame:
        pieces = [part for part in source.parts if isinstance(part, str)]
        source.emit(f"{size} = {_total(source.fixed - _PREFIX, pieces)}")
    if frame and source.large:
        joined = ", ".join(expressions)
        source.emit(f"if {size} < {LARGE}: return b''.join(({joined}))")
        source.emit(f"return {source.ref(arrays.coalesce, 'gather')}(({joined}), {LARGE})")
    else:
        source.emit(f"return {_joined(expressions)}")
    codec = "_encode_frame" if frame else "_encode"
    return source.function("encode", [message], ENCODE_ERRORS, retry_expression(source, cls, codec, message))


def retry_expression(source: Source, cls: type[Message], codec: str, message: str) -> Callable[[str], str]:
    """Return a function from the name of a codec's error to the expression of its second try."""
    return lambda error: (
        f"{source.ref(with_plain_numbers, 'again')}({source.ref(cls, 'cls')}, {codec!r}, {message}, {error})"
    )


def _make_part(cls: type[Message], fields: Fields) -> Callable[[Any], bytes]:
    """Generate a function that encodes some fields of a message."""
    source = Encoder(cls)
    message = source.fresh("message")
    source.message(cls, message, fields)
    source.emit(f"return {_joined(_expressions(source))}")
    return source.function("part", [message])


def _expressions(source: Encoder) -> list[str]:
    """Return the expressions of the collected bytes."""
    return [
        part if isinstance(part, str) else f"{source.pack(''.join(part.codes))}({', '.join(part.expressions)})"
        for part in source.parts
    ]


def _joined(expressions: list[str]) -> str:
    """Return the expression of all bytes, joined."""
    if len(expressions) == 1:
        return expressions[0]
    if len(expressions) == 2:
        return " + ".join(expressions)
    return f"b''.join(({', '.join(expressions)},))" if expressions else repr(b"")


def _total(fixed: int, pieces: list[str]) -> str:
    """Return the expression of the body's size."""
    if len(pieces) > _SUMMANDS:
        return f"{fixed} + sum(map(len, ({', '.join(pieces)})))"
    return " + ".join([str(fixed)] * (fixed > 0 or not pieces) + [f"len({piece})" for piece in pieces])
