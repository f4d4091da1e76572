"""header: connection headers whole, byte by byte, cut anywhere, garbage (T01, T02)."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import ProtocolError
from pyros1.wire.header import HeaderReader, decode_header, encode_header

keys = st.text(st.characters(codec="utf-8", exclude_characters="="), min_size=1).filter(lambda k: k == k.strip())
headers = st.dictionaries(keys, st.text(st.characters(codec="utf-8")), max_size=8)


@pytest.mark.slow
@given(headers)
def test_round_trip(fields: dict[str, str]) -> None:
    data = encode_header(fields)
    assert decode_header(data[4:]) == fields


@pytest.mark.slow
@given(headers, st.binary(max_size=10), st.integers(1, 7))
def test_reader_takes_any_pieces(fields: dict[str, str], rest: bytes, step: int) -> None:
    reader = HeaderReader()
    data = encode_header(fields)
    found = None
    for start in range(0, len(data), step):
        assert found is None
        found = reader.feed(data[start : start + step] + (rest if start + step >= len(data) else b""))
    assert found == fields
    assert reader.bytes_after_header == rest


@given(st.binary(max_size=80))
def test_garbage_gives_a_value_or_protocol_error(data: bytes) -> None:
    try:
        HeaderReader().feed(data)
    except ProtocolError:
        return


def test_t01_values_hold_equals_signs_and_foreign_bytes() -> None:
    field = b"message_definition=# caf\xe9 = x\nfloat64 data"
    body = struct.pack("<I", len(field)) + field
    fields = decode_header(body)
    assert encode_header(fields)[4:] == body


@pytest.mark.parametrize(
    "body",
    [b"\x00\x00\x00\x00", b"\x03\x00\x00\x00abc", b"\xff\x00\x00\x00a=b", b"\x01\x00", b"\x03\x00\x00\x00a=b\x01"],
)
def test_t02_malformed_fields_are_refused(body: bytes) -> None:
    with pytest.raises(ProtocolError, match="connection header"):
        decode_header(body)


def test_length_lie_is_refused_before_anything_is_kept() -> None:
    with pytest.raises(ProtocolError, match="exceeds the limit"):
        HeaderReader().feed(b"\xff\xff\xff\xff")


def test_the_limit_is_the_longest_header() -> None:
    data = encode_header({"a": "1"})
    assert HeaderReader(limit=len(data) - 4).feed(data) == {"a": "1"}
    with pytest.raises(ProtocolError, match=f"header of {len(data) - 4} bytes exceeds the limit of {len(data) - 5}"):
        HeaderReader(limit=len(data) - 5).feed(data)


def test_keys_are_sorted_on_the_wire() -> None:
    assert encode_header({"b": "2", "a": "1"}) == encode_header({"a": "1", "b": "2"})
    assert encode_header({"b": "2", "a": "1"}).index(b"a=1") < encode_header({"b": "2", "a": "1"}).index(b"b=2")
