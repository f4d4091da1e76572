"""The ROS 2 graph: the nodes, topics and services announced by liveliness tokens. No I/O, no locks."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from pyros1.ros2.zenoh.tokens import Entity, Kind, parse_token

MAX_ENTITIES = 20_000
"""Maximum number of tokens that are kept."""
MAX_SESSION_ENTITIES = 10_000
"""Maximum number of tokens kept per zenoh session, so that one process cannot take all the room. A ROS 2 process with
100 nodes has about 2,000.
"""
MAX_WAITING = 50_000


class HashedType(NamedTuple):
    """The name of a type, and its hash."""

    name: str
    hash: str


class Topic(NamedTuple):
    """The publishers and subscribers of a topic."""

    publishers: tuple[Entity, ...] = ()
    subscribers: tuple[Entity, ...] = ()

    @property
    def types(self) -> tuple[HashedType, ...]:
        """The topic's types, sorted. If there are several, some publishers and subscribers do not match."""
        return _types_of((*self.publishers, *self.subscribers))


class Service(NamedTuple):
    """The servers and clients of a service."""

    servers: tuple[Entity, ...] = ()
    clients: tuple[Entity, ...] = ()

    @property
    def types(self) -> tuple[HashedType, ...]:
        """The service's types, sorted. If there are several, some clients cannot call it."""
        return _types_of((*self.servers, *self.clients))


class Changes(NamedTuple):
    """The changes of the graph since the last check.

    Attributes:
        topics, services: names of the topics and services for which an entity came or went.
        nodes: whether a node came or went.
        everything: whether there were too many changes to remember: look at all topics, services and nodes.
    """

    topics: frozenset[str] = frozenset()
    services: frozenset[str] = frozenset()
    nodes: bool = False
    everything: bool = False


