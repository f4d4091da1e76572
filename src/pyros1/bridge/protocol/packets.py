"""Packets between sites, as bytes. Data from other sites is untrusted until it has been checked here.

A packet has a *head* and a *body*. All heads begin with the version, the kind, the sender's epoch, and the receiver's
epoch as the sender knows it (0 for all receivers). An epoch is a random number that a site chooses when it starts, so
packets from or for an earlier run are recognised. A message's head continues with its numbers (`MessageHead`), and its
body is the message as serialized in ROS. The bodies of other packets are JSON.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from enum import IntEnum
from typing import Any, NamedTuple

from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.packet_values import (
    MAX_NUMBER,
    PacketError,
    dump,
    load,
    read_bools,
    read_integer,
    read_md5,
    read_nodes,
    read_rate,
    read_rows,
    read_time,
    read_topic,
    read_type,
)

_VERSION = 1
MAX_DEFINITION = 256 << 10
"""Maximum number of characters of a definition."""
PAGE_ENTRIES = 200
"""Number of entries in a page of a list."""
MAX_PAGES = 32
"""Maximum number of pages of a list."""
MAX_NODES = 100
"""Maximum number of nodes in a heartbeat."""
MAX_NUMBERS = 1000
"""Maximum number of items in lists that are not divided into pages."""

MAX_PUBLISHERS = 8
"""Maximum number of publishers of a topic whose names are sent."""

_HEAD = struct.Struct("<BBQQ")
_MESSAGE = struct.Struct("<BBQQQIdB16s")


class Kind(IntEnum):
    """The kinds of packets."""

    HELLO = 1
    BYE = 2
    HEARTBEAT = 3
    OFFER = 4
    REQUEST = 5
    ASK = 6
    DEFINITION = 7
    RESEND_REQUEST = 8
    LATCHED_LIST = 9
    RESEND_REFUSAL = 10
    PROBE = 11
    PROBE_REPLY = 12
    MESSAGE = 16
    SERVICES = 32
    CALL = 33
    CALL_SEEN = 34
    REPLY = 35
    REPLY_SEEN = 36


class Flag:
    """Bits of `MessageHead.flags`."""

    LATCHED = 1
    """The publisher latches the message."""
    LEFT = 2
    """There is no message: the publisher, which had latched one, is gone."""


class Head(NamedTuple):
    """The beginning of every packet."""

    kind: Kind
    epoch: int
    to_epoch: int


class MessageHead(NamedTuple):
    """The head of a message.

    Attributes:
        epoch, to_epoch: the epochs of the sender and the receiver; see the module's description.
        number: position of the message in its topic, from 1 without gaps.
        publisher: the original publisher's number in this topic.
        received_at: when the sending site received the message, in seconds of its clock.
        flags: see `Flag`.
        md5sum: md5 sum of the message type.
    """

    epoch: int
    to_epoch: int
    number: int
    publisher: int
    received_at: float
    flags: int
    md5sum: str


class Tail(NamedTuple):
    """Where a lossless topic ends for a site that wants it, so that the site notices what it missed.

    Attributes:
        last: the number of the last message.
        before: the number of the last message before the site's request. It tells the site with which message the topic
            begins for it, even if that one is lost, or is overtaken by the heartbeat.
    """

    last: int
    before: int


class Heartbeat(NamedTuple):
    """A packet that tells another site that this one is alive, and which lists of the other site this one has.

    Attributes:
        number: its number; increases with each heartbeat.
        sent_at: when it was sent, in seconds of the sender's clock.
        echo: the number of the last heartbeat received from the peer; 0 for none.
        reply_delay: seconds between the arrival of that heartbeat and this one.
        offer, request: the versions of the sender's lists for the peer.
        offer_seen, request_seen: the versions of the peer's lists that the sender has; -1 for none.
        tails: the end of each lossless topic that the peer wants.
        services, services_seen: the same as `offer` and `offer_seen` for the lists of services.
        period: the number of seconds that the sender wants between heartbeats.
        nodes: the names of responding nodes that publish topics the peer wants.
        is_separate: whether the peer gets all messages in its own packets, and need not listen to those for all sites.
    """

    number: int
    sent_at: float
    echo: int
    reply_delay: float
    offer: int
    request: int
    offer_seen: int
    request_seen: int
    tails: Mapping[SharedName, Tail]
    services: int = 0
    services_seen: int = -1
    period: float = 1.0
    nodes: Sequence[str] = ()
    is_separate: bool = False


class OfferedTopic(NamedTuple):
    """A topic that a site offers to another one.

    Attributes:
        topic: its name between sites.
        type, md5sum: its message type.
        latched: whether it has latched messages.
        reliable: whether missed messages are resent.
        publishers: the nodes that publish it, at most `MAX_PUBLISHERS` of them.
    """

    topic: SharedName
    type: str
    md5sum: str
    latched: bool
    reliable: bool
    publishers: tuple[str, ...] = ()


class Request(NamedTuple):
    """A topic that a site wants from another one, and the maximum messages per second; 0 for all."""

    topic: SharedName
    rate: float


class Page(NamedTuple):
    """Part of a list of offers, requests or services."""

    version: int
    number: int
    page_count: int
    entries: Sequence[Any]


class Definition(NamedTuple):
    """The definition of a message type."""

    type: str
    md5sum: str
    text: str


class ResendRequest(NamedTuple):
    """A request for a topic's messages with the numbers `first` to `last`, or for all that a latched topic holds."""

    topic: SharedName
    first: int
    last: int


