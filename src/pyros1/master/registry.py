"""The master's registry of the publishers, subscribers and services of all nodes
(https://wiki.ros.org/ROS/Master_API).

A node is registered with its name and API URI as long as it has a publication, subscription, service or parameter
subscription (M37). A node that registers under the same name with another URI replaces the old node, which is asked to
shut down and whose registrations are all removed (M34).

This module sends nothing: methods change the registry and return the notices to be sent to nodes. All names must be
resolved.
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
        api: the node's API URI.
        node: the node's name.
        method: ``publisherUpdate``, ``paramUpdate`` or ``shutdown``.
        subject: the argument after the caller id: a topic, a key, or the reason.
        value: the arguments after the subject: none or one.
        is_repeat: whether the node has just received the same value in a response. The notice is then sent only if an
            older one about the same subject is queued or in progress and might arrive later.
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
        name: the node's name.
        api: the node's API URI.
        publications, subscriptions: the topics that it publishes and subscribes to.
    """

    name: str
    api: str
    publications: frozenset[str]
    subscriptions: frozenset[str]


@dataclass(slots=True)
class _Node:
    api: str
    replaced_api: str = ""  # API URI of the node of the same name that this node replaced
    publications: set[str] = field(default_factory=set)
    subscriptions: set[str] = field(default_factory=set)
    services: set[str] = field(default_factory=set)
    parameters: set[str] = field(default_factory=set)

    @property
    def is_idle(self) -> bool:
        return not (self.publications or self.subscriptions or self.services or self.parameters)


Members = dict[str, dict[str, str]]
"""Topic or key -> node -> API URI, both in the order of registration (M23)."""


def _remove_member(members: Members, name: str, node: str) -> None:
    nodes = members.get(name)
    if nodes is not None:
        nodes.pop(node, None)
        if not nodes:
            del members[name]