class Ros2Graph:
    """Builds the graph of one domain from its tokens; the owner passes on each token that appears or disappears.

    Args:
        domain: ROS domain; tokens of other domains are ignored.
        own_zid: identifier of this zenoh session, whose tokens are ignored.
        max_entities: maximum number of tokens that are kept.
        max_session_entities: maximum number of tokens of one session that are kept.

    Attributes:
        refused: number of tokens so far for which there was no room. They wait for room, since zenoh does not repeat
            them; if too many wait, further ones are lost.
    """

    def __init__(
        self,
        domain: int,
        own_zid: str,
        max_entities: int = MAX_ENTITIES,
        max_session_entities: int = MAX_SESSION_ENTITIES,
    ) -> None:
        self.refused = 0
        self._domain = domain
        self._own_zid = own_zid
        self._max_entities = max_entities
        self._max_session_entities = max_session_entities
        self._entities: dict[str, Entity] = {}
        self._sizes: dict[str, int] = {}  # zid -> number of admitted tokens
        self._waiting: dict[str, dict[str, Entity]] = {}  # those for which there was no room, by zid, then by token
        self._num_waiting = 0
        self._nodes: dict[str, Entity] = {}
        self._topics: dict[str, dict[str, Entity]] = {}  # by name, then by token
        self._services: dict[str, dict[str, Entity]] = {}
        self._changed_topics: set[str] = set()
        self._changed_services: set[str] = set()
        self._nodes_changed = False
        self._everything_changed = False

    def add(self, token: str) -> bool:
        """Add a token.

        Returns:
            Whether this changed anything: not if the token is already known, invalid, from another domain or from this
            session, or if there is no room for it.
        """
        if token in self._entities:
            return False
        entity = parse_token(token)
        if entity is None or entity.domain != self._domain or entity.zid == self._own_zid:
            return False
        if not self._has_room(entity.zid):
            self._defer(token, entity)
            return False
        self._insert(token, entity)
        return True

    def _has_room(self, zid: str) -> bool:
        return len(self._entities) < self._max_entities and self._sizes.get(zid, 0) < self._max_session_entities

    def _defer(self, token: str, entity: Entity) -> None:
        waiting = self._waiting.setdefault(entity.zid, {})
        if token not in waiting:
            self.refused += 1
            if self._num_waiting < MAX_WAITING:
                waiting[token] = entity
                self._num_waiting += 1
        if not waiting:
            del self._waiting[entity.zid]

    def _pop_waiting(self, zid: str, token: str) -> Entity | None:
        waiting = self._waiting.get(zid, {})
        entity = waiting.pop(token, None)
        if entity is not None:
            self._num_waiting -= 1
            if not waiting:
                del self._waiting[zid]
        return entity

    def _admit(self) -> None:
        """Admit a waiting token if there is room for it. The search is fast: few sessions can be at their limit."""
        zid = next((zid for zid in self._waiting if self._has_room(zid)), None)
        if zid is not None:
            token = next(iter(self._waiting[zid]))
            entity = self._pop_waiting(zid, token)
            assert entity is not None
            self._insert(token, entity)

    def _insert(self, token: str, entity: Entity) -> None:
        self._entities[token] = entity
        self._sizes[entity.zid] = self._sizes.get(entity.zid, 0) + 1
        if entity.kind is Kind.NODE:
            self._nodes[token] = entity
        else:
            self._entities_by_name(entity).setdefault(entity.topic, {})[token] = entity
        self._note_change(entity)

    def remove(self, token: str) -> bool:
        """Remove a token.

        Returns:
            Whether anything changed.
        """
        entity = self._entities.pop(token, None)
        if entity is None:
            self._pop_waiting("".join(token.split("/", 3)[2:3]), token)
            return False
        self._sizes[entity.zid] -= 1
        if not self._sizes[entity.zid]:
            del self._sizes[entity.zid]
        if entity.kind is Kind.NODE:
            del self._nodes[token]
        else:
            named = self._entities_by_name(entity)
            del named[entity.topic][token]
            if not named[entity.topic]:
                del named[entity.topic]
        self._note_change(entity)
        self._admit()
        return True

    def nodes(self) -> tuple[Entity, ...]:
        """Return all nodes, sorted by full name; names need not be unique."""
        return tuple(sorted(self._nodes.values(), key=lambda node: (node.full_node_name, _key(node))))

    def topics(self) -> dict[str, Topic]:
        """Return all topics, sorted by name."""
        return {name: self.topic(name) for name in sorted(self._topics)}

    def services(self) -> dict[str, Service]:
        """Return all services that have a server or a client, sorted by name."""
        return {name: self.service(name) for name in sorted(self._services)}

    def topic(self, name: str) -> Topic:
        """Return the publishers and subscribers of a topic; empty if it is not known."""
        return Topic(*_partition(self._topics.get(name, {}).values(), Kind.PUBLISHER))

    def publishers(self, name: str) -> dict[str, Entity]:
        """Return the publishers of a topic, by their tokens."""
        return {token: entity for token, entity in self._topics.get(name, {}).items() if entity.kind is Kind.PUBLISHER}

    def service(self, name: str) -> Service:
        """Return the servers and clients of a service; empty if it is not known."""
        return Service(*_partition(self._services.get(name, {}).values(), Kind.SERVICE))

    def take_changes(self) -> Changes:
        """Return what has changed since the last call, or since the start."""
        changes = Changes(
            frozenset(self._changed_topics),
            frozenset(self._changed_services),
            self._nodes_changed,
            self._everything_changed,
        )
        self._changed_topics.clear()
        self._changed_services.clear()
        self._nodes_changed = self._everything_changed = False
        return changes

    def _entities_by_name(self, entity: Entity) -> dict[str, dict[str, Entity]]:
        return self._topics if entity.kind in (Kind.PUBLISHER, Kind.SUBSCRIBER) else self._services

    def _note_change(self, entity: Entity) -> None:
        if entity.kind is Kind.NODE:
            self._nodes_changed = True
        elif not self._everything_changed:
            of_topic = entity.kind in (Kind.PUBLISHER, Kind.SUBSCRIBER)
            (self._changed_topics if of_topic else self._changed_services).add(entity.topic)
            # Other programs may use any number of new names before the owner looks.
            if len(self._changed_topics) + len(self._changed_services) > self._max_entities:
                self._changed_topics.clear()
                self._changed_services.clear()
                self._everything_changed = True


def _types_of(entities: Iterable[Entity]) -> tuple[HashedType, ...]:
    return tuple(sorted({HashedType(entity.type, entity.hash) for entity in entities}))


def _partition(entities: Iterable[Entity], kind: Kind) -> tuple[tuple[Entity, ...], tuple[Entity, ...]]:
    """Return the entities of a kind and the others, both ordered by session, node and number."""
    ordered = sorted(entities, key=_key)
    return (
        tuple(entity for entity in ordered if entity.kind is kind),
        tuple(entity for entity in ordered if entity.kind is not kind),
    )


def _key(entity: Entity) -> tuple[str, int, int]:
    return entity.zid, entity.node_id, entity.entity_id
