"""The keys under which sites exchange packets.

Each key that a site writes begins with ``pyros1/1/SITE/``, so that a router can restrict a certificate to its own
site's keys. The rest tells the kind of packet:

- ``hello``: for all sites: there is a site with this name;
- ``to/PEER``: for one site: heartbeats, offers, requests, definitions;
- ``t/OWNER/NAME``: messages of the topic OWNER:/NAME, for all sites that want it;
- ``again/PEER/OWNER/NAME``: messages of that topic for one site: missed ones, latched ones, and all messages of a topic
  that a router must keep from other sites;
- ``call/PEER/OWNER/NAME``: calls to the service OWNER:/NAME and their replies, for one site.

``1`` is the version of the protocol: sites with different versions do not hear each other.
"""

from __future__ import annotations

from enum import Enum
from functools import lru_cache
from typing import NamedTuple

from pyros1.bridge.names import SharedName, is_site_name, is_topic_name

ROOT = "pyros1/1"
HELLO = "hello"


class Channel(Enum):
    """The kind of packets that a key carries."""

    HELLO = "hello"
    TO = "to"
    TOPIC = "t"
    DIRECT = "again"
    CALL = "call"


class Key(NamedTuple):
    """A parsed key: its sender, channel, receiver (empty for all sites) and topic or service, if it has them."""

    site: str
    channel: Channel
    receiver: str = ""
    topic: SharedName | None = None


def site_key(site: str, key: str) -> str:
    """Return the complete key for a key below a site's prefix."""
    return f"{ROOT}/{site}/{key}"


def peer_key(peer: str) -> str:
    """Return the key for packets to one site."""
    return f"to/{peer}"


def topic_key(topic: SharedName) -> str:
    """Return the key for a topic's messages."""
    return f"t/{topic.site}{topic.name}"


def direct_topic_key(peer: str, topic: SharedName) -> str:
    """Return the key for a topic's messages to one site only."""
    return f"again/{peer}/{topic.site}{topic.name}"


def path_key(path: str) -> str:
    """Return the zenoh key expression that matches the same topic names as a pattern such as ``/camera/**`` or
    ``/cam*/image``.
    """
    parts: list[str] = []
    for part in path.split("/"):
        before = parts[-1:] == ["**"]
        if before and part == "**":
            continue
        if before and part == "*":
            parts.insert(-1, part)  # zenoh accepts only this order
        else:
            parts.append(part if part in ("*", "**") else part.replace("*", "$*"))
    return "/".join(parts)


def call_key(peer: str, service: SharedName) -> str:
    """Return the key for a service's calls or replies to one site."""
    return f"call/{peer}/{service.site}{service.name}"


def receiver_of(key: str) -> str:
    """Return the site to which packets with a key below a site's prefix go; empty for all sites."""
    channel, _, rest = key.partition("/")
    return rest.partition("/")[0] if channel in ("to", "again", "call") else ""


@lru_cache(4096)
def parse_key(text: str) -> Key | None:
    """Parse a key; return None if it is invalid."""
    site, _, rest = text[len(ROOT) + 1 :].partition("/")
    # In zenoh, a key may also contain wildcards.
    if not text.startswith(ROOT + "/") or len(text) > 500 or not is_site_name(site):
        return None
    channel, _, rest = rest.partition("/")
    if channel == HELLO and not rest:
        return Key(site, Channel.HELLO)
    if channel == "to" and rest and "/" not in rest:
        return Key(site, Channel.TO, rest)
    receiver = ""
    if channel in ("again", "call"):
        receiver, _, rest = rest.partition("/")
    elif channel != "t":
        return None
    owner, slash, name = rest.partition("/")
    if not ((receiver or channel == "t") and is_site_name(owner) and is_topic_name(slash + name)):
        return None
    return Key(site, Channel(channel), receiver, SharedName(owner, slash + name))
