"""Generates the encoders of message classes: one function call from a message to its frame or body.

An encoder does not determine the cause of a failure: it only catches all errors that wrong values can cause. Then
``check.py`` goes through the message to find the wrong field, which is slow.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import SerializationError
from pyros1.msgs import arrays
from pyros1.msgs.base import Message
from pyros1.msgs.generator import TIME_CODES, Fields, FunctionBuilder, field_groups, fields_of, split_type
from pyros1.msgs.numpy_compat import retry_with_plain_numbers
from pyros1.msgs.records import pack_messages
from pyros1.msgs.spec import STRUCT_CODES

LARGE_BODY_SIZE = 16384
"""Bodies of at least this many bytes are sent as a list of buffers, without copying their large arrays."""

_PREFIX_SIZE = 4
"""Size in bytes of a frame's length prefix."""
_MAX_SUMMANDS = 50
"""Maximum number of lengths in one sum: Python's compiler limits the length of expressions."""

ENCODE_ERRORS = (struct.error, SerializationError, AttributeError, TypeError, ValueError, OverflowError)


class _Run:
    """Adjacent values of fixed size, which are packed with one struct."""

    def __init__(self) -> None:
        self.codes: list[str] = []
        self.expressions: list[str] = []


class Encoder(FunctionBuilder):
    """Collects the parts of the body: runs of values of fixed size, and the pieces of bytes between them.

    Attributes:
        parts: the runs, and the names of the variables with the pieces, in order.
        fixed_size: total size of the runs in bytes.
        has_large_pieces: whether a piece can be large.
    """

    def __init__(self, cls: type[Message]) -> None:
        super().__init__(cls)
        self.parts: list[_Run | str] = []
        self.fixed_size = 0
        self.has_large_pieces = False

    def add_value(self, code: str, expression: str) -> None:
        run = self.parts[-1] if self.parts else None
        if not isinstance(run, _Run):
            run = _Run()
            self.parts.append(run)
        run.codes.append(code)
        run.expressions.append(expression)
        self.fixed_size += struct.calcsize("<" + code)

    def add_piece(self, expression: str) -> None:
        self.parts.append(self.assign("piece", expression))

    def add_message(self, cls: type[Message], owner: str, fields: Fields | None = None) -> None:
        """Collect the values of a message's fields, by default of all fields."""
        for name, slot_type in fields_of(cls) if fields is None else fields:
            base, length = split_type(slot_type)
            expression = f"{owner}.{name}"
            if length is None:
                self._add_single(base, cls._classes.get(base), expression)
            else:
                self._add_array(base, length, cls._classes.get(base), expression)

    def _add_single(self, base: str, nested: type[Message] | None, expression: str) -> None:
        if base == "bool":
            variable = self.assign("truth", expression)
            self.emit(
                f"if {variable}.__class__ is not bool: {variable} = {self.ref(arrays.to_bool, 'to_bool')}({variable})"
            )
            self.add_value(STRUCT_CODES[base], variable)
        elif base in STRUCT_CODES:
            self.add_value(STRUCT_CODES[base], expression)
        elif base == "string":
            text = self.assign("text", f"{expression}.encode()")
            self.add_value("I", f"len({text})")
            self.parts.append(text)
        elif nested is None:
            variable = self.assign("time", expression)
            self.add_value(TIME_CODES[base], f"{variable}.secs")
            self.add_value(TIME_CODES[base], f"{variable}.nsecs")
        elif self.reserve_inline(nested):
            self.add_message(nested, self.assign("m", expression))
        else:
            self.add_piece(f"{self._encoder_name(nested)}({expression})")

    def _encoder_name(self, nested: type[Message]) -> str:
        return self.ref(nested._encode, "encode")

    def _add_array(self, base: str, length: int, nested: type[Message] | None, expression: str) -> None:
        code = STRUCT_CODES.get(base)
        variable = self.assign("array", expression)
        if code == "B" and base != "bool":
            as_bytes = f"{self.ref(arrays.as_bytes, 'as_bytes')}({variable}, {length})"
            self.emit(f"if {variable}.__class__ is not bytes: {variable} = {as_bytes}")
            if length >= 0:
                # Stock pads arrays that are too short. It also truncates arrays that are too long, but that would hide
                # an error.
                self.emit(f"if len({variable}) > {length}: raise ValueError('too long')")
                self.add_value(f"{length}s", variable)
                return
            self.has_large_pieces = True
            self.add_value("I", f"len({variable})")
            self.parts.append(variable)
            return
        if length >= 0:
            self.emit(f"if len({variable}) != {length}: raise ValueError('wrong length')")
            if code is not None and base != "bool" and length:
                self.add_value(f"{length}{code}", f"*{variable}")
                return
        else:
            self.add_value("I", f"len({variable})")
        if code is not None:
            self.has_large_pieces = True
            packers = self.packers(base, code)
            if base == "bool":
                self.add_piece(f"{packers}.pack({variable})")
            else:
                self.add_piece(
                    f"{packers}.pack({variable}) if len({variable}) > 256 else {packers}[len({variable})](*{variable})"
                )
        elif base == "string":
            self.add_piece(f"{self.ref(arrays.pack_strings, 'strings')}({variable})")
        elif nested is None:
            self.add_piece(f"{self.ref(arrays.pack_times, 'times')}({variable}, '{TIME_CODES[base]}')")
        else:
            element = self.unique_name("each")
            joined = f"b''.join([{self._encoder_name(nested)}({element}) for {element} in {variable}])"
            if nested._fixed_size:  # it may be a numpy array
                self.has_large_pieces = True
                packed = f"{self.ref(pack_messages, 'pack')}({variable}, {self.ref(nested, 'cls')})"
                joined += f" if {variable}.__class__ is list else {packed}"
            self.add_piece(joined)


