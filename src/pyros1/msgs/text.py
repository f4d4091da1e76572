"""Messages as text: what ``rostopic echo`` prints and ``str(message)`` returns (G25, L38, L40, L41).

The form is YAML-like: ``name: value`` lines, nested messages indented by two spaces, arrays of numbers in brackets,
other arrays as ``- `` items. It is part of the interface: programs read it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from pyros1.msgs.base import Message, message_class
from pyros1.msgs.yamltext import block_sequence, double_quoted
from pyros1.timing import Time, TVal

FieldFilter = Callable[[Message], Iterable[str]]


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
    """Return a message or a field's value as text, without a line end behind it.

    Args:
        value: a message, or any value that a field can have.
        no_string: show strings by their length only.
        no_array: show arrays by their type and length only.
        width: least width of numbers, which fixes their number of characters; None prints them as they are.
        time_offset: show times as differences to this one.
        field_filter: returns the names of the fields to show of a message; None shows all.
        type_name: the type of ``value`` if it is a field's value, for example ``uint8[]``.
        indent: what the lines begin with.
    """
    style = _Style(width, no_string, no_array, time_offset, field_filter)
    if type_name is not None:
        value = _field_value(value, type_name, style)
    return _format(value, indent, style)


def _format(value: Any, indent: str, style: _Style) -> str:
    kind = type(value)
    if (kind is int or kind is float) and style.width is not None:
        return _fixed(value, style.width)
    if isinstance(value, str):
        return double_quoted(value) if value else "''"
    if isinstance(value, TVal):
        return _format_time(value, indent, style)
    if kind is list or kind is tuple:
        return _format_array(value, indent, style)
    if isinstance(value, Message):
        return _format_message(value, indent, style)
    return str(value)


def _fixed(value: float, width: int) -> str:
    if isinstance(value, int):
        return f"{value:{width}d}"
    text = f"{value:.{width}f}"
    # Never cut digits in front of the point.
    return text[: max(text.find("."), width)]


def _format_time(value: TVal, indent: str, style: _Style) -> str:
    if style.time_offset is not None and isinstance(value, Time):
        value = value - style.time_offset
    width = style.width
    if width is None:
        return f"\n{indent}secs: {value.secs}\n{indent}nsecs: {value.nsecs:9d}"
    return f"\n{indent}secs: {value.secs:{width}d}\n{indent}nsecs: {value.nsecs:{width}d}"


def _format_array(values: Any, indent: str, style: _Style) -> str:
    if not values:
        return "[]"
    first = values[0]
    if type(first) in (int, float) and style.width is not None:
        return f"[{', '.join(_format(value, indent, style) for value in values)}]"
    if isinstance(first, str):
        return "".join(f"\n{indent}{line}" for line in block_sequence(list(values)))
    if type(first) in (int, float, bool):
        return str(list(values))
    inner = indent + "  "
    return "".join(f"\n{indent}- {_format(value, inner, style)}" for value in values)


def _format_message(message: Message, indent: str, style: _Style) -> str:
    cls = message_class(type(message))
    shown = None if style.field_filter is None else set(style.field_filter(message))
    lines = []
    for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
        if shown is None or name in shown:
            value = _field_value(getattr(message, name), slot_type, style)
            # Stock does not look into arrays of messages for strings to hide.
            inner = style if slot_type[-1] != "]" else style._replace(no_string=False, no_array=False)
            lines.append(f"{indent}{name}: {_format(value, '  ' + indent, inner)}")
    text = "\n".join(lines)
    return "\n" + text if indent else text


def _field_value(value: Any, slot_type: str, style: _Style) -> Any:
    """Return what is shown of a field's value."""
    if style.no_array and "[" in slot_type:
        # Of a fixed length stock leaves the opening bracket and the number in place.
        return f"<array type: {slot_type.rstrip('[]')}, length: {len(value)}>"
    if style.no_string and slot_type == "string":
        return f"<string length: {len(value)}>"
    if style.no_string and slot_type == "string[]":
        return f"<array type: string, length: {len(value)}>"
    if "uint8[" in slot_type and isinstance(value, (bytes, bytearray, str)):
        return [ord(char) for char in value] if isinstance(value, str) else list(value)
    return value
