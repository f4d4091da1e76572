"""The master's registry: publishers, subscribers and services of all nodes (https://wiki.ros.org/ROS/Master_API).

A node is known by its name and its one API URI for as long as it has a publication, subscription, service or parameter
subscription (M37). The same name with another URI is a new node that takes the old one's place: the old one is asked to
shut down, and all its registrations are removed (M34).

Pure: methods change the registry and return the notices that must be sent to nodes; names arrive resolved.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from pyros1.ground.names import SEP

ANY_TYPE = "*"


class Notice(NamedTuple):
    """A call to be made to a node.

    Attributes:
        api: the node's URI.
        node: its name.
        method: ``publisherUpdate``, ``paramUpdate`` or ``shutdown``.
        subject: topic, key or reason: the argument after the caller id.
        value: what follows the subject, empty or one item.
        is_repeat: the node has just got the same answer. It is notified again only if an older notice of the same,
            which may be under way, could come after that answer.
    """

    api: str
    node: str
    method: str
    subject: str
    value: tuple[Any, ...] = ()
    is_repeat: bool = False


class RegisteredNode(NamedTuple):
    """A registered node.

    Attributes:
        name: its name.
        api: its API URI.
        publications, subscriptions: its topics.
    """

    name: str
    api: str
    publications: frozenset[str]
    subscriptions: frozenset[str]


@dataclass(slots=True)
class _Node:
    api: str
    replaced: str = ""  # API URI of the namesake whose place it took
    publications: set[str] = field(default_factory=set)
    subscriptions: set[str] = field(default_factory=set)
    services: set[str] = field(default_factory=set)
    parameters: set[str] = field(default_factory=set)

    @property
    def idle(self) -> bool:
        return not (self.publications or self.subscriptions or self.services or self.parameters)


Members = dict[str, dict[str, str]]
"""Topic or key -> node -> API URI; both in the order of registration (M23)."""


def _remove(members: Members, name: str, node: str) -> None:
    those = members.get(name)
    if those is not None:
        those.pop(node, None)
        if not those:
            del members[name]


class Registry:
    """All registrations."""

    def __init__(self) -> None:
        self._nodes: dict[str, _Node] = {}
        self._publishers: Members = {}
        self._subscribers: Members = {}
        self._services: dict[str, tuple[str, str]] = {}  # service -> (node, rosrpc URI)
        self._types: dict[str, str] = {}
        self.param_subscribers: Members = {}
        self.version = 0
        """Grows with every change."""

    # ---- questions

    def node_api(self, node: str) -> str | None:
        """Return a node's API URI, None if it is not known (M20)."""
        entry = self._nodes.get(node)
        return entry.api if entry is not None else None

    def service_uri(self, service: str) -> str | None:
        """Return the URI of a service's provider, None if there is none (M19)."""
        provider = self._services.get(service)
        return provider[1] if provider is not None else None

    def published_topics(self, subgraph: str) -> list[list[str]]:
        """Return ``[[topic, type], ...]`` of topics with a publisher below a namespace; empty: everywhere (M21)."""
        prefix = subgraph if not subgraph or subgraph.endswith(SEP) else subgraph + SEP
        return [[topic, self._types.get(topic, ANY_TYPE)] for topic in self._publishers if topic.startswith(prefix)]

    def topic_types(self) -> list[list[str]]:
        """Return ``[[topic, type], ...]`` of all topics that ever had a type (M22)."""
        return [[topic, kind] for topic, kind in self._types.items()]

    def system_state(self) -> list[list[list[Any]]]:
        """Return ``[publishers, subscribers, services]``, each ``[[name, [node, ...]], ...]`` (M23)."""
        return [
            [[topic, list(nodes)] for topic, nodes in self._publishers.items()],
            [[topic, list(nodes)] for topic, nodes in self._subscribers.items()],
            [[service, [provider[0]]] for service, provider in self._services.items()],
        ]

    def publisher_apis(self, topic: str) -> list[str]:
        """Return the API URIs of a topic's publishers."""
        return list(self._publishers.get(topic, {}).values())

    def subscriber_apis(self, topic: str) -> list[str]:
        """Return the API URIs of a topic's subscribers."""
        return list(self._subscribers.get(topic, {}).values())

    # ---- changes

    def register_publisher(self, node: str, topic: str, kind: str, api: str) -> list[Notice]:
        """Add a publisher. A real type overwrites what was known, ``*`` does not (M32)."""
        self.version += 1
        notices = self._claim_api(node, api)
        self._nodes[node].publications.add(topic)
        self._publishers.setdefault(topic, {})[node] = api
        if kind != ANY_TYPE or topic not in self._types:
            self._types[topic] = kind
        return notices + self._publisher_updates(topic)

    def register_subscriber(self, node: str, topic: str, kind: str, api: str) -> list[Notice]:
        """Add a subscriber. Its type counts only where none is known (M32)."""
        self.version += 1
        notices = self._claim_api(node, api)
        self._nodes[node].subscriptions.add(topic)
        self._subscribers.setdefault(topic, {})[node] = api
        if kind != ANY_TYPE and topic not in self._types:
            self._types[topic] = kind
        return [*notices, Notice(api, node, "publisherUpdate", topic, (self.publisher_apis(topic),), is_repeat=True)]

    def register_service(self, node: str, service: str, uri: str, api: str) -> list[Notice]:
        """Make a node the only provider of a service, in place of any other (M17)."""
        self.version += 1
        notices = self._claim_api(node, api)
        self._nodes[node].services.add(service)
        self._services[service] = (node, uri)
        return notices

    def subscribe_param(self, node: str, key: str, api: str) -> list[Notice]:
        """Subscribe a node to changes at, above and below a key (M29).

        A node that was replaced and is asked to end only reads the value. Stock lets it take the name back, and then
        ends the new one as well: roscpp's nodes often read `/tcp_keepalive` at that moment, for a connection they
        accept.
        """
        entry = self._nodes.get(node)
        if entry is not None and api == entry.replaced:
            return []
        self.version += 1
        notices = self._claim_api(node, api)
        self._nodes[node].parameters.add(key)
        self.param_subscribers.setdefault(key, {})[node] = api
        return notices

    def unregister_publisher(self, node: str, topic: str, api: str) -> list[Notice] | None:
        """Remove a publisher; None if it was not registered with that API (M16)."""
        if self._publishers.get(topic, {}).get(node) != api:
            return None
        self.version += 1
        _remove(self._publishers, topic, node)
        self._nodes[node].publications.discard(topic)
        self._drop_if_idle(node)
        return self._publisher_updates(topic)

    def unregister_subscriber(self, node: str, topic: str, api: str) -> bool:
        """Remove a subscriber; False if it was not registered with that API (M16)."""
        if self._subscribers.get(topic, {}).get(node) != api:
            return False
        self.version += 1
        _remove(self._subscribers, topic, node)
        self._nodes[node].subscriptions.discard(topic)
        self._drop_if_idle(node)
        return True

    def unregister_service(self, node: str, service: str, uri: str) -> bool:
        """Remove a service; False if the node is not its present provider with that URI (M18)."""
        current = self._services.get(service) == (node, uri)
        if current:
            self.version += 1
            del self._services[service]
        entry = self._nodes.get(node)
        if entry is not None and (current or self._services.get(service, ("", ""))[0] != node):
            # Also if another node has taken over the service: this one has stopped providing it.
            self.version += 1
            entry.services.discard(service)
            self._drop_if_idle(node)
        return current

    def unsubscribe_param(self, node: str, key: str, api: str) -> None:
        """End a parameter subscription; do nothing if none has that API (M30)."""
        if self.param_subscribers.get(key, {}).get(node) != api:
            return
        self.version += 1
        _remove(self.param_subscribers, key, node)
        self._nodes[node].parameters.discard(key)
        self._drop_if_idle(node)

    def forget(self, node: str, api: str) -> list[Notice]:
        """Remove a node with all its registrations, if this is its API."""
        entry = self._nodes.get(node)
        if entry is None or entry.api != api:
            return []
        self.version += 1
        del self._nodes[node]
        return self._purge(node, entry)

    # ---- to continue after a restart

    def nodes(self) -> list[RegisteredNode]:
        """Return all nodes, with the topics that they publish and subscribe."""
        return [
            RegisteredNode(name, entry.api, frozenset(entry.publications), frozenset(entry.subscriptions))
            for name, entry in self._nodes.items()
        ]

    def calls(self) -> Iterator[tuple[str, tuple[str, ...]]]:
        """Yield the calls of the Master API that make these registrations in an empty registry, in order (M23)."""
        for topic, nodes in self._publishers.items():
            for node, api in nodes.items():
                yield "registerPublisher", (node, topic, self._types[topic], api)
        for topic, nodes in self._subscribers.items():
            for node, api in nodes.items():
                yield "registerSubscriber", (node, topic, self._types.get(topic, ANY_TYPE), api)
        for service, (node, uri) in self._services.items():
            yield "registerService", (node, service, uri, self._nodes[node].api)
        for key, nodes in self.param_subscribers.items():
            for node, api in nodes.items():
                yield "subscribeParam", (node, api, key)

    def restore_types(self, types: Iterable[tuple[str, str]]) -> None:
        """Take over the types of topics, including those that have no publisher now (M22)."""
        self._types = dict(types)

    # ---- inside

    def _publisher_updates(self, topic: str) -> list[Notice]:
        """Return a notice with all publishers of a topic for each subscriber (M38)."""
        subscribers = self._subscribers.get(topic)
        if not subscribers:
            return []
        publishers = self.publisher_apis(topic)
        return [Notice(api, node, "publisherUpdate", topic, (publishers,)) for node, api in subscribers.items()]

    def _claim_api(self, node: str, api: str) -> list[Notice]:
        """Make sure that the node is known under this API; take an older namesake's place."""
        entry = self._nodes.get(node)
        if entry is not None and entry.api == api:
            return []
        notices = []
        if entry is not None:
            notices = self._purge(node, entry)
            if not any(other.api == entry.api for name, other in self._nodes.items() if name != node):
                # Otherwise it is dead, and another node has got its port.
                reason = f"[{node}] Reason: new node registered with same name"
                notices = [Notice(entry.api, node, "shutdown", reason), *notices]
        self._nodes[node] = _Node(api, entry.api if entry is not None else "")
        return notices

    def _purge(self, node: str, entry: _Node) -> list[Notice]:
        """Remove all registrations of a node.

        Stock does not notify subscribers (M35), which then keep trying to reach the dead publisher; here they are
        notified.
        """
        for topic in entry.subscriptions:
            _remove(self._subscribers, topic, node)
        for key in entry.parameters:
            _remove(self.param_subscribers, key, node)
        for service in entry.services:
            if self._services.get(service, ("", ""))[0] == node:
                del self._services[service]
        for topic in entry.publications:
            _remove(self._publishers, topic, node)
        return [notice for topic in sorted(entry.publications) for notice in self._publisher_updates(topic)]

    def _drop_if_idle(self, node: str) -> None:
        if self._nodes[node].idle:
            del self._nodes[node]