def make_encode_frame(cls: type[Message]) -> Callable[[Any], Any]:
    """Generate and return ``_encode_frame``."""
    return _make_encoder(cls, makes_frame=True)


def make_encode(cls: type[Message]) -> Callable[[Any], bytes]:
    """Generate and return ``_encode``."""
    return _make_encoder(cls, makes_frame=False)


def _make_encoder(cls: type[Message], *, makes_frame: bool) -> Callable[[Any], Any]:
    encoder = Encoder(cls)
    message, size = encoder.unique_name("message"), encoder.unique_name("size")
    if makes_frame:
        encoder.add_value("I", size)
    groups = field_groups(cls)
    if len(groups) < 2:
        encoder.add_message(cls, message)
    for group in groups if len(groups) > 1 else ():
        encode = _make_part(cls, group)
        encoder.add_piece(f"{encoder.ref(encode, 'part')}({message})")
    expressions = _part_expressions(encoder)
    if makes_frame:
        pieces = [part for part in encoder.parts if isinstance(part, str)]
        encoder.emit(f"{size} = {_size_expression(encoder.fixed_size - _PREFIX_SIZE, pieces)}")
    if makes_frame and encoder.has_large_pieces:
        joined_expressions = ", ".join(expressions)
        encoder.emit(f"if {size} < {LARGE_BODY_SIZE}: return b''.join(({joined_expressions}))")
        encoder.emit(f"return {encoder.ref(arrays.coalesce, 'coalesce')}(({joined_expressions}), {LARGE_BODY_SIZE})")
    else:
        encoder.emit(f"return {_join_expression(expressions)}")
    codec = "_encode_frame" if makes_frame else "_encode"
    return encoder.compile_function("encode", [message], ENCODE_ERRORS, retry_expression(encoder, cls, codec, message))


def retry_expression(builder: FunctionBuilder, cls: type[Message], codec: str, message: str) -> Callable[[str], str]:
    """Return a function that, given the variable with a codec's error, returns the expression that retries the
    codec.
    """
    return lambda error: (
        f"{builder.ref(retry_with_plain_numbers, 'retry')}({builder.ref(cls, 'cls')}, {codec!r}, {message}, {error})"
    )


def _make_part(cls: type[Message], fields: Fields) -> Callable[[Any], bytes]:
    """Generate and return a function that encodes some fields of a message."""
    encoder = Encoder(cls)
    message = encoder.unique_name("message")
    encoder.add_message(cls, message, fields)
    encoder.emit(f"return {_join_expression(_part_expressions(encoder))}")
    return encoder.compile_function("part", [message])


def _part_expressions(encoder: Encoder) -> list[str]:
    """Return the expressions for the collected parts; each evaluates to bytes."""
    return [
        part if isinstance(part, str) else f"{encoder.pack(''.join(part.codes))}({', '.join(part.expressions)})"
        for part in encoder.parts
    ]


def _join_expression(expressions: list[str]) -> str:
    """Return the expression that joins the bytes of all expressions."""
    if len(expressions) == 1:
        return expressions[0]
    if len(expressions) == 2:
        return " + ".join(expressions)
    return f"b''.join(({', '.join(expressions)},))" if expressions else repr(b"")


def _size_expression(fixed: int, pieces: list[str]) -> str:
    """Return the expression for the size of the body."""
    if len(pieces) > _MAX_SUMMANDS:
        return f"{fixed} + sum(map(len, ({', '.join(pieces)})))"
    return " + ".join([str(fixed)] * (fixed > 0 or not pieces) + [f"len({piece})" for piece in pieces])
