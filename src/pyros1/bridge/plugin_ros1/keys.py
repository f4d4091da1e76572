"""The key expressions of zenoh-plugin-ros1 (https://github.com/eclipse-zenoh/zenoh-plugin-ros1). No I/O.

A topic's messages and a service's calls have the key ``TYPE/MD5/NAMESPACE/NAME``, where TYPE is the type's name in
hexadecimal, and NAMESPACE is ``*`` for bridges without one: as a key expression, that matches all namespaces. A bridge
announces its topics and services by beacons, empty messages with the key
``ros1_discovery_info/*/CLASS/TYPE/MD5/NAMESPACE/NAME``. Bridges older than March 2025 have no NAMESPACE in the keys of
messages, but have it in the keys of beacons.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from pyros1.bridge.names import MAX_NAME_LENGTH, is_topic_name

DIALECT = "zenoh-plugin-ros1"
"""The value of ``--dialect``, and of ``dialect`` in files."""
ANY = "*"
"""The namespace of bridges that have none."""
BEACON_ROOT = "ros1_discovery_info/"
"""The prefix of all beacons' keys."""
_TYPE = re.compile(r"[A-Za-z]\w*/[A-Za-z]\w*\Z", re.ASCII)
_MD5 = re.compile(r"[0-9a-f]{32}\Z")
_NAMESPACE = re.compile(r"[A-Za-z0-9_.~-]{1,100}\Z")


class Kind(str, Enum):
    """The kinds of beacons: for publishers, subscribers, services and their clients."""

    PUBLISHER = "pub"
    SUBSCRIBER = "sub"
    SERVICE = "srv"
    CLIENT = "cl"


class Resource(NamedTuple):
    """A topic or service that a bridge announces.

    Attributes:
        kind: what it is.
        type, md5sum: the type of the topic's messages, or of the service.
        namespace: the bridge's namespace, or ``*``.
        name: full name of the topic or service.
    """

    kind: Kind
    type: str
    md5sum: str
    namespace: str
    name: str

    def __str__(self) -> str:
        return self.name if self.namespace == ANY else f"{self.namespace}:{self.name}"


def is_usable(resource: Resource) -> bool:
    """Return whether a local topic or service can be announced, or another bridge's can be used here."""
    return (
        len(resource.type) <= MAX_NAME_LENGTH
        and _TYPE.match(resource.type) is not None
        and _MD5.match(resource.md5sum) is not None
        and (resource.namespace == ANY or _NAMESPACE.match(resource.namespace) is not None)
        and is_topic_name(resource.name)
    )


def data_key(resource: Resource, old_keys: bool = False) -> str:
    """Return the key of a topic's messages, or of a service's calls.

    Args:
        resource: the topic or service.
        old_keys: whether the bridges are older than March 2025.
    """
    namespace = "" if old_keys else f"{resource.namespace}/"
    return f"{resource.type.encode().hex()}/{resource.md5sum}/{namespace}{resource.name[1:]}"


def beacon_key(resource: Resource) -> str:
    """Return the key of the beacons that announce a topic or service."""
    kind, type_name = resource.kind.value, resource.type.encode().hex()
    return f"{BEACON_ROOT}*/{kind}/{type_name}/{resource.md5sum}/{resource.namespace}/{resource.name[1:]}"


def beacon_patterns(namespaces: Iterable[str]) -> list[str]:
    """Return the key expressions that match the beacons of all bridges in these namespaces, and of those without one;
    ``*`` stands for all namespaces.
    """
    found = {*namespaces}
    return [f"{BEACON_ROOT}*/*/*/*/{namespace}/*/**" for namespace in sorted({ANY} if ANY in found else found)]


def is_source(key: str) -> bool:
    """Return whether a beacon announces a publisher or a service, rather than a subscriber or client."""
    return key.split("/", 3)[2:3] in ([Kind.PUBLISHER.value], [Kind.SERVICE.value])


def parse_beacon_key(key: str) -> Resource | None:
    """Return the resource that a beacon announces; None if the key is not a beacon's, or the resource is unusable."""
    parts = key.removeprefix(BEACON_ROOT).split("/", 5)
    if len(parts) != 6:
        return None
    _, kind, type_hex, md5sum, namespace, name = parts
    try:
        resource = Resource(Kind(kind), bytes.fromhex(type_hex).decode(), md5sum, namespace, f"/{name}")
    except ValueError:
        return None
    # Accept only the canonical spelling, so that a resource has one key: fromhex also accepts spaces and capitals.
    return resource if is_usable(resource) and beacon_key(resource) == key else None
