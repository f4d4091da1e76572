"""Packets as bytes and back; whatever else comes is refused, and costs little."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol import packets
from pyros1.bridge.protocol.packet_values import MAX_BODY, PacketError
from pyros1.bridge.protocol.packets import (
    Definition,
    Head,
    Heartbeat,
    Kind,
    LatchedList,
    MessageHead,
    OfferedTopic,
    Request,
    ResendRefusal,
    ResendRequest,
    Tail,
)

TOPIC = SharedName("red", "/odom")
MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"
HEARTBEAT = Heartbeat(3, 1.5, 2, 0.25, 4, 5, -1, 6, {TOPIC: Tail(7, 5)}, 8, 9, 0.5, ("/talker",))
OFFERED = OfferedTopic(TOPIC, "std_msgs/String", MD5, True, False, ("/driver", "/red/left"))
DECODERS: dict[str, tuple[Callable[[bytes], Any], bytes, Any]] = {
    "heartbeat": (packets.decode_heartbeat, packets.encode_heartbeat(HEARTBEAT), HEARTBEAT),
    "ask": (packets.decode_ask, packets.encode_ask([MD5]), [MD5]),
    "definition": (
        packets.decode_definition,
        packets.encode_definition(Definition("std_msgs/String", MD5, "string data\n")),
        Definition("std_msgs/String", MD5, "string data\n"),
    ),
    "missed": (
        packets.decode_resend_request,
        packets.encode_resend_request(ResendRequest(TOPIC, 1, 5)),
        ResendRequest(TOPIC, 1, 5),
    ),
    "held": (
        packets.decode_latched_list,
        packets.encode_latched_list(LatchedList(TOPIC, 5, {1: 4})),
        LatchedList(TOPIC, 5, {1: 4}),
    ),
    "probe": (packets.decode_probe, packets.encode_probe(7), 7),
    "gone": (
        packets.decode_resend_refusal,
        packets.encode_resend_refusal(ResendRefusal(TOPIC, 5)),
        ResendRefusal(TOPIC, 5),
    ),
    "offer": (packets.decode_offer, next(packets.encode_pages(2, [OFFERED])), (2, 0, 1, [OFFERED])),
    "request": (
        packets.decode_request,
        next(packets.encode_pages(2, [Request(TOPIC, 5.0)])),
        (2, 0, 1, [Request(TOPIC, 5.0)]),
    ),
}


@pytest.mark.parametrize("name", DECODERS)
def test_there_and_back(name: str) -> None:
    decode, body, value = DECODERS[name]
    assert decode(body) == value


@pytest.mark.parametrize("name", DECODERS)
def test_cut_and_changed_bodies(name: str) -> None:
    decode, body, _ = DECODERS[name]
    for length in range(len(body)):
        with pytest.raises(PacketError):
            decode(body[:length])
    for position in range(len(body)):
        for byte in b'0"[]{,-e~\xff':
            changed = body[:position] + bytes([byte]) + body[position + 1 :]
            with suppress(PacketError):
                decode(changed)


JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from(["red:/a", MD5, "a/B"]),
    lambda inner: st.lists(inner, max_size=9) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=30,
)


@pytest.mark.slow
@given(JSON, st.sampled_from([*DECODERS]))
def test_other_json(value: Any, name: str) -> None:
    with suppress(PacketError):
        DECODERS[name][0](json.dumps(value).encode())


@given(st.binary(max_size=60))
def test_other_bytes(data: bytes) -> None:
    for decode in (packets.decode_head, packets.decode_message_head, *(each[0] for each in DECODERS.values())):
        with suppress(PacketError):
            decode(data)


@pytest.mark.parametrize(
    "body",
    [
        b"[" * 100_000,
        b'["' + b"a" * MAX_BODY + b'"]',
        b"[" + b"1" * 100_000 + b"]",
        b"[1e999]",
        b"[NaN]",
        b"{}",
    ],
)
def test_costly_bodies(body: bytes) -> None:
    for decode, _, _ in DECODERS.values():
        with pytest.raises(PacketError):
            decode(body)


def test_long_lists_have_pages() -> None:
    requests = [Request(SharedName("red", f"/t{number}"), 0.0) for number in range(450)]
    pages = [packets.decode_request(body) for body in packets.encode_pages(7, requests)]
    assert [(page.version, page.number, page.page_count) for page in pages] == [(7, 0, 3), (7, 1, 3), (7, 2, 3)]
    assert [request for page in pages for request in page.entries] == requests
    assert [packets.decode_offer(body).entries for body in packets.encode_pages(1, [])] == [[]]
    too_many = requests * 20
    assert len([*packets.encode_pages(1, too_many)]) == packets.MAX_PAGES


@pytest.mark.parametrize("page", [[1, 3, 3, []], [1, 0, 33, []], [1, 0, 0, []], [1, 0, 1, [["red:/a", 0.0]] * 201]])
def test_pages_that_cannot_be(page: list[Any]) -> None:
    with pytest.raises(PacketError):
        packets.decode_request(json.dumps(page).encode())


def test_heads() -> None:
    head = packets.encode_head(Kind.OFFER, 2**64 - 1, 5)
    assert packets.decode_head(head) == Head(Kind.OFFER, 2**64 - 1, 5)
    message = MessageHead(7, 0, 3, 2, 12.5, 1, MD5)
    encoded = packets.encode_message_head(message)
    assert packets.decode_message_head(encoded) == message and len(encoded) < 100
    for data in (head[:-1], head + b"x", b"\x02" + head[1:], bytes([1, 99]) + head[2:], encoded):
        with pytest.raises(PacketError):
            packets.decode_head(data)
    for data in (head, encoded[:-1], b"\x02" + encoded[1:]):
        with pytest.raises(PacketError):
            packets.decode_message_head(data)
    for impossible in (
        message._replace(number=0),
        message._replace(number=2**63),
        message._replace(received_at=float("nan")),
        message._replace(received_at=1e300),
        message._replace(received_at=-1e12),
    ):
        with pytest.raises(PacketError):
            packets.decode_message_head(packets.encode_message_head(impossible))


@pytest.mark.parametrize("field", ["sent_at", "reply_delay", "period"])
@pytest.mark.parametrize("value", [1e11, -1e11, 10**400])
def test_times_out_of_range(field: str, value: float) -> None:
    _, _, heartbeat = DECODERS["heartbeat"]
    with pytest.raises(PacketError):
        packets.decode_heartbeat(packets.encode_heartbeat(heartbeat._replace(**{field: value})))


def test_rates() -> None:
    def decode(rate: Any) -> float:
        entry = packets.decode_request(json.dumps([1, 0, 1, [[str(TOPIC), rate]]]).encode()).entries[0]
        assert isinstance(entry, Request)
        return entry.rate

    assert [decode(rate) for rate in (0, 5, 0.5, 1e6)] == [0.0, 5.0, 0.5, 1e6]
    assert decode(1e-300) >= 1 / 100_000, "one message per day, since a longer time is of no use"
    for rate in (-1.0, 1e7, True, "5"):
        with pytest.raises(PacketError):
            decode(rate)


@pytest.mark.parametrize(
    "publishers", [None, "/a", ["a"], [""], ["/a b"], [1], ["/a\n"], ["/" + "a" * 255], ["/a"] * 9, [["/a"]]]
)
def test_names_of_publishers_that_are_wrong(publishers: Any) -> None:
    def page(names: Any) -> bytes:
        return json.dumps([1, 0, 1, [["red:/odom", "a/B", MD5, True, False, names]]]).encode()

    assert packets.decode_offer(page(["/a", "/b"])).entries[0].publishers == ("/a", "/b")
    with pytest.raises(PacketError):
        packets.decode_offer(page(publishers))


def test_a_page_of_the_longest_offers_is_not_too_large() -> None:
    name = "/" + "n" * 254
    longest = OfferedTopic(SharedName("s" * 40, name), "a" * 127 + "/" + "b" * 127, MD5, False, False, (name,) * 8)
    pages = [*packets.encode_pages(1, [longest] * packets.PAGE_ENTRIES)]
    assert len(pages) == 1 and packets.decode_offer(pages[0]).entries == [longest] * packets.PAGE_ENTRIES
