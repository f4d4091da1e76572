"""Strings that are not UTF-8 in received messages."""

from __future__ import annotations

import struct
import warnings
from typing import Any

import codec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import DeserializationError, LengthError
from pyros1.msgs import from_definition
from pyros1.msgs.array_views import make_numpy_view

SEPARATOR = "\n" + "=" * 80 + "\n"
INNER = f"{SEPARATOR}MSG: p/Inner\nstring name\nuint8[] data\n"
ALL = "int8 n\nstring[2] two\nInner[] inners\nInner one\nfloat64[] numbers\nstring last" + INNER


def make(text: str) -> Any:
    return from_definition("p/Texts", text)


def block(body: bytes) -> bytes:
    return struct.pack("<I", len(body)) + body


def inner(name: bytes) -> bytes:
    return block(name) + block(b"\xff\xfe")


def replaced(body: bytes) -> str:
    return body.decode("utf-8", "replace")


TEXTS = st.binary(max_size=6)


@pytest.mark.slow
@given(TEXTS, TEXTS, st.lists(TEXTS, max_size=3), TEXTS, st.booleans())
def test_texts_become_utf8(first: bytes, second: bytes, names: list[bytes], last: bytes, views: bool) -> None:
    body = b"\7" + block(first) + block(second) + struct.pack("<I", len(names)) + b"".join(map(inner, names))
    body += inner(last) + struct.pack("<Id", 1, 2.5) + block(last)
    cls, data = make(ALL), b"before" + body + b"behind"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnicodeWarning)
        where = (cls, data, 6, 6 + len(body))
        message = codec.decode_arrays(*where, make_numpy_view(np)) if views else codec.decode(*where)
        whole = cls().deserialize(body + b"rest")
    assert (message.n, message.two) == (7, [replaced(first), replaced(second)])
    assert [(each.name, bytes(each.data)) for each in message.inners] == [
        (replaced(name), b"\xff\xfe") for name in names
    ]
    assert (message.one.name, list(message.numbers), message.last) == (replaced(last), [2.5], replaced(last))
    assert views or whole == message


def test_it_is_told() -> None:
    cls, data = make("string s"), block(b"ab\xe4c")
    with pytest.warns(UnicodeWarning, match="p/Texts: bytes in strings that are not UTF-8 are replaced"):
        assert codec.decode(cls, data, 0, len(data)).s == "ab\ufffdc"


def test_programs_that_make_errors_of_warnings_refuse_such_messages() -> None:
    data = b"\1\2\0\0\0a\xff"
    with pytest.raises(DeserializationError, match="field s is not UTF-8") as caught:
        codec.decode(make("int8 a\nstring s"), data, 0, len(data))
    assert caught.value.offset == 6


def test_other_faults_are_still_faults() -> None:
    with pytest.raises(DeserializationError, match="field n"), warnings.catch_warnings():
        warnings.simplefilter("ignore", UnicodeWarning)
        codec.decode(make("string s\nint8 n"), b"\2\0\0\0a\xff", 0, 6)


@pytest.mark.parametrize("behind", [b"", b"\xff\xff\xff", bytes(20)], ids=["end", "text", "zeros"])
@pytest.mark.parametrize("text", ["string t", "Inner i", "Inner[1] i", "uint8[] t", "char[] t"])
def test_the_end_of_the_last_string_may_be_missing(text: str, behind: bytes) -> None:
    """As in stock ROS. ``behind`` are the bytes that follow in the buffer: the next message."""
    nested = f"{SEPARATOR}MSG: p/Inner\nstring t\nEmpty[2] e{SEPARATOR}MSG: p/Empty\n"
    cls = make(f"string first\n{text}{nested}")
    head = block(b"a\xffc")
    for size in range(6):
        data = head + block(b"12345")[: 4 + size]
        for view in (None, make_numpy_view(np)):
            message = decoded(cls, data, behind, view)
            last = message.t if text.endswith("t") else message.i[0].t if "[" in text else message.i.t
            assert message.first == "a\ufffdc"
            assert (last if isinstance(last, str) else bytes(last).decode()) == "12345"[:size]
            if size < 5:
                with pytest.raises(LengthError) as odd:
                    decoded(cls, data, behind, view, exact=True)
                assert odd.value.surplus == size - 5
    for size in range(len(head) + 4):
        with pytest.raises(DeserializationError):
            decoded(cls, (head + block(b"12345"))[:size], behind)


def decoded(cls: Any, data: bytes, behind: bytes, view: Any = None, *, exact: bool = False) -> Any:
    where = (cls, data + behind, 0, len(data))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnicodeWarning)
        if view is None:
            return codec.decode(*where, exact=exact)
        return codec.decode_arrays(*where, view, exact=exact)


@pytest.mark.parametrize("view", [None, make_numpy_view(np)], ids=["bytes", "numpy"])
@pytest.mark.parametrize(
    ("text", "sent", "shown"),
    [
        ("int8 n\nuint8[4] t", "01", [""]),
        ("int8 n\nuint8[4] t", "01020304", ["020304"]),
        ("int8 n\nchar[2] t\nuint8[4] u", "0102", ["02", ""]),
        ("int8 n\nuint8[] t\nuint8[4] u", "0105000000ff", ["ff", ""]),
    ],
)
def test_arrays_of_fixed_length_at_the_end_may_be_shorter(text: str, sent: str, shown: list[str], view: Any) -> None:
    """As in stock ROS: `interop/topics/test_messages.py`."""
    cls, data = make(text), bytes.fromhex(sent)
    message = decoded(cls, data, b"\xff\xff\xff", view)
    assert [bytes(getattr(message, name)).hex() for name in ("t", "u") if name in cls.__slots__] == shown
    with pytest.raises(LengthError):
        decoded(cls, data, b"", view, exact=True)


def test_elements_of_fixed_size_may_lack_bytes_at_the_end() -> None:
    cls = make(f"Inner[2] i{SEPARATOR}MSG: p/Inner\nint8 n\nuint8[2] data\n")
    message = decoded(cls, b"\1ab\2c", b"")
    assert [(each.n, each.data) for each in message.i] == [(1, b"ab"), (2, b"c")]
    with pytest.raises(DeserializationError):
        decoded(cls, b"\1ab", b"")
