"""Liveliness tokens, with which rmw_zenoh nodes announce themselves and their endpoints. No I/O.

A token is a key that exists as long as a node, publisher, subscriber, service or client does::

    @ros2_lv/DOMAIN/ZID/NODE ID/ENTITY ID/KIND/ENCLAVE/NAMESPACE/NODE[/TOPIC/DDS TYPE/HASH/QOS]

with ``%`` for each slash in a name. Newer versions of rmw_zenoh may append further parts.
"""

from __future__ import annotations

import re
from enum import Enum
from hashlib import blake2b
from typing import NamedTuple

from pyros1.ground.errors import InvalidNameError
from pyros1.ros2.zenoh.attachments import GID_SIZE
from pyros1.ros2.zenoh.names import (
    MAX_DOMAIN,
    MAX_KEY_LENGTH,
    check_domain,
    dds_type,
    is_full_name,
    is_hash,
    read_number,
    type_of_dds,
)
from pyros1.ros2.zenoh.qos import Qos, decode_qos, encode_qos

ROOT = "@ros2_lv"
"""First part of all tokens."""
_MAX_ID = (1 << 64) - 1
_ZID = re.compile(r"[0-9a-f]{1,32}")
_NODE_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,254}", re.ASCII)


class Kind(Enum):
    """The kinds of tokens, and their codes."""

    NODE = "NN"
    PUBLISHER = "MP"
    SUBSCRIBER = "MS"
    SERVICE = "SS"
    CLIENT = "SC"


class Entity(NamedTuple):
    """A parsed token.

    Attributes:
        domain: ROS domain.
        zid: identifier of the zenoh session, in hexadecimal digits; usually shared by all nodes of a process.
        node_id: number of the node in the session.
        entity_id: number of the entity in the session; for a node, its node_id.
        kind: its kind.
        node_name: name of the node, without its namespace.
        namespace: namespace of the node, ``/`` or for example ``/robot1``.
        enclave: the node's security enclave; ``/`` if it has none.
        topic: full name of the topic or service; for a node, this and the following are unset.
        type: name of its type, for example ``std_msgs/msg/String``.
        hash: the hash of its type, or `names.HUMBLE_HASH`.
        qos: its QoS profile.
    """

    domain: int
    zid: str
    node_id: int
    entity_id: int
    kind: Kind
    node_name: str
    namespace: str = "/"
    enclave: str = "/"
    topic: str = ""
    type: str = ""
    hash: str = ""
    qos: Qos = Qos()

    @property
    def full_node_name(self) -> str:
        """Name of the node with its namespace."""
        return f"{self.namespace.rstrip('/')}/{self.node_name}"


def tokens_of(domain: int) -> str:
    """Return the key expression that matches all tokens of a domain.

    Raises:
        InvalidNameError: the domain is out of range.
    """
    check_domain(domain)
    return f"{ROOT}/{domain}/**"


def encode_token(entity: Entity) -> str:
    """Return the token for an entity.

    Raises:
        InvalidNameError: a name is not legal in ROS 2, or a number is out of range.
        SerializationError: the QoS profile cannot be written.
    """
    check_domain(entity.domain)
    if not _ZID.fullmatch(entity.zid):
        raise InvalidNameError(f"'{entity.zid:.100}' is not the identifier of a zenoh session")
    if not (0 <= entity.node_id <= _MAX_ID and 0 <= entity.entity_id <= _MAX_ID):
        raise InvalidNameError("a node or endpoint has an id out of range")
    if not _NODE_NAME.fullmatch(entity.node_name):
        raise InvalidNameError(f"'{entity.node_name:.300}' is not a legal name of a node in ROS 2")
    for name in (entity.namespace, entity.enclave):
        if name != "/" and not is_full_name(name):
            raise InvalidNameError(f"'{name:.300}' is not a legal namespace or enclave in ROS 2")
    token = (
        f"{ROOT}/{entity.domain}/{entity.zid}/{entity.node_id}/{entity.entity_id}/{entity.kind.value}"
        f"/{_escape(entity.enclave)}/{_escape(entity.namespace)}/{entity.node_name}"
    )
    if entity.kind is Kind.NODE:
        return token
    if not is_full_name(entity.topic):
        raise InvalidNameError(f"'{entity.topic:.300}' is not a legal full name of a topic or service in ROS 2")
    if not is_hash(entity.hash):
        raise InvalidNameError(f"'{entity.hash:.200}' is not the hash of a type")
    return f"{token}/{_escape(entity.topic)}/{dds_type(entity.type)}/{entity.hash}/{encode_qos(entity.qos)}"


def parse_token(text: str) -> Entity | None:
    """Parse another program's token; None if it is not valid, or longer than MAX_KEY_LENGTH.

    Unknown parts at the end are ignored.
    """
    parts = text.split("/") if len(text) <= MAX_KEY_LENGTH else []
    if len(parts) < 9 or parts[0] != ROOT:
        return None
    node = _parse_node(parts)
    if node is None or node.kind is Kind.NODE:
        return node
    if len(parts) < 13:
        return None
    topic, hash_, qos = _unescape(parts[9]), parts[11], decode_qos(parts[12])
    type_name = type_of_dds(parts[10])
    if type_name is None or qos is None or not is_full_name(topic) or not is_hash(hash_):
        return None
    return node._replace(topic=topic, type=type_name, hash=hash_, qos=qos)


def gid(token: str) -> bytes:
    """Return 16 bytes that identify the entity with this token.

    rmw_zenoh uses a different hash (XXH3, which Python does not have) of the same text. For messages and calls, any
    unique bytes will do, but a ROS 2 program that looks up a message's GID in its graph will not find the publisher.
    """
    return blake2b(token.encode("utf-8", "surrogatepass"), digest_size=GID_SIZE).digest()


def _parse_node(parts: list[str]) -> Entity | None:
    """Parse the parts that all tokens have."""
    domain = read_number(parts[1], MAX_DOMAIN)
    node_id, entity_id = read_number(parts[3], _MAX_ID), read_number(parts[4], _MAX_ID)
    kind = next((kind for kind in Kind if kind.value == parts[5]), None)
    if domain is None or node_id is None or entity_id is None or kind is None or not _ZID.fullmatch(parts[2]):
        return None
    enclave, namespace, node_name = _unescape(parts[6]), _unescape(parts[7]), parts[8]
    if not (
        _NODE_NAME.fullmatch(node_name) and all(path == "/" or is_full_name(path) for path in (enclave, namespace))
    ):
        return None
    return Entity(domain, parts[2], node_id, entity_id, kind, node_name, namespace, enclave)


def _escape(name: str) -> str:
    return name.replace("/", "%")


def _unescape(text: str) -> str:
    """Return the name in a part of a token; some programs leave out the leading slash."""
    name = text.replace("%", "/")
    return f"/{name}" if name and not name.startswith("/") else name
