"""Formats messages as text, as ``rostopic echo`` and ``str(message)`` do (G25, L38, L40, L41).

The format is similar to YAML: ``name: value`` lines, nested messages indented by two spaces, arrays of numbers in
brackets, other arrays as ``- `` items. The format is part of the interface, since programs parse it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from pyros1.ground.timing import Time, TVal
from pyros1.msgs.base import Message, message_class
from pyros1.msgs.yamltext import item_pieces, quoted_pieces

FieldFilter = Callable[[Message], Iterable[str]]
Emit = Callable[[str], object]

_SLICE_LENGTH = 1 << 14
"""Number of array elements converted at a time."""


class _Style(NamedTuple):
    width: int | None
    no_string: bool
    no_array: bool
    time_offset: Time | None
    field_filter: FieldFilter | None


def format_message(
    value: Any,
    *,
    no_string: bool = False,
    no_array: bool = False,
    width: int | None = None,
    time_offset: Time | None = None,
    field_filter: FieldFilter | None = None,
    type_name: str | None = None,
    indent: str = "",
) -> str:
    """Return a message or a field's value as text, without a final line break.

    Args:
        value: a message, or any value that a field can have.
        no_string: whether to print only the lengths of strings.
        no_array: whether to print only the types and lengths of arrays.
        width: number of characters to print per number; None prints numbers in full.
        time_offset: time that is subtracted from printed times; None prints absolute times.
        field_filter: returns the names of a message's fields to print; None prints all.
        type_name: the type of ``value`` if it is a field's value, for example ``uint8[]``.
        indent: prefix of each line.
    """
    pieces: list[str] = []
    style = _Style(width, no_string, no_array, time_offset, field_filter)
    _emit_top_level(pieces.append, value, style, type_name, indent)
    return "".join(pieces)


def emit_message(
    emit: Emit,
    value: Any,
    *,
    no_string: bool = False,
    no_array: bool = False,
    width: int | None = None,
    time_offset: Time | None = None,
    type_name: str | None = None,
) -> None:
    """Emit, in small pieces, the text that `format_message` would return, so that the whole text is never in memory.

    Args:
        emit: called with each piece.
    """
    _emit_top_level(emit, value, _Style(width, no_string, no_array, time_offset, None), type_name, "")


def _emit_top_level(emit: Emit, value: Any, style: _Style, type_name: str | None, indent: str) -> None:
    if type_name is not None:
        value = _field_value(value, type_name, style)
    _emit_value(emit, value, indent, style)


def _emit_value(emit: Emit, value: Any, indent: str, style: _Style) -> None:
    value_type = type(value)
    if (value_type is int or value_type is float) and style.width is not None:
        emit(_number_text(value, style.width))
    elif isinstance(value, str):
        if value:
            for piece in quoted_pieces(value):
                emit(piece)
        else:
            emit("''")
    elif isinstance(value, TVal):
        emit(_format_time(value, indent, style))
    elif value_type is list or value_type is tuple or value_type is memoryview:
        _emit_array(emit, value, indent, style)
    elif isinstance(value, Message):
        _emit_fields(emit, value, indent, style)
    else:
        emit(str(value))


def _number_text(value: float, width: int) -> str:
    if isinstance(value, int):
        return f"{value:{width}d}"
    text = f"{value:.{width}f}"
    # Never truncate digits before the decimal point.
    return text[: max(text.find("."), width)]


def _format_time(value: TVal, indent: str, style: _Style) -> str:
    if style.time_offset is not None and isinstance(value, Time):
        value = value - style.time_offset
    width = style.width
    if width is None:
        return f"\n{indent}secs: {value.secs}\n{indent}nsecs: {value.nsecs:9d}"
    return f"\n{indent}secs: {value.secs:{width}d}\n{indent}nsecs: {value.nsecs:{width}d}"


def _emit_array(emit: Emit, values: Any, indent: str, style: _Style) -> None:
    if not values:
        emit("[]")
        return
    first = values[0]
    if isinstance(first, str):
        line = f"\n{indent}"
        for value in values:
            emit(f"{line}- ")
            for piece in item_pieces(value) if isinstance(value, str) else (str(value),):
                emit(piece.replace("\n", line))
    elif type(first) in (int, float, bool):
        _emit_numbers(emit, values, style)
    else:
        inner_indent = indent + "  "
        for value in values:
            emit(f"\n{indent}- ")
            _emit_value(emit, value, inner_indent, style)


def _emit_numbers(emit: Emit, values: Any, style: _Style) -> None:
    width = None if type(values[0]) is bool else style.width
    separator = "["
    for start in range(0, len(values), _SLICE_LENGTH):
        part = values[start : start + _SLICE_LENGTH]
        if width is None:
            text = str(list(part))[1:-1]
        else:
            text = ", ".join(
                _number_text(value, width) if type(value) in (int, float) else str(value) for value in part
            )
        emit(separator + text)
        separator = ", "
    emit("]")


def _emit_fields(emit: Emit, message: Message, indent: str, style: _Style) -> None:
    cls = message_class(type(message))
    selected = None if style.field_filter is None else set(style.field_filter(message))
    if indent:
        emit("\n")
    prefix = indent
    for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
        if selected is None or name in selected:
            value = _field_value(getattr(message, name), slot_type, style)
            # Stock does not hide strings inside arrays of messages.
            inner_style = style if slot_type[-1] != "]" else style._replace(no_string=False, no_array=False)
            emit(f"{prefix}{name}: ")
            _emit_value(emit, value, "  " + indent, inner_style)
            prefix = "\n" + indent


def _field_value(value: Any, slot_type: str, style: _Style) -> Any:
    """Return a field's value in the form in which it is printed."""
    if style.no_array and "[" in slot_type:
        # For a fixed length, stock keeps the opening bracket and the number.
        return f"<array type: {slot_type.rstrip('[]')}, length: {len(value)}>"
    if style.no_string and slot_type == "string":
        return f"<string length: {len(value)}>"
    if style.no_string and slot_type == "string[]":
        return f"<array type: string, length: {len(value)}>"
    if "uint8[" in slot_type and isinstance(value, (bytes, bytearray, str)):
        # Bytes are printed as numbers.
        return [ord(character) for character in value] if isinstance(value, str) else memoryview(value)
    return value
