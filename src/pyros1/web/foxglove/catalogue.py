"""The channels and services offered to all viewers: those that the master lists, with their definitions.

Only the master is polled, so there is no load on the robot's nodes. A node is queried only once, for what the master
does not know: a service's type, or the definition of a message type that is not installed here.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Hashable, Mapping
from functools import partial
from itertools import count, islice
from time import monotonic
from typing import NamedTuple

from pyros1.doctor.concurrent import run_concurrently
from pyros1.doctor.probe import query_publisher
from pyros1.graph import Graph, SystemState, probe_service
from pyros1.ground.errors import Error, MessageError
from pyros1.ground.terminal_text import untrusted
from pyros1.msgs import DefinitionCache, load_message, load_service
from pyros1.web.foxglove.offers import ANY_CHECKSUM, Channel, Nodes, Offers, Service, Table
from pyros1.web.server.wire import RequestError

_NODE_TIMEOUT = 1.0
"""Timeout in seconds for a request to a node."""
_MAX_CONCURRENT_QUERIES = 64
"""Maximum number of concurrent requests to nodes."""
_RETRY_DELAY = 10.0
"""Seconds after which a failed request to a node is repeated."""
_MAX_STALE_IDS = 10_000
_MAX_NEW_HEADERS = 1_000
_MAX_PUBLISHERS = 50
"""Maximum number of publishers per topic whose definitions are kept."""


class _Definition(NamedTuple):
    type: str
    md5sum: str
    text: str


class _TopicReply(NamedTuple):
    publisher: str
    definition: _Definition


class Catalogue:
    """Keeps the offers to viewers up to date: the channels and services that the master lists.

    Args:
        graph: sends requests to the master.
        may_see: returns whether viewers may see a topic or service.
        clock: returns the time in seconds.
    """

    def __init__(self, graph: Graph, may_see: Callable[[str], bool], clock: Callable[[], float] = monotonic) -> None:
        self._graph = graph
        self._may_see = may_see
        self._clock = clock
        self._lock = threading.Lock()
        self._query_lock = threading.Lock()
        self._refreshed_at = float("-inf")
        self._offers = Offers()
        self._ids: dict[Hashable, int] = {}
        self._next_ids = count(1)
        # topic -> publisher -> the publisher's definition, where it differs from the installed one. The channel has the
        # definition of the first publisher that is still registered.
        self._topic_definitions: dict[str, dict[str, _Definition]] = {}
        self._unusable_definitions: dict[str, tuple[str, str]] = {}  # topic -> (publisher, problem)
        self._service_types: dict[str, tuple[list[str], str]] = {}  # service -> (its nodes, its type)
        self._pending_queries: dict[str, Callable[[], _TopicReply | str]] = {}
        self._retry_at: dict[str, float] = {}
        self._master_problem = ""  # why the last request to the master failed
        self._new_headers: deque[tuple[str, dict[str, str]]] = deque(maxlen=_MAX_NEW_HEADERS)
        self._problems: dict[str, str] = {}

    def current_offers(self, max_age: float) -> Offers:
        """Return the current offers.

        Args:
            max_age: the latest result is returned if it is not older than this, in seconds. With 0, the master is
                always queried, after any request of another thread has ended.

        Raises:
            RequestError: the master does not respond.
        """
        # While one thread queries the master, the others return the latest result.
        if self._lock.acquire(blocking=max_age <= 0):
            try:
                if self._new_headers or self._clock() - self._refreshed_at >= max_age:
                    self._refresh()
            finally:
                self._lock.release()
        if self._master_problem:
            raise RequestError(self._master_problem)
        return self._offers

    def query_nodes(self) -> None:
        """Query nodes for missing definitions and service types. This takes about a second if nodes do not respond."""
        with self._query_lock:
            with self._lock:
                queries = dict(islice(self._pending_queries.items(), _MAX_CONCURRENT_QUERIES))
            replies = run_concurrently(queries, _NODE_TIMEOUT)
            with self._lock:
                for name, reply in replies.items():
                    if isinstance(reply, Exception):
                        self._retry_at[name] = self._clock() + _RETRY_DELAY
                        self._problems[name] = f"{name}: {reply}"
                        continue
                    self._problems.pop(name, None)
                    if isinstance(reply, str):
                        self._service_types[name] = (list(self._offers.nodes.services.get(name, ())), reply)
                    else:
                        self._store_definition(name, *reply)
                self._refresh()

    def add_header(self, channel: Channel, header: Mapping[str, str]) -> None:
        """Store the header of a publisher whose definition differs from the channel's, for the next refresh.
        Thread-safe.
        """
        self._new_headers.append((channel.topic, dict(header)))

    def _apply_header(self, topic: str, header: Mapping[str, str]) -> None:
        publisher = header.get("callerid", "")
        try:
            definition = _checked_definition(
                header.get("type", ""), header.get("md5sum", ANY_CHECKSUM), header.get("message_definition", "")
            )
        except MessageError as error:
            problem = f"{topic}: the definition of {untrusted(publisher) or 'a publisher'} is unusable: {error}"
            self._unusable_definitions[topic] = (publisher, problem)
            return
        self._store_definition(topic, publisher, definition)

    def _store_definition(self, topic: str, publisher: str, definition: _Definition) -> None:
        definitions = self._topic_definitions.setdefault(topic, {})
        if len(definitions) < _MAX_PUBLISHERS or publisher in definitions:
            definitions[publisher] = definition

    def _forget_unregistered(self, nodes: Nodes) -> None:
        """Remove the definitions of publishers that are gone, since later publishers may use other definitions."""
        for topic, definitions in list(self._topic_definitions.items()):
            publishers = nodes.publishers.get(topic)
            if publishers:
                self._topic_definitions[topic] = {
                    publisher: definition for publisher, definition in definitions.items() if publisher in publishers
                }
        self._topic_definitions = {
            topic: definitions for topic, definitions in self._topic_definitions.items() if definitions
        }
        for topic, (publisher, _) in list(self._unusable_definitions.items()):
            if publisher and publisher not in nodes.publishers.get(topic, ()):
                del self._unusable_definitions[topic]

    def _definition_problems(self) -> dict[str, str]:
        """Return topic -> problem for topics whose publishers have different or unusable definitions."""
        problems: dict[str, str] = {}
        for topic, definitions in self._topic_definitions.items():
            first = next(iter(definitions.values()))
            for publisher, definition in definitions.items():
                if definition != first:
                    problem = (
                        f"{untrusted(publisher)} publishes a different {untrusted(definition.type)} than other nodes"
                    )
                    problems[topic] = f"{topic}: {problem}; its messages are omitted"
        return {**problems, **{topic: text for topic, (_, text) in self._unusable_definitions.items()}}

    def _refresh(self) -> None:
        try:
            state, types = self._graph.state(), self._graph.topic_types()
        except Error as error:
            self._master_problem, self._refreshed_at = str(error), self._clock()
            return
        self._master_problem = ""
        while self._new_headers:
            self._apply_header(*self._new_headers.popleft())
        self._update_offers(state, {name: type_name for name, type_name in types.items() if self._may_see(name)})

    def _update_offers(self, state: SystemState, types: Mapping[str, str]) -> None:
        tables = [self._visible_names(table) for table in state]
        nodes = Nodes(*tables)
        for entries in (
            self._topic_definitions,
            self._retry_at,
            self._problems,
            self._service_types,
            self._unusable_definitions,
        ):
            for name in [name for name in entries if name not in types and name not in nodes.services]:
                del entries[name]
        self._forget_unregistered(nodes)
        for name, (providers, _) in list(self._service_types.items()):
            if nodes.services.get(name) != providers:  # the node that provides the service now may use another type
                del self._service_types[name]
        channels = {
            offer.topic: offer
            for name, type_name in types.items()
            if (offer := self._make_channel(name, type_name, nodes))
        }
        services = {offer.name: offer for offer in map(self._make_service, nodes.services) if offer}
        if len(self._ids) > 2 * (len(channels) + len(services)) + _MAX_STALE_IDS:
            current = {*(offer.id for offer in channels.values()), *(offer.id for offer in services.values())}
            self._ids = {key: number for key, number in self._ids.items() if number in current}
        self._pending_queries = self._new_queries(channels, nodes)
        problems = {**self._problems, **self._definition_problems()}
        self._offers = Offers(channels, services, nodes, problems, has_pending_queries=bool(self._pending_queries))
        self._refreshed_at = self._clock()

    def _visible_names(self, table: Table) -> Table:
        return {name: nodes for name, nodes in table.items() if self._may_see(name)}

    def _make_channel(self, topic: str, type_name: str, nodes: Nodes) -> Channel | None:
        if topic not in nodes.publishers and topic not in nodes.subscribers:
            return None
        definitions = self._topic_definitions.get(topic)
        definition = next(iter(definitions.values())) if definitions else None
        if definition is None:
            try:
                cls = load_message(type_name)
            except MessageError:
                return None
            definition = _Definition(type_name, cls._md5sum, cls._full_text)
        return Channel(
            self._id_for("topic", topic, *definition), topic, definition.type, definition.text, definition.md5sum
        )

    def _make_service(self, name: str) -> Service | None:
        nodes_and_type = self._service_types.get(name)
        if nodes_and_type is None:
            return None
        type_name = nodes_and_type[1]
        try:
            cls = load_service(type_name)
        except MessageError:
            self._problems[name] = f"{name}: the definition of its type {type_name} is not installed here"
            return None
        return Service(
            self._id_for("service", name, type_name),
            name,
            type_name,
            cls._request_class._full_text,
            cls._response_class._full_text,
        )

    def _id_for(self, *key: Hashable) -> int:
        if key not in self._ids:
            self._ids[key] = next(self._next_ids)
        return self._ids[key]

    def _new_queries(self, channels: Mapping[str, Channel], nodes: Nodes) -> dict[str, Callable[[], _TopicReply | str]]:
        """Return the requests that must be sent to nodes, by topic or service."""
        now = self._clock()
        queries: dict[str, Callable[[], _TopicReply | str]] = {}
        for topic, publishers in nodes.publishers.items():
            if topic not in channels and self._retry_at.get(topic, now) <= now:
                queries[topic] = partial(self._query_topic, topic, publishers[0])
        for service in nodes.services:
            if service not in self._service_types and self._retry_at.get(service, now) <= now:
                queries[service] = partial(self._query_service, service)
        return queries

    def _query_topic(self, topic: str, publisher: str) -> _TopicReply:
        uri = self._graph.node_uri(publisher)
        if uri is None:
            raise MessageError(f"its publisher {publisher} is gone")
        offer = query_publisher(self._graph.master.caller_id, uri, topic)
        if offer.failure is not None:
            raise MessageError(f"its publisher {publisher} does not report its type: {untrusted(offer.failure.text)}")
        return _TopicReply(publisher, _checked_definition(offer.type, offer.md5sum, offer.definition))

    def _query_service(self, name: str) -> str:
        uri = self._graph.service_uri(name)
        if uri is None:
            raise MessageError("no node provides this service")
        type_name = probe_service(name, uri, self._graph.master.caller_id, _NODE_TIMEOUT).get("type")
        if not type_name:
            raise MessageError("its provider does not report its type")
        return type_name


def _checked_definition(type_name: str, md5sum: str, text: str) -> _Definition:
    """Return a publisher's definition after checking that viewers can use it.

    Raises:
        MessageError: viewers cannot use the definition.
    """
    try:
        cls = load_message(type_name)
        if md5sum == cls._md5sum:
            return _Definition(type_name, md5sum, cls._full_text)
    except Error:
        pass  # the type is not installed here
    return _Definition(type_name, md5sum, DefinitionCache().get(type_name, md5sum, text)._full_text)