class Registry:
    """The registrations of all nodes."""

    def __init__(self) -> None:
        self._nodes: dict[str, _Node] = {}
        self._publishers: Members = {}
        self._subscribers: Members = {}
        self._services: dict[str, tuple[str, str]] = {}  # service -> (node, rosrpc URI)
        self._types: dict[str, str] = {}
        self.param_subscribers: Members = {}
        self.version = 0
        """Incremented with every change."""

    # ---- queries

    def node_api(self, node: str) -> str | None:
        """Return a node's API URI; None if the node is not registered (M20)."""
        entry = self._nodes.get(node)
        return entry.api if entry is not None else None

    def service_uri(self, service: str) -> str | None:
        """Return the URI of a service's provider; None if there is none (M19)."""
        provider = self._services.get(service)
        return provider[1] if provider is not None else None

    def published_topics(self, subgraph: str) -> list[list[str]]:
        """Return ``[[topic, type], ...]`` for the topics below the namespace ``subgraph`` that have a publisher (M21).

        An empty ``subgraph`` means all namespaces.
        """
        prefix = subgraph if not subgraph or subgraph.endswith(SEP) else subgraph + SEP
        return [[topic, self._types.get(topic, ANY_TYPE)] for topic in self._publishers if topic.startswith(prefix)]

    def topic_types(self) -> list[list[str]]:
        """Return ``[[topic, type], ...]`` for all topics whose type has ever been known (M22)."""
        return [[topic, topic_type] for topic, topic_type in self._types.items()]

    def system_state(self) -> list[list[list[Any]]]:
        """Return ``[publishers, subscribers, services]``, each of the form ``[[name, [node, ...]], ...]`` (M23)."""
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

    def is_subscribed(self, node: str, topic: str, api: str) -> bool:
        """Return whether a node is registered as subscriber of a topic at this API URI."""
        return self._subscribers.get(topic, {}).get(node) == api

    # ---- changes

    def register_publisher(self, node: str, topic: str, topic_type: str, api: str) -> list[Notice]:
        """Add a publisher; return the notices. The publisher's type replaces the topic's, unless it is ``*`` (M32)."""
        self.version += 1
        notices = self._set_node_api(node, api)
        self._nodes[node].publications.add(topic)
        self._publishers.setdefault(topic, {})[node] = api
        if topic_type != ANY_TYPE or topic not in self._types:
            self._types[topic] = topic_type
        return notices + self._publisher_updates(topic)

    def register_subscriber(self, node: str, topic: str, topic_type: str, api: str) -> list[Notice]:
        """Add a subscriber; return the notices. Its type is only used if the topic's type is not known (M32)."""
        self.version += 1
        notices = self._set_node_api(node, api)
        self._nodes[node].subscriptions.add(topic)
        self._subscribers.setdefault(topic, {})[node] = api
        if topic_type != ANY_TYPE and topic not in self._types:
            self._types[topic] = topic_type
        return [*notices, Notice(api, node, "publisherUpdate", topic, (self.publisher_apis(topic),), is_repeat=True)]

    def register_service(self, node: str, service: str, uri: str, api: str) -> list[Notice]:
        """Make a node the only provider of a service, replacing any other (M17); return the notices."""
        self.version += 1
        notices = self._set_node_api(node, api)
        self._nodes[node].services.add(service)
        self._services[service] = (node, uri)
        return notices

    def subscribe_param(self, node: str, key: str, api: str) -> list[Notice]:
        """Subscribe a node to changes at, above and below a key (M29); return the notices.

        A node that was replaced and has been asked to shut down is not registered again; it only reads the value. With
        the stock master, the replaced node would take the name back, and the new node would be shut down as well. This
        happens to roscpp nodes: they read `/tcp_keepalive` for each connection that they accept, often at that moment.
        """
        entry = self._nodes.get(node)
        if entry is not None and api == entry.replaced_api:
            return []
        self.version += 1
        notices = self._set_node_api(node, api)
        self._nodes[node].parameters.add(key)
        self.param_subscribers.setdefault(key, {})[node] = api
        return notices

    def unregister_publisher(self, node: str, topic: str, api: str) -> list[Notice] | None:
        """Remove a publisher; return the notices, or None if it was not registered with that API URI (M16)."""
        if self._publishers.get(topic, {}).get(node) != api:
            return None
        self.version += 1
        _remove_member(self._publishers, topic, node)
        self._nodes[node].publications.discard(topic)
        self._drop_if_idle(node)
        return self._publisher_updates(topic)

    def unregister_subscriber(self, node: str, topic: str, api: str) -> bool:
        """Remove a subscriber; return False if it was not registered with that API URI (M16)."""
        if self._subscribers.get(topic, {}).get(node) != api:
            return False
        self.version += 1
        _remove_member(self._subscribers, topic, node)
        self._nodes[node].subscriptions.discard(topic)
        self._drop_if_idle(node)
        return True

    def unregister_service(self, node: str, service: str, uri: str) -> bool:
        """Remove a service; return False if the node is not its current provider with that URI (M18)."""
        is_current = self._services.get(service) == (node, uri)
        if is_current:
            self.version += 1
            del self._services[service]
        entry = self._nodes.get(node)
        if entry is not None and (is_current or self._services.get(service, ("", ""))[0] != node):
            # Even if another node has taken over the service, this node has now stopped providing it.
            self.version += 1
            entry.services.discard(service)
            self._drop_if_idle(node)
        return is_current

    def unsubscribe_param(self, node: str, key: str, api: str) -> None:
        """Remove a parameter subscription; no effect if there is none with that API URI (M30)."""
        if self.param_subscribers.get(key, {}).get(node) != api:
            return
        self.version += 1
        _remove_member(self.param_subscribers, key, node)
        self._nodes[node].parameters.discard(key)
        self._drop_if_idle(node)

    def forget(self, node: str, api: str) -> list[Notice]:
        """Remove a node and all its registrations, if ``api`` is its API URI; return the notices."""
        entry = self._nodes.get(node)
        if entry is None or entry.api != api:
            return []
        self.version += 1
        del self._nodes[node]
        return self._purge(node, entry)

    # ---- recovery after a restart

    def nodes(self) -> list[RegisteredNode]:
        """Return all nodes with their topics."""
        return [
            RegisteredNode(name, entry.api, frozenset(entry.publications), frozenset(entry.subscriptions))
            for name, entry in self._nodes.items()
        ]

    def calls(self) -> Iterator[tuple[str, tuple[str, ...]]]:
        """Yield the calls to the Master API that reproduce these registrations in an empty registry, in order (M23)."""
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
        """Restore the types of topics, including those that currently have no publisher (M22)."""
        self._types = dict(types)

    # ---- internal

    def _publisher_updates(self, topic: str) -> list[Notice]:
        """Return a notice with all publishers of a topic, for each of its subscribers (M38)."""
        subscribers = self._subscribers.get(topic)
        if not subscribers:
            return []
        publishers = self.publisher_apis(topic)
        return [Notice(api, node, "publisherUpdate", topic, (publishers,)) for node, api in subscribers.items()]

    def _set_node_api(self, node: str, api: str) -> list[Notice]:
        """Make sure that a node is registered with an API URI, replacing an older node of the same name; return the
        resulting notices.
        """
        entry = self._nodes.get(node)
        if entry is not None and entry.api == api:
            return []
        notices = []
        if entry is not None:
            notices = self._purge(node, entry)
            if not any(other.api == entry.api for name, other in self._nodes.items() if name != node):
                # If another node is registered with the old URI, the old node has exited, and its port is used again.
                reason = f"[{node}] Reason: new node registered with same name"
                notices = [Notice(entry.api, node, "shutdown", reason), *notices]
        self._nodes[node] = _Node(api, entry.api if entry is not None else "")
        return notices

    def _purge(self, node: str, entry: _Node) -> list[Notice]:
        """Remove all registrations of a node; return the notices to subscribers.

        Unlike stock, this notifies subscribers (M35), which would otherwise keep trying to reach the dead publisher.
        """
        for topic in entry.subscriptions:
            _remove_member(self._subscribers, topic, node)
        for key in entry.parameters:
            _remove_member(self.param_subscribers, key, node)
        for service in entry.services:
            if self._services.get(service, ("", ""))[0] == node:
                del self._services[service]
        for topic in entry.publications:
            _remove_member(self._publishers, topic, node)
        return [notice for topic in sorted(entry.publications) for notice in self._publisher_updates(topic)]

    def _drop_if_idle(self, node: str) -> None:
        if self._nodes[node].is_idle:
            del self._nodes[node]
