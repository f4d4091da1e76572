"""local: what nodes of one machine say to each other."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import ProtocolError, SettingError
from pyros1.wire.local import (
    LOCAL_PROTOCOL,
    REFERENCE_SIZE,
    TOKEN_SIZE,
    Reference,
    decode_block,
    decode_reference,
    decode_releases,
    encode_block,
    encode_reference,
    encode_release,
    is_local_enabled,
    is_offered,
    make_offer,
)

TOKEN = bytes(range(TOKEN_SIZE))
U32, U64 = st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1)


@given(U64, U32, U32, U64)
def test_references_come_back(number: int, block: int, offset: int, size: int) -> None:
    reference = Reference(number, block, offset, size, 0, 0)
    frame = encode_reference(TOKEN, reference)
    assert int.from_bytes(frame[:4], "little") == REFERENCE_SIZE == len(frame) - 4
    assert decode_reference(TOKEN, frame[4:]) == reference


@given(st.binary(max_size=2 * REFERENCE_SIZE))
def test_other_frames_are_messages(body: bytes) -> None:
    assert decode_reference(TOKEN, body) is None or body.startswith(TOKEN)


@pytest.mark.parametrize(
    ("size", "begin", "array"), [(10, 3, 1), (10, 4, 7), (10, 11, 0), (3, 4, 0), (2**63, 4, 2**63)]
)
def test_impossible_arrays(size: int, begin: int, array: int) -> None:
    with pytest.raises(ProtocolError, match="not inside"):
        decode_reference(TOKEN, encode_reference(TOKEN, Reference(1, 1, 0, size, begin, array))[4:])


@given(st.binary(max_size=40))
def test_records_about_blocks(record: bytes) -> None:
    try:
        number, size = decode_block(record)
    except ProtocolError:
        assert len(record) != 12
    else:
        assert encode_block(number, size) == record


@given(st.lists(U64), st.binary(max_size=7))
def test_numbers_that_are_given_back(numbers: list[int], more: bytes) -> None:
    assert [*decode_releases(b"".join(map(encode_release, numbers)) + more)] == numbers


def test_only_who_has_the_key_shares() -> None:
    assert is_offered([["TCPROS"], make_offer("key")], "key")
    assert not is_offered([["TCPROS"], make_offer("other")], "key")
    assert not is_offered([["TCPROS"], make_offer("")], "")
    assert not is_offered([["TCPROS"], [LOCAL_PROTOCOL], LOCAL_PROTOCOL, [LOCAL_PROTOCOL, ["key"]], 7], "key")


def test_transports() -> None:
    assert all(map(is_local_enabled, ("local,tcp", "tcp local", "")))
    assert not is_local_enabled("tcp")
    for setting, text in (("shm,tcp", "'shm' is not one of local, tcp"), ("local", "needs tcp")):
        with pytest.raises(SettingError, match=text):
            is_local_enabled(setting)
