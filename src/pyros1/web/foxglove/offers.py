"""The topics and services that are offered to viewers (pure)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

Table = Mapping[str, list[str]]
"""Name of a topic or service -> the names of its nodes."""
ANY = "*"
"""Stands for a checksum that is not known; it matches every other one."""


@dataclass(frozen=True)
class Channel:
    """A topic with a type.

    Attributes:
        id: a number that is never reused for another topic, type or definition.
        type: the message type, ``package/Type``.
        schema: the definition of this type and of all types that it uses.
        md5sum: the type's checksum; ``*`` if the publisher did not send one.
    """

    id: int
    topic: str
    type: str
    schema: str
    md5sum: str

    def carries(self, header: Mapping[str, str]) -> bool:
        """Return whether messages with a connection header are of this channel's type."""
        md5sum = header.get("md5sum", ANY)
        return md5sum == self.md5sum or ANY in (md5sum, self.md5sum)


@dataclass(frozen=True)
class Service:
    """A service.

    Attributes:
        id: a number that is never reused for another name or type.
        type: the service type, ``package/Type``.
        request, response: the definitions of both messages and of all types that they use.
    """

    id: int
    name: str
    type: str
    request: str
    response: str


class Nodes(NamedTuple):
    """The publishers and subscribers of topics, and the providers of services."""

    publishers: Table
    subscribers: Table
    services: Table


NO_NODES = Nodes({}, {}, {})


@dataclass(frozen=True)
class Offers:
    """The channels and services on offer.

    Attributes:
        channels: by topic.
        services: by name.
        nodes: the nodes of each topic and service.
        problems: descriptions of the problems of topics and services, by id.
        has_pending_queries: whether definitions are still to be requested from nodes.
    """

    channels: Mapping[str, Channel] = field(default_factory=dict)
    services: Mapping[str, Service] = field(default_factory=dict)
    nodes: Nodes = NO_NODES
    problems: Mapping[str, str] = field(default_factory=dict)
    has_pending_queries: bool = False
