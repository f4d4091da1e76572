"""The functions that are generated for message classes, as the generators make them."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from pyros1.msgs.base import Frame, View, message_class
from pyros1.msgs.copier import make_copy
from pyros1.msgs.decoder import make_decode, make_decode_arrays, make_read, make_read_arrays
from pyros1.msgs.encoder import make_encode, make_encode_frame


@lru_cache(maxsize=100)  # classes of random definitions are not kept for long
def _made(maker: Callable[[Any], Any], cls: Any) -> Any:
    return maker(message_class(cls))


def encode(message: Any) -> bytes:
    """Return the encoded body of a message."""
    return _made(make_encode, type(message))(message)


def encode_frame(message: Any) -> Frame:
    """Return a message with its length before it, in one piece or in several around large arrays."""
    return _made(make_encode_frame, type(message))(message)


def copy(message: Any) -> Any:
    """Return what a subscriber in the same process gets."""
    return _made(make_copy, type(message))(message)


def decode(cls: Any, buffer: Any, start: int, end: int, *, exact: bool = False) -> Any:
    """Return the message that the bytes from start to end are."""
    return _made(make_decode, cls)(buffer, start, end, exact)


def decode_arrays(cls: Any, buffer: Any, start: int, end: int, view: View, *, exact: bool = False) -> Any:
    """Return the same with arrays of numbers as a view makes them."""
    return _made(make_decode_arrays, cls)(buffer, start, end, view, exact)


def read(cls: Any, buffer: Any, start: int, end: int) -> tuple[Any, int]:
    """Return the message that begins at start, and where it ends."""
    return _made(make_read, cls)(buffer, start, end)


def read_arrays(cls: Any, buffer: Any, start: int, end: int, view: View) -> tuple[Any, int]:
    """Return the same with arrays of numbers as a view makes them."""
    return _made(make_read_arrays, cls)(buffer, start, end, view)
