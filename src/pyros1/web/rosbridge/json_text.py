"""Writes messages as JSON (no I/O).

``uint8[]`` and ``char[]`` are base64 strings, and NaN and infinity are null.

The text is written directly, since encoding a dict with `json` takes far longer for large arrays: it checks each
character of a base64 string.
"""

from __future__ import annotations

import binascii
import json
import math
from collections.abc import Callable, Iterable
from functools import lru_cache, partial
from typing import Any

import numpy as np

from pyros1.msgs import Message

try:
    import orjson
except ImportError:  # optional
    array_encoder: Callable[[np.ndarray[Any, Any]], bytes] | None = None
else:
    array_encoder = partial(orjson.dumps, option=orjson.OPT_SERIALIZE_NUMPY)
"""Encodes an array of numbers ten times as fast as `repr`; None if orjson is not installed."""

LARGE_TEXT = 16 << 10
"""Number of characters of an array above which its text is passed on as bytes, so that it is not copied."""
_Add = Callable[[str | bytes], object]
_Writer = Callable[[Any, _Add], object]
"""Calls its second argument with each piece of the text for its first argument."""
_string_text = json.JSONEncoder(ensure_ascii=True).encode


def write_message(message: Message, add: _Add) -> None:
    """Write a message as a JSON object.

    Args:
        message: the message. Its arrays of numbers may be numpy arrays.
        add: called with each piece of the text; large pieces may be bytes (ASCII), which should not be copied.
    """
    add("{")
    for name, key, write in _writers(type(message)):
        add(key)
        write(getattr(message, name), add)
    add("}")


@lru_cache(2000)
def _writers(cls: type[Message]) -> list[tuple[str, str, _Writer]]:
    """Return the name of each field, the text before its value, and the function that writes its value."""
    return [
        (name, f"{',' if index else ''}{_string_text(name)}:", _writer(cls, field_type))
        for index, (name, field_type) in enumerate(zip(cls.__slots__, cls._slot_types, strict=True))
    ]


def _writer(cls: type[Message], field_type: str) -> _Writer:
    base_type, bracket, _ = field_type.partition("[")
    if bracket and base_type in _ARRAY_WRITERS:
        return _ARRAY_WRITERS[base_type]
    write = write_message if base_type in cls._classes else _SCALAR_WRITERS.get(base_type, _write_integer)
    if not bracket:
        return write
    return _write_integers if write is _write_integer else partial(_write_elements, write)


def _write_elements(write: _Writer, values: Any, add: _Add) -> None:
    separator = "["
    for value in values:
        add(separator)
        write(value, add)
        separator = ","
    add("]" if separator == "," else "[]")


def _write_integer(value: Any, add: _Add) -> None:
    add(f"{int(value)}")


def _write_float(value: Any, add: _Add) -> None:
    add(repr(float(value)) if math.isfinite(value) else "null")


def _write_bool(value: Any, add: _Add) -> None:
    add("true" if value else "false")


def _write_string(value: str, add: _Add) -> None:
    add(_string_text(value))


def _write_time(value: Any, add: _Add) -> None:
    add(f'{{"secs":{value.secs},"nsecs":{value.nsecs}}}')


def _write_integers(values: Any, add: _Add) -> None:
    add(_array_text(values) if isinstance(values, np.ndarray) else _list_text(list(map(int, values))))


def _write_floats(values: Any, add: _Add) -> None:
    # As in rosbridge_suite, float32 values have all the digits that they have as doubles.
    is_array = isinstance(values, np.ndarray)
    add(_array_text(values.astype(np.float64, copy=False)) if is_array else _list_text(list(map(float, values))))


def _array_text(values: np.ndarray[Any, Any]) -> str | bytes:
    if array_encoder is None:
        return _list_text(values.tolist())
    aligned = np.require(values, requirements=("C_CONTIGUOUS", "ALIGNED"))  # orjson reads the numbers in place
    return _str_if_short(array_encoder(aligned))


def _list_text(numbers: list[int] | list[float]) -> str:
    text = repr(numbers).replace(" ", "")
    if "n" in text:  # of nan or inf
        text = text.replace("-inf", "null").replace("inf", "null").replace("nan", "null")
    return text


def _write_bytes(values: bytes | np.ndarray[Any, Any] | Iterable[int], add: _Add) -> None:
    data = values.data if isinstance(values, np.ndarray) else bytes(values)
    add('"')
    add(_str_if_short(binascii.b2a_base64(data, newline=False)))
    add('"')


def _str_if_short(text: bytes) -> str | bytes:
    return text if len(text) > LARGE_TEXT else str(text, "ascii")


_SCALAR_WRITERS: dict[str, _Writer] = {
    "bool": _write_bool,
    "string": _write_string,
    "float32": _write_float,
    "float64": _write_float,
    "time": _write_time,
    "duration": _write_time,
}
"""Writers of single values, by type; all other types are integers or messages."""
_ARRAY_WRITERS: dict[str, _Writer] = {
    "uint8": _write_bytes,
    "char": _write_bytes,
    "float32": _write_floats,
    "float64": _write_floats,
}
"""Writers of arrays that are not written element by element, by the elements' type."""
