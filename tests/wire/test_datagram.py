"""wire.datagram: frames through datagrams that are lost, doubled, mixed up, or nonsense (T60, T61)."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import ProtocolError
from pyros1.wire import datagram
from pyros1.wire.datagram import (
    MAX_DATAGRAM_SIZE,
    MIN_DATAGRAM_SIZE,
    Assembler,
    parse_udpros_offer,
    parse_udpros_response,
    split_frame,
)
from pyros1.wire.header import encode_header


def frame(body: bytes) -> bytes:
    return struct.pack("<I", len(body)) + body


def assembled(datagrams: list[bytes], connection: int = 7) -> tuple[list[bytes], int]:
    assembler = Assembler(connection)
    bodies = [body for body in map(assembler.feed, datagrams) if body is not None]
    return bodies, assembler.lost


@given(st.lists(st.binary(max_size=5000), max_size=5), st.integers(MIN_DATAGRAM_SIZE, 2000))
def test_t60_what_is_split_comes_together(bodies: list[bytes], size: int) -> None:
    sent = [data for number, body in enumerate(bodies, 250) for data in split_frame(frame(body), 7, number, size)]
    assert all(len(data) <= size for data in sent)
    assert assembled(sent) == (bodies, 0)


def test_t60_the_heads() -> None:
    datagrams = list(split_frame(frame(bytes(150)), 0x01020304, 257, 64 + 8))
    assert [data[:8].hex() for data in datagrams] == ["0403020100010300", "0403020101010100", "0403020101010200"]


@given(st.integers(0, 20), st.integers(1, 3000), st.integers(0, 1 << 30))
def test_t61_a_lost_or_doubled_datagram_costs_its_message_only(at: int, length: int, seed: int) -> None:
    bodies = [bytes([number]) * length for number in range(3)]
    parts = [list(split_frame(frame(body), 7, number, 300)) for number, body in enumerate(bodies)]
    at %= len(parts[1])
    lost = [*parts[0], *parts[1][:at], *parts[1][at + 1 :], *parts[2]]
    assert assembled(lost)[0] == [bodies[0], bodies[2]]
    swapped = parts[1][:]
    other = seed % len(swapped)
    swapped[at], swapped[other] = swapped[other], swapped[at]
    found, _ = assembled([*parts[0], *swapped, *parts[2]])
    assert found == (bodies if at == other else [bodies[0], bodies[2]])


def test_what_is_lost_is_counted() -> None:
    first, second = (list(split_frame(frame(bytes(500)), 7, number, 300)) for number in range(2))
    assert assembled([first[0], *second]) == ([bytes(500)], 1)
    assert assembled([*first[1:], *second]) == ([bytes(500)], 0), "nothing was begun"


@given(st.lists(st.binary(max_size=40), max_size=20))
def test_nonsense_is_no_message(datagrams: list[bytes]) -> None:
    bodies, _ = assembled(datagrams, connection=0)
    for body in bodies:
        assert any(data.endswith(frame(body)) or body.endswith(data[8:]) for data in datagrams)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        bytes(7),
        struct.pack("<IBBH", 8, 0, 0, 1) + frame(b"other connection"),
        struct.pack("<IBBH", 7, 2, 0, 1) + frame(b"ping"),
        struct.pack("<IBBH", 7, 3, 0, 1) + frame(b"error"),
        struct.pack("<IBBH", 7, 0, 0, 0) + frame(b"no blocks"),
        struct.pack("<IBBH", 7, 0, 0, 1) + b"abc",
        struct.pack("<IBBH", 7, 0, 0, 1) + struct.pack("<I", 9) + b"lies",
        struct.pack("<IBBH", 7, 1, 0, 0) + frame(b"does not begin"),
    ],
)
def test_what_is_no_message_is_ignored_and_costs_no_other(data: bytes) -> None:
    good = list(split_frame(frame(b"good"), 7, 1, 300))
    assert assembled([data, *good])[0] == [b"good"]


def test_messages_that_are_too_large_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="too large for datagrams of 64"):
        list(split_frame(bytes(datagram.MAX_BLOCKS * 56 + 1), 7, 0, 64))
    monkeypatch.setattr(datagram, "MAX_ASSEMBLED_SIZE", 1000)
    assert assembled(list(split_frame(frame(bytes(2000)), 7, 0, 300))) == ([], 0)
    # Ten datagrams, of which the last one is shorter; the length of the first counts for all.
    whole = list(split_frame(frame(bytes(9 * 92)), 7, 0, 100))
    for limit, found in ((1000, [bytes(9 * 92)]), (999, [])):
        monkeypatch.setattr(datagram, "MAX_ASSEMBLED_SIZE", limit)
        assert assembled(whole)[0] == found


def test_limits() -> None:
    assert (MIN_DATAGRAM_SIZE, MAX_DATAGRAM_SIZE, datagram.MAX_BLOCKS, datagram.MAX_ASSEMBLED_SIZE) == (
        64,
        65507,
        65535,
        1 << 30,
    )


HEADER = encode_header({"topic": "/t"})[4:]


@pytest.mark.parametrize(
    ("offered", "size"),
    [
        (1500, 1500),
        (MIN_DATAGRAM_SIZE, MIN_DATAGRAM_SIZE),
        (63, MIN_DATAGRAM_SIZE),
        (-1, MIN_DATAGRAM_SIZE),
        (1 << 20, MAX_DATAGRAM_SIZE),
    ],
)
def test_the_offer_of_a_subscriber(offered: int, size: int) -> None:
    assert parse_udpros_offer(["UDPROS", HEADER, "robot", 4000, offered]) == ({"topic": "/t"}, ("robot", 4000), size)
    assert parse_udpros_offer(["UDPROS", HEADER, "robot", 65535, offered, "more"]) is not None


def test_the_answer_of_a_publisher_t59() -> None:
    expected = ({"topic": "/t"}, ("robot", 4000), 7)
    assert parse_udpros_response(["UDPROS", "robot", 4000, 7, 1500, HEADER]) == expected
    assert parse_udpros_response(["UDPROS", "robot", 4000, 7 - (1 << 32), 1500, HEADER, "more"]) == expected


@pytest.mark.parametrize(
    "value",
    [[], ["TCPROS", "robot", 4000], *(["UDPROS", HEADER, "robot", port, 64] for port in (0, 65536, "4000"))],
)
def test_other_values_are_neither_offer_nor_answer(value: list[object]) -> None:
    assert parse_udpros_offer(value) is None and parse_udpros_response(value) is None


def test_a_broken_header_is_an_error() -> None:
    with pytest.raises(ProtocolError):
        parse_udpros_offer(["UDPROS", b"abc", "robot", 4000, 64])
    with pytest.raises(ProtocolError):
        parse_udpros_response(["UDPROS", "robot", 4000, 7, 1500, b"abc"])
