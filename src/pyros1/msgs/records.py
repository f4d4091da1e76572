"""Arrays of messages as numpy arrays with one column per field, for types of fixed size such as geometry_msgs/Pose.

The elements of such an array lie in memory exactly as they are transmitted, so that a whole array is received and sent
without a loop. ``poses["position"]["x"]`` is the column of all x coordinates; so is ``poses.position.x``, unless a name
is already an attribute of numpy arrays. ``poses[0].position.x`` is a single value, as for a list of messages.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

from pyros1.ground.errors import SerializationError
from pyros1.msgs.base import Message, message_class
from pyros1.msgs.generator import TIME_CODES, fields_of, split_type
from pyros1.msgs.spec import STRUCT_CODES


def record_dtype(cls: type[Message]) -> Any:
    """Return the numpy dtype of an array of messages: packed, little-endian, with the names and types of the fields.

    Messages in messages are nested dtypes; times and durations have the fields ``secs`` and ``nsecs``; arrays of fixed
    length are subarrays of shape (n,).

    Args:
        cls: the class of the elements.

    Raises:
        TypeError: the messages have no fixed size, since they contain strings or arrays of variable length, or they
            have no fields; or ``cls`` is not a message class.
    """
    if not isinstance(cls, type) or not issubclass(cls, Message) or not hasattr(cls, "_slot_types"):
        raise TypeError(f"record_dtype takes a message class such as geometry_msgs.msg.Point, not {cls!r:.80}")
    definition = message_class(cls)
    if not definition._fixed_size:
        raise TypeError(f"{definition._type} has no fixed size{_variable_field(definition)}: use a list of messages")
    return _dtype(definition)


def _variable_field(cls: type[Message], prefix: str = "") -> str:
    """Return a note that names the first field of variable size; empty if there is none."""
    for name, slot_type in fields_of(cls):
        base, length = split_type(slot_type)
        if base == "string" or length == -1:
            return f" (field {prefix}{name} is a {slot_type})"
        nested = cls._classes.get(base)
        if nested is not None and (note := _variable_field(nested, f"{prefix}{name}.")):
            return note
    return ""


@lru_cache(maxsize=1000)
def _dtype(cls: type[Message]) -> Any:
    import numpy  # noqa: PLC0415  slow to import, and most programs have no such arrays

    def element_dtype(base: str) -> Any:
        if base in STRUCT_CODES:
            return numpy.dtype("?" if base == "bool" else "<" + STRUCT_CODES[base])
        if base in TIME_CODES:
            code = "<" + TIME_CODES[base]
            return numpy.dtype((numpy.record, [("secs", code), ("nsecs", code)]))
        return _dtype(cls._classes[base])

    fields: list[tuple[Any, ...]] = []
    for name, slot_type in fields_of(cls):
        base, length = split_type(slot_type)
        fields.append((name, element_dtype(base)) if length is None else (name, element_dtype(base), (length,)))
    return numpy.dtype((numpy.record, fields))


def view_records(buffer: bytes, position: int, count: int, cls: type[Message]) -> Any:
    """Return ``count`` messages at a position of a buffer as a read-only recarray of shape (count,) in that buffer."""
    import numpy  # noqa: PLC0415

    dtype = _dtype(cls)
    array = numpy.frombuffer(buffer, dtype, count, position) if count else numpy.empty(0, dtype)
    return array.view(numpy.recarray)


def is_record_array(values: Any) -> bool:
    """Return whether the value of a field is a numpy array with named fields."""
    return getattr(getattr(values, "dtype", None), "names", None) is not None


def pack_messages(values: Iterable[Any], cls: type[Message]) -> bytes:
    """Encode the elements of an array of messages of fixed size.

    Args:
        values: messages, or a numpy array with the names and types of `record_dtype`.
        cls: the class of the elements.

    Raises:
        SerializationError: the array has other fields, or a message is wrong.
    """
    if not is_record_array(values):
        return b"".join([cls._encode(value) for value in values])
    check_records(values, cls)
    encoded: bytes = values.astype(_dtype(cls), copy=False).tobytes()  # type: ignore[attr-defined]  # a numpy array
    return encoded


def unpack_messages(values: Any, cls: type[Message]) -> Iterable[Any]:
    """Return the elements of an array of messages: new messages if ``values`` is a numpy array with named fields.

    Raises:
        SerializationError: the array has other fields than the messages.
    """
    if not is_record_array(values):
        elements: Iterable[Any] = values
        return elements
    data, size = pack_messages(values, cls), cls._fixed_size or 0
    return [cls._read(data, position, position + size)[0] for position in range(0, len(data), size)]


def check_records(values: Any, cls: type[Message], field: str = "") -> None:
    """Check whether a numpy array with named fields can be sent as an array of messages.

    Args:
        values: the array.
        cls: the class of the elements.
        field: name of the field, for the error message.

    Raises:
        SerializationError: its fields differ, a type would lose digits, or it does not have one dimension.
    """
    import numpy  # noqa: PLC0415

    subject = f"field {field}" if field else f"an array of {cls._type}"
    if not cls._fixed_size:
        raise SerializationError(f"{subject} must be a list of messages: {cls._type} has no fixed size")
    if values.ndim != 1:
        raise SerializationError(f"{subject} must be an array of one dimension, not of shape {values.shape}")
    expected = _dtype(cls)
    if values.dtype != expected and not (
        _names(values.dtype) == _names(expected) and numpy.can_cast(values.dtype, expected, "safe")
    ):
        raise SerializationError(
            f"{subject} takes an array with the dtype record_dtype({cls.__name__}), not {values.dtype!s:.200}"
        )


def _names(dtype: Any) -> Any:
    """Return the names of a dtype's fields at all depths, and the shapes of its subarrays."""
    element = dtype.base
    return dtype.shape, element.names and [(name, _names(element.fields[name][0])) for name in element.names]
