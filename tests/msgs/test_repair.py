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

from pyros1.ground.errors import DeserializationError
from pyros1.msgs import from_definition
from pyros1.msgs.array_views import numpy_view

INNER = "\n" + "=" * 80 + "\nMSG: p/Inner\nstring name\nuint8[] data\n"
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


@given(TEXTS, TEXTS, st.lists(TEXTS, max_size=3), TEXTS, st.booleans())
def test_texts_become_utf8(first: bytes, second: bytes, names: list[bytes], last: bytes, views: bool) -> None:
    body = b"\7" + block(first) + block(second) + struct.pack("<I", len(names)) + b"".join(map(inner, names))
    body += inner(last) + struct.pack("<Id", 1, 2.5) + block(last)
    cls, data = make(ALL), b"before" + body + b"behind"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnicodeWarning)
        where = (cls, data, 6, 6 + len(body))
        message = codec.decode_arrays(*where, numpy_view(np)) if views else codec.decode(*where)
        whole = cls().deserialize(body + b"rest")
    assert (message.n, message.two) == (7, [replaced(first), replaced(second)])
    assert [(each.name, bytes(each.data)) for each in message.inners] == [
        (replaced(name), b"\xff\xfe") for name in names
    ]
    assert (message.one.name, list(message.numbers), message.last) == (replaced(last), [2.5], replaced(last))
    assert views or whole == message


def test_it_is_told() -> None:
    cls, data = make("string s"), block(b"ab\xe4c")
    with pytest.warns(UnicodeWarning, match="p/Texts: bytes in texts that are not UTF-8 are replaced"):
        assert codec.decode(cls, data, 0, len(data)).s == "ab\ufffdc"


def test_programs_that_make_errors_of_warnings_refuse_such_messages() -> None:
    data = b"\1\2\0\0\0a\xff"
    with pytest.raises(DeserializationError, match="field s is not UTF-8") as caught:
        codec.decode(make("int8 a\nstring s"), data, 0, len(data))
    assert caught.value.offset == 6


@pytest.mark.parametrize("data", [b"\3\0\0\0a\xff", b"\2\0\0\0a\xff_"], ids=["short", "long"])
def test_other_faults_are_still_faults(data: bytes) -> None:
    with pytest.raises(DeserializationError, match=r"needs 3 bytes|left over"), warnings.catch_warnings():
        warnings.simplefilter("ignore", UnicodeWarning)
        codec.decode(make("string s"), data, 0, len(data))


def test_the_end_of_the_last_string_may_be_missing_in_programs_with_genpy(monkeypatch: pytest.MonkeyPatch) -> None:
    cls = make("string first\nuint8[] last")
    data = block(b"abc") + block(b"12345")
    with pytest.raises(DeserializationError, match="field last"):
        cls().deserialize(data[:-2])

    monkeypatch.setattr("pyros1.msgs.repair.HANDLER", "strict")  # a handler that any program has
    assert bytes(cls().deserialize(data[:-2]).last) == b"123"
    for size in range(len(block(b"abc")) + 4):
        with pytest.raises(DeserializationError):
            cls().deserialize(data[:size])
    with pytest.raises(DeserializationError):
        codec.decode(cls, data[:-2], 0, len(data) - 2)