class LatchedList(NamedTuple):
    """The latched messages of a topic as of message `number`: the number of each publisher's latched message."""

    topic: SharedName
    number: int
    messages: Mapping[int, int]


class ResendRefusal(NamedTuple):
    """A notice that messages before `first` can no longer be resent."""

    topic: SharedName
    first: int


# Heads ----------------------------------------------------------------------------------------------------------------


def encode_head(kind: Kind, epoch: int, to_epoch: int = 0) -> bytes:
    """Return the head of a packet that is not a message."""
    return _HEAD.pack(_VERSION, kind, epoch, to_epoch)


def encode_message_head(head: MessageHead) -> bytes:
    """Return the head of a message as bytes."""
    epoch, to_epoch, number, publisher, received_at, flags, md5sum = head
    md5 = bytes.fromhex(md5sum)
    return _MESSAGE.pack(_VERSION, Kind.MESSAGE, epoch, to_epoch, number, publisher, received_at, flags, md5)


def decode_head(data: bytes) -> Head:
    """Return the head of a packet that is not a message.

    Raises:
        PacketError: it is not one.
    """
    if data[:1] and data[0] != _VERSION:
        raise PacketError("a packet of another version of pyros1")
    if len(data) != _HEAD.size:
        raise PacketError("not a packet's head")
    _, kind, epoch, to_epoch = _HEAD.unpack(data)
    try:
        return Head(Kind(kind), epoch, to_epoch)
    except ValueError:
        raise PacketError(f"unknown kind of packet: {kind}") from None


def decode_message_head(data: bytes) -> MessageHead:
    """Return the head of a message.

    Raises:
        PacketError: it is not one.
    """
    if len(data) != _MESSAGE.size or data[0] != _VERSION or data[1] != Kind.MESSAGE:
        raise PacketError("not a message's head")
    _, _, epoch, to_epoch, number, publisher, received_at, flags, md5 = _MESSAGE.unpack(data)
    if not 0 < number < MAX_NUMBER:
        raise PacketError("a message with impossible numbers")
    return MessageHead(epoch, to_epoch, number, publisher, read_time(received_at), flags, md5.hex())


# Bodies ---------------------------------------------------------------------------------------------------------------


def encode_heartbeat(heartbeat: Heartbeat) -> bytes:
    """Return the body of a heartbeat."""
    tails = [[str(topic), *tail] for topic, tail in heartbeat.tails.items()]
    return dump([*heartbeat[:8], tails, *heartbeat[9:12], [*heartbeat.nodes], heartbeat.is_separate])


