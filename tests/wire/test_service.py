"""service: framing of responses (T26)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import ProtocolError
from pyros1.wire import service


def test_t26_success_has_the_ok_byte_before_the_length() -> None:
    assert service.encode_success(b"\x02\x00\x00\x00ab") == b"\x01\x02\x00\x00\x00ab"


@given(st.text(st.characters(codec="utf-8")))
def test_failure_carries_its_reason(reason: str) -> None:
    data = service.encode_failure(reason)
    ok, size = service.decode_response_head(data[: service.RESPONSE_HEAD_SIZE])
    assert not ok
    assert data[service.RESPONSE_HEAD_SIZE :].decode() == reason
    assert size == len(data) - service.RESPONSE_HEAD_SIZE


@given(st.binary(min_size=5, max_size=5))
def test_any_head_gives_a_value_or_protocol_error(head: bytes) -> None:
    try:
        _, size = service.decode_response_head(head, limit=1000)
    except ProtocolError:
        return
    assert size <= 1000


def test_oversized_response_is_refused() -> None:
    with pytest.raises(ProtocolError, match="exceeds the limit"):
        service.decode_response_head(b"\x01\xff\xff\xff\xff")
