"""Packets of service calls between sites. No I/O.

A site calls another one through *slots*, each with one call at a time; the numbers of a slot's calls increase. So the
called site needs only each slot's last number to know which calls are new. A packet's body is the request, the
response, or the text of an error.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import NamedTuple

from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.packet_values import MAX_NUMBER, PacketError, read_md5, read_time, read_topic, read_type
from pyros1.bridge.protocol.packets import Kind, Page, decode_page

MAX_SLOTS = 32
"""Maximum number of calls from one site to another in progress at the same time."""
MAX_CALL_SIZE = 16 << 20
"""Maximum size in bytes of a request or a response."""
MAX_TIME = 86_400.0
"""Maximum number of seconds that a call may take."""
_VERSION = 1
_HEAD = struct.Struct("<BBQQHQBdd")
_KINDS = (Kind.CALL, Kind.CALL_SEEN, Kind.REPLY, Kind.REPLY_SEEN)


class Status(IntEnum):
    """The outcome of a call."""

    OK = 0
    """There is a response."""
    FAILED = 1
    """The service has refused or failed; the body says why."""
    REFUSED = 2
    """The service was not called, or has not answered; a bridge says why."""


class CallId(NamedTuple):
    """Identifies a call from another site: the site, its run, and the call."""

    peer: str
    epoch: int
    slot: int
    number: int


class OfferedService(NamedTuple):
    """A service that other sites may call.

    Attributes:
        service: its name between sites.
        type, md5sum, request, response: its type, its md5 sum, and the types of its requests and responses.
    """

    service: SharedName
    type: str
    md5sum: str
    request: str
    response: str


class CallHead(NamedTuple):
    """The head of a packet about a call.

    Attributes:
        kind: CALL or REPLY, or CALL_SEEN or REPLY_SEEN to acknowledge one.
        epoch, to_epoch: the runs of the sender and the receiver.
        slot, number: the call.
        status: how it has ended; only in replies.
        sent_at: when the packet was sent, in seconds of the sender's clock.
        left: how many seconds from then on the caller waits; only in calls.
    """

    kind: Kind
    epoch: int
    to_epoch: int
    slot: int
    number: int
    status: Status = Status.OK
    sent_at: float = 0.0
    left: float = 0.0


def encode_call_head(head: CallHead) -> bytes:
    """Return a head as bytes."""
    return _HEAD.pack(_VERSION, *head)


def decode_call_head(data: bytes) -> CallHead:
    """Return a head.

    Raises:
        PacketError: it is not valid.
    """
    if len(data) != _HEAD.size or data[0] != _VERSION or data[1] not in _KINDS:
        raise PacketError("not the head of a call")
    _, kind, epoch, to_epoch, slot, number, status, sent_at, left = _HEAD.unpack(data)
    if slot >= MAX_SLOTS or not 0 < number < MAX_NUMBER or status > max(Status):
        raise PacketError("a call with impossible numbers")
    if not 0.0 <= left <= MAX_TIME:
        raise PacketError("a call with an impossible time limit")
    return CallHead(Kind(kind), epoch, to_epoch, slot, number, Status(status), read_time(sent_at), left)


def decode_services(body: bytes) -> Page:
    """Return a page of services, whose entries are `OfferedService`."""
    return decode_page(
        body,
        5,
        lambda row: OfferedService(
            read_topic(row[0]), read_type(row[1]), read_md5(row[2]), read_type(row[3]), read_type(row[4])
        ),
    )