def encode_pages(version: int, entries: Sequence[tuple[Any, ...]]) -> Iterator[bytes]:
    """Yield the bodies of the pages of a list; entries beyond the maximum are left out."""
    rows = [[str(entry[0]), *entry[1:]] for entry in entries[: PAGE_ENTRIES * MAX_PAGES]]
    count = max(1, -(-len(rows) // PAGE_ENTRIES))
    for number in range(count):
        yield dump([version, number, count, rows[number * PAGE_ENTRIES : (number + 1) * PAGE_ENTRIES]])


def encode_ask(md5sums: Iterable[str]) -> bytes:
    """Return the body of a request for definitions."""
    return dump([*md5sums])


def encode_definition(definition: Definition) -> bytes:
    """Return the body of a packet with a definition."""
    return dump([*definition])


def encode_resend_request(missed: ResendRequest) -> bytes:
    """Return the body of a request to resend messages."""
    return dump([str(missed.topic), missed.first, missed.last])


def encode_latched_list(latched_list: LatchedList) -> bytes:
    """Return the body of a list of latched messages."""
    return dump([str(latched_list.topic), latched_list.number, [[*item] for item in latched_list.messages.items()]])


def encode_resend_refusal(gone: ResendRefusal) -> bytes:
    """Return the body of a notice that messages cannot be resent."""
    return dump([str(gone.topic), gone.first])


def encode_probe(number: int) -> bytes:
    """Return the body of a probe or its answer."""
    return dump([number])


def decode_probe(body: bytes) -> int:
    """Return the number of a probe; raises PacketError like the following functions."""
    return read_integer(load(body, 1)[0])


def decode_heartbeat(body: bytes) -> Heartbeat:
    """Return a heartbeat; this and the following functions raise PacketError if the body is not valid."""
    number, sent_at, echo, reply_delay, offer, request, offer_seen, request_seen, *more = load(body, 14)
    tails, services, services_seen, period, nodes, is_separate = more
    read_bools([is_separate])
    return Heartbeat(
        read_integer(number, 1),
        read_time(sent_at),
        read_integer(echo),
        read_time(reply_delay),
        read_integer(offer),
        read_integer(request),
        read_integer(offer_seen, -1),
        read_integer(request_seen, -1),
        {
            read_topic(name): Tail(read_integer(last), read_integer(before))
            for name, last, before in read_rows(tails, 3, PAGE_ENTRIES * MAX_PAGES)
        },
        read_integer(services),
        read_integer(services_seen, -1),
        read_time(period),
        read_nodes(nodes, MAX_NODES),
        is_separate,
    )


def decode_offer(body: bytes) -> Page:
    """Return a page of offers, whose entries are `OfferedTopic`."""
    return decode_page(body, 6, _decode_offered)


def _decode_offered(row: list[Any]) -> OfferedTopic:
    topic, type_name, md5sum, latched, reliable, publishers = row
    read_bools([latched, reliable])
    nodes = read_nodes(publishers, MAX_PUBLISHERS)
    return OfferedTopic(read_topic(topic), read_type(type_name), read_md5(md5sum), latched, reliable, nodes)


def decode_request(body: bytes) -> Page:
    """Return a page of requests, whose entries are `Request`."""
    return decode_page(body, 2, lambda row: Request(read_topic(row[0]), read_rate(row[1])))


def decode_ask(body: bytes) -> list[str]:
    """Return the md5 sums of the definitions that a site asks for."""
    values = load(body, None)
    if len(values) > MAX_NUMBERS:
        raise PacketError("too many definitions at once")
    return [*map(read_md5, values)]


def decode_definition(body: bytes) -> Definition:
    """Return a definition, whose md5 sum still has to be checked."""
    type_name, md5sum, text = load(body, 3)
    if not isinstance(text, str) or len(text) > MAX_DEFINITION:
        raise PacketError("not the text of a definition, or too long")
    return Definition(read_type(type_name), read_md5(md5sum), text)


def decode_resend_request(body: bytes) -> ResendRequest:
    """Return a request to resend messages."""
    name, first, last = load(body, 3)
    return ResendRequest(read_topic(name), read_integer(first), read_integer(last))


def decode_latched_list(body: bytes) -> LatchedList:
    """Return a list of latched messages."""
    name, number, rows = load(body, 3)
    messages = {read_integer(publisher): read_integer(each) for publisher, each in read_rows(rows, 2, MAX_NUMBERS)}
    return LatchedList(read_topic(name), read_integer(number), messages)


def decode_resend_refusal(body: bytes) -> ResendRefusal:
    """Return a notice that messages cannot be resent."""
    name, first = load(body, 2)
    return ResendRefusal(read_topic(name), read_integer(first))


def decode_page(body: bytes, width: int, make: Callable[[list[Any]], Any]) -> Page:
    """Return a page of a list.

    Args:
        body: the packet's body.
        width: number of values of each entry.
        make: makes an entry from these values.

    Raises:
        PacketError: the body is not valid.
    """
    version, number, count, rows = load(body, 4)
    page = Page(
        read_integer(version),
        read_integer(number),
        read_integer(count, 1),
        [make(row) for row in read_rows(rows, width, PAGE_ENTRIES)],
    )
    if page.page_count > MAX_PAGES or page.number >= page.page_count:
        raise PacketError("a page of a list that is too long")
    return page
