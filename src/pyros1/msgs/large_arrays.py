"""Splits messages that are large because of a single byte array, such as images, so that the array is never copied.

The array of such a message can be received directly into its final ``bytes`` object, separately from the other bytes.
"""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

from pyros1.ground.errors import DeserializationError, LengthError, MessageError
from pyros1.msgs.base import AnyMsg, Message, View, message_class
from pyros1.msgs.generator import split_type
from pyros1.msgs.spec import STRUCT_CODES

_ZERO_LENGTH = bytes(4)
_read_size = struct.Struct("<I").unpack_from


class Layout(NamedTuple):
    """Position of the byte array in the messages of a type.

    Attributes:
        field: name of the array's field.
        tail_size: number of encoded bytes after the array.
        has_length_field: whether the array has a length field; False if the array is the whole message.
    """

    field: str
    tail_size: int
    has_length_field: bool = True


class SplitBody:
    """An encoded message in three pieces.

    Args:
        head: the bytes before the array, without its length.
        data: the bytes of the array.
        tail: the bytes after the array.
        has_length_field: as in `Layout`.
    """

    __slots__ = ("data", "has_length_field", "head", "tail")

    def __init__(self, head: bytes, data: bytes, tail: bytes, has_length_field: bool = True) -> None:
        self.head = head
        self.data = data
        self.tail = tail
        self.has_length_field = has_length_field

    def array(self, *, in_place: bool) -> Any:
        """Return the array as bytes, or as a read-only view if it is in shared memory and ``in_place`` is true."""
        return self.data

    def join(self) -> bytes:
        """Return the body in one piece."""
        if not self.has_length_field:
            return self.data
        return b"".join((self.head, len(self.data).to_bytes(4, "little"), self.data, self.tail))


def find_layout(cls: type[Any]) -> Layout | None:
    """Return the position of the byte array in the messages of a class.

    Returns:
        The layout; None if the class has no top-level uint8[] field, several such fields, or fields of variable size
        after that field.
    """
    if issubclass(cls, AnyMsg):
        return Layout("_buff", 0, has_length_field=False)
    try:
        cls = message_class(cls)
    except MessageError:
        return None  # a subscriber's own class that stands in for a message class, as in tf's listeners
    array_indexes = [index for index, slot_type in enumerate(cls._slot_types) if slot_type in ("uint8[]", "char[]")]
    if len(array_indexes) != 1:
        return None
    tail_size = 0
    for slot_type in cls._slot_types[array_indexes[0] + 1 :]:
        size = _fixed_size(cls, slot_type)
        if size is None:
            return None
        tail_size += size
    return Layout(cls.__slots__[array_indexes[0]], tail_size)


def _fixed_size(cls: type[Message], slot_type: str) -> int | None:
    base, length = split_type(slot_type)
    if length == -1 or base == "string":
        return None
    count = 1 if length is None else length
    if base in STRUCT_CODES:
        return count * struct.calcsize("<" + STRUCT_CODES[base])
    nested = cls._classes.get(base)
    size = 8 if nested is None else nested._fixed_size
    return None if size is None else count * size


def decode_split(
    cls: type[Any], array_layout: Layout | None, body: SplitBody, view: View | None = None, exact: bool = False
) -> Any:
    """Decode a message from its pieces.

    Args:
        cls: message class or AnyMsg.
        array_layout: the layout of the class; None if there is none, or if the class needs whole messages.
        body: the pieces of the message.
        view: creates numeric arrays, see ``array_views.py``; None for bytes and tuples.
        exact: whether the message must end with the body.

    Raises:
        LengthError: the message ends before or after the end of the body, and ``exact`` is true.
        DeserializationError: the bytes are not a message of this class.
    """
    if array_layout is not None and array_layout.has_length_field == body.has_length_field:
        if not array_layout.has_length_field:
            return AnyMsg(body.data)
        body_without_array = b"".join((body.head, _ZERO_LENGTH, body.tail))  # the same message with an empty array
        try:
            message = decode(cls, body_without_array, view, exact=True)
        except (DeserializationError, LengthError):
            message = None
        # If the array of this message is not empty, the pieces were not split at the ends of the array.
        if message is not None and not len(getattr(message, array_layout.field)):
            array = body.array(in_place=view is not None)
            setattr(message, array_layout.field, array if view is None else view(array, 0, len(array), "B"))
            return message
    return decode(cls, body.join(), view, exact)


def decode(cls: type[Any], body: bytes, view: View | None, exact: bool = False) -> Any:
    """Decode a whole body; arguments and errors as for `decode_split`."""
    if view is None or issubclass(cls, AnyMsg):
        return cls._decode(body, 0, len(body), exact)
    return cls._decode_arrays(body, 0, len(body), view, exact)


def split_frame(frame: list[Any], tail_size: int) -> SplitBody | None:
    """Return the pieces of an encoder's frame, given as a list of buffers; None if it has a different structure.

    Args:
        frame: buffers with the u32 length, the head and the array length; the array; and the tail, if any.
        tail_size: number of bytes after the array.
    """
    head_part, data = frame[0], frame[1]
    tail_part = frame[2] if len(frame) == 3 else b""
    if (
        len(frame) > 3
        or len(tail_part) != tail_size
        or len(head_part) < 8
        or head_part.__class__ is not bytes
        or data.__class__ is not bytes
    ):
        return None
    if _read_size(head_part, len(head_part) - 4)[0] != len(data):
        return None
    return SplitBody(head_part[4:-4], data, tail_part)
