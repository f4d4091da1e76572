"""What the robot offers, as viewers see it. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

Table = Mapping[str, list[str]]
"""Names of topics or services, with the names of their nodes."""
ANY = "*"


@dataclass(frozen=True)
class Channel:
    """A topic with a type.

    Attributes:
        id: never reused for another topic, type or definition.
        type: its message type, ``package/Type``.
        schema: the definition of this type and of all types that it uses.
        md5sum: the type's checksum; ``*`` if the publisher gave none.
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
        id: never reused for another name or type.
        type: its type, ``package/Type``.
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
        nodes: the graph.
        problems: the problems of topics and services: text for the user, by an id.
        has_open_questions: whether some definitions are still to be requested.
    """

    channels: Mapping[str, Channel] = field(default_factory=dict)
    services: Mapping[str, Service] = field(default_factory=dict)
    nodes: Nodes = NO_NODES
    problems: Mapping[str, str] = field(default_factory=dict)
    has_open_questions: bool = False
