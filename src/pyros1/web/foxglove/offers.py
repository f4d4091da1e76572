"""Describes the topics and services that are offered to viewers (no I/O)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

Table = Mapping[str, list[str]]
"""Name of a topic or service -> the names of its nodes."""
ANY_CHECKSUM = "*"
"""Stands for an unknown checksum; it matches any checksum."""


@dataclass(frozen=True)
class Channel:
    """A topic as offered to viewers, with one definition of its type.

    Attributes:
        id: a number that is never reused for another topic, type or definition.
        type: the message type, ``package/Type``.
        schema: the definitions of the type and of all types that it uses.
        md5sum: the type's checksum; ``*`` if the publisher did not send one.
    """

    id: int
    topic: str
    type: str
    schema: str
    md5sum: str

    def carries(self, header: Mapping[str, str]) -> bool:
        """Return whether a publisher with this connection header sends messages of the channel's type."""
        md5sum = header.get("md5sum", ANY_CHECKSUM)
        return md5sum == self.md5sum or ANY_CHECKSUM in (md5sum, self.md5sum)


@dataclass(frozen=True)
class Service:
    """A service as offered to viewers.

    Attributes:
        id: a number that is never reused for another name or type.
        type: the service type, ``package/Type``.
        request, response: the definitions of the request and the response, each with those of all types that it uses.
    """

    id: int
    name: str
    type: str
    request: str
    response: str


class Nodes(NamedTuple):
    """The nodes that publish topics, subscribe to topics, or provide services."""

    publishers: Table
    subscribers: Table
    services: Table


NO_NODES = Nodes({}, {}, {})


@dataclass(frozen=True)
class Offers:
    """Everything that is offered to viewers.

    Attributes:
        channels: topic -> channel.
        services: name -> service.
        nodes: the nodes of each topic and service.
        problems: id -> description of a problem with a topic or service.
        has_pending_queries: whether some definitions have yet to be requested from nodes.
    """

    channels: Mapping[str, Channel] = field(default_factory=dict)
    services: Mapping[str, Service] = field(default_factory=dict)
    nodes: Nodes = NO_NODES
    problems: Mapping[str, str] = field(default_factory=dict)
    has_pending_queries: bool = False
