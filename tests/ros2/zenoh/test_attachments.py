"""Attachments, as others write them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import SerializationError
from pyros1.ros2.zenoh.attachments import Attachment, decode_attachment, encode_attachment

# Of a message and of a request of zenoh-ros2-sdk 0.1.8.
ATTACHMENTS = {
    "010000000000000000ded67d46acec1810366667a5f1954acabdbfbf377f6a0799": Attachment(
        1, 1795999770172907008, bytes.fromhex("366667a5f1954acabdbfbf377f6a0799")
    ),
    "0100000000000000000a622047acec1810ae29f3d1d85b4fb4be54b93985b8fd27": Attachment(
        1, 1795999772899936768, bytes.fromhex("ae29f3d1d85b4fb4be54b93985b8fd27")
    ),
}
GID = bytes(range(16))
# What zenoh.ext.z_serialize makes of the keys and values: each text and the GID after its length.
KEYED = b"\x0fsequence_number\5\0\0\0\0\0\0\0\x10source_timestamp\xe8\3\0\0\0\0\0\0\nsource_gid\x10" + GID
NUMBERS = st.integers(-(1 << 63), (1 << 63) - 1)
ANY = st.builds(Attachment, NUMBERS, NUMBERS, st.binary(min_size=16, max_size=16))


@pytest.mark.parametrize("text", ATTACHMENTS)
def test_attachments(text: str) -> None:
    assert decode_attachment(bytes.fromhex(text)) == ATTACHMENTS[text]
    assert encode_attachment(ATTACHMENTS[text]).hex() == text


def test_the_form_of_old_versions() -> None:
    assert decode_attachment(KEYED) == Attachment(5, 1000, GID)


@pytest.mark.parametrize("key", [b"\x0fs", b"\x10s", b"\ns", b"gid\x10"])
def test_other_keys(key: bytes) -> None:
    assert KEYED.count(key) == 1
    assert decode_attachment(KEYED.replace(key, b"x" * len(key))) is None


@pytest.mark.parametrize("data", [KEYED, encode_attachment(Attachment(1, 2, GID))])
def test_other_lengths(data: bytes) -> None:
    for length in range(len(data)):
        assert decode_attachment(data[:length]) is None
    assert decode_attachment(data + b"\0") is None


def test_another_length_of_the_gid() -> None:
    assert decode_attachment(bytes(16) + b"\x0f" + GID) is None


@pytest.mark.parametrize(
    "attachment",
    [
        Attachment(1 << 63, 0, GID),
        Attachment(-(1 << 63) - 1, 0, GID),
        Attachment(0, 1 << 63, GID),
        Attachment(0, -(1 << 63) - 1, GID),
        Attachment(0, 0, GID[1:]),
        Attachment(0, 0, GID + b"\0"),
    ],
)
def test_what_cannot_be_written(attachment: Attachment) -> None:
    with pytest.raises(SerializationError):
        encode_attachment(attachment)


@given(ANY)
def test_there_and_back(attachment: Attachment) -> None:
    assert decode_attachment(encode_attachment(attachment)) == attachment


@given(st.binary(max_size=100) | st.binary(min_size=33, max_size=33) | st.binary(min_size=77, max_size=77))
def test_any_bytes(data: bytes) -> None:
    attachment = decode_attachment(data)
    assert attachment is None or len(data) == 77 or encode_attachment(attachment) == data
