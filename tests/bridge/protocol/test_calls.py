"""Packets of service calls as bytes and back, and lists of services; whatever else comes is refused."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.calls import (
    MAX_SLOTS,
    MAX_TIME,
    CallHead,
    OfferedService,
    Status,
    decode_call_head,
    decode_services,
    encode_call_head,
)
from pyros1.bridge.protocol.packet_values import PacketError
from pyros1.bridge.protocol.packets import Kind, encode_pages

HEAD = CallHead(Kind.REPLY, 11, 22, 3, 4, Status.FAILED, 5.5, 60.0)
SERVICE = OfferedService(SharedName("red", "/add"), "a/B", "a" * 32, "a/BRequest", "a/BResponse")


def test_there_and_back() -> None:
    assert decode_call_head(encode_call_head(HEAD)) == HEAD
    (page,) = encode_pages(2, [SERVICE])
    assert decode_services(page) == (2, 0, 1, [SERVICE])


@pytest.mark.parametrize(
    "changes",
    [
        {"slot": MAX_SLOTS},
        {"number": 0},
        {"number": 1 << 63},
        {"status": 3},
        {"left": MAX_TIME + 1},
        {"left": -1.0},
        {"left": float("nan")},
        {"sent_at": float("inf")},
        {"sent_at": 1e300},
        {"sent_at": -1e12},
        {"kind": Kind.BYE},
    ],
)
def test_heads_that_are_refused(changes: dict[str, Any]) -> None:
    with pytest.raises(PacketError):
        decode_call_head(encode_call_head(HEAD._replace(**changes)))


@pytest.mark.slow
@given(st.binary(max_size=60))
def test_random_heads(data: bytes) -> None:
    with pytest.raises(PacketError):
        decode_call_head(data)


def test_another_version() -> None:
    data = encode_call_head(HEAD)
    with pytest.raises(PacketError):
        decode_call_head(b"\x02" + data[1:])
    assert len(data) == struct.calcsize("<BBQQHQBdd")


@pytest.mark.parametrize("position", range(5))
def test_lists_with_values_that_are_wrong(position: int) -> None:
    values: list[Any] = [*SERVICE]
    values[position] = "?"
    (page,) = encode_pages(1, [tuple(values)])
    with pytest.raises(PacketError):
        decode_services(page)
