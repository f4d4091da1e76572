"""Reads the ROS 2 graph from rclpy, and represents it as the tokens that rmw_zenoh's nodes announce, so that a bridge
need not know the difference. Does not import rclpy: its node is passed.

rclpy has no public notification of changes, so the graph is polled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from hashlib import blake2b
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ros2.rclpy_side.qos import from_rclpy
from pyros1.ros2.zenoh.graph import MAX_ENTITIES
from pyros1.ros2.zenoh.names import HUMBLE_HASH
from pyros1.ros2.zenoh.tokens import Entity, Kind, encode_token

IGNORED_TOPICS = ("/parameter_events",)
"""Topics that nearly all nodes have, and that are never bridged; `/rosout` is."""
GID_SIZE = 16
"""Number of significant bytes in an endpoint's identifier: some versions of rclpy add zeros."""
_PREFIX_SIZE = 12
"""Number of leading bytes of an endpoint's identifier that all endpoints of a DDS participant, i.e. a process, share.
With other middleware, they mean nothing.
"""


class GraphReader:
    """Reads the graph of ROS 2.

    Args:
        node: the bridge's node; it and its endpoints are left out.
        domain: the ROS domain.
        own_name: the name of the node; other nodes with this name are included, but not their endpoints.
        hash_of: returns the hash of an installed type, or raises an `Error`. Used where ROS 2 does not tell the hash:
            for services, and for Humble nodes.
    """

    def __init__(self, node: Any, domain: int, own_name: str, hash_of: Callable[[str], str]) -> None:
        self._node = node
        self._domain = domain
        self._own_name = own_name
        self._hash_of = hash_of

    def use_node(self, node: Any, own_name: str) -> None:
        """Use another node from now on."""
        self._node = node
        self._own_name = own_name

    def read(self) -> set[str]:
        """Return the tokens of all entities with legal names, at most `MAX_ENTITIES`."""
        tokens: set[str] = set()
        for entity in self._entities():
            with suppress(Error):  # an illegal name
                tokens.add(encode_token(entity))
            if len(tokens) >= MAX_ENTITIES:
                break
        return tokens

    def own_gids(self, topic: str) -> dict[bytes, bool]:
        """Return the identifiers of a topic's publishers, and whether each belongs to a node with our name."""
        return {_gid(each): self._is_own(each.node_name) for each in self._node.get_publishers_info_by_topic(topic)}

    def latched_publishers(self, topic: str) -> int:
        """Return how many publishers of a topic keep messages for late subscribers, not counting our own."""
        infos = self._node.get_publishers_info_by_topic(topic)
        return sum(not self._is_own(each.node_name) and from_rclpy(each.qos_profile).transient_local for each in infos)

    def _is_own(self, node_name: str) -> bool:
        return node_name == self._own_name

    def _entities(self) -> Iterator[Entity]:
        is_first = True
        for name, namespace in self._node.get_node_names_and_namespaces():
            node = self._entity(Kind.NODE, f"{namespace} {name}", name, namespace)
            if not self._is_own(name):
                yield node
                yield from self._services(node, name, namespace)
            elif not is_first:  # the first one is ours
                yield node
            is_first = is_first and not self._is_own(name)
        for topic, _ in self._node.get_topic_names_and_types():
            if topic not in IGNORED_TOPICS:
                yield from self._endpoints(Kind.PUBLISHER, topic, self._node.get_publishers_info_by_topic(topic))
                yield from self._endpoints(Kind.SUBSCRIBER, topic, self._node.get_subscriptions_info_by_topic(topic))

    def _services(self, node: Entity, name: str, namespace: str) -> Iterator[Entity]:
        for kind, ask in (
            (Kind.SERVICE, self._node.get_service_names_and_types_by_node),
            (Kind.CLIENT, self._node.get_client_names_and_types_by_node),
        ):
            try:
                found = ask(name, namespace)
            except Exception:  # noqa: BLE001 - the node has ended; which module has the exception depends on rclpy
                return
            for service, types in found:
                for type_name in types:
                    number = _number(f"{kind.value} {namespace} {name} {service} {type_name}".encode())
                    yield node._replace(
                        kind=kind, entity_id=number, topic=service, type=type_name, hash=self._hash(type_name)
                    )

    def _endpoints(self, kind: Kind, topic: str, infos: Iterable[Any]) -> Iterator[Entity]:
        for info in infos:
            if self._is_own(info.node_name):
                continue
            gid, name = _gid(info), info.topic_type
            told = str(getattr(info, "topic_type_hash", ""))
            yield self._entity(
                kind, f"{info.node_namespace} {info.node_name}", info.node_name, info.node_namespace
            )._replace(
                zid=process_id(gid),
                entity_id=_number(gid),
                topic=topic,
                type=name,
                hash=told if told.startswith("RIHS") else self._hash(name),
                qos=from_rclpy(info.qos_profile),
            )

    def _entity(self, kind: Kind, full_name: str, name: str, namespace: str) -> Entity:
        number = _number(full_name.encode())
        # For a program that uses DDS without ROS, which has no node, rclpy gives placeholders instead of names.
        return Entity(
            self._domain,
            _zid(full_name.encode()),
            number,
            number,
            kind,
            name,
            namespace if namespace.startswith("/") else "/",
        )

    def _hash(self, name: str) -> str:
        try:
            return self._hash_of(name)
        except Error:
            return HUMBLE_HASH  # the type is unknown; the plan says why


def process_id(gid: bytes) -> str:
    """Return an id for an endpoint's process, used in tokens as its session id."""
    return _zid(gid[:_PREFIX_SIZE])


def _gid(info: Any) -> bytes:
    return bytes(info.endpoint_gid)[:GID_SIZE]


def _number(data: bytes) -> int:
    return int.from_bytes(blake2b(data, digest_size=7).digest(), "big")


def _zid(data: bytes) -> str:
    return f"a{blake2b(data, digest_size=12).hexdigest()}"
