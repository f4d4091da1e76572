"""Names between sites, and the patterns that match them.

A *shared name* such as ``red:/odom`` consists of the site that owns the topic, and the topic's name on that site's
master. A name without a site in a site's rules is its own: ``/odom`` in red's rules is ``red:/odom``.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from pyros1.ground.errors import Error
from pyros1.ground.names import is_legal_name

MAX_NAME_LENGTH = 255
"""Maximum number of characters of a topic's name."""
_SITE = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}\Z")
_KEYS_NUMBER = re.compile(r"[1-9][0-9]{0,3}\Z")
_CHUNK = re.compile(r"[A-Za-z0-9_*]+\Z", re.ASCII)


class SiteNameError(Error, ValueError):
    """A site's name, a shared name or a pattern is invalid."""


class SharedName(NamedTuple):
    """A topic's name between sites.

    Attributes:
        site: the site that owns the topic.
        name: the topic's full name on that site's master.
    """

    site: str
    name: str

    def __str__(self) -> str:
        return f"{self.site}:{self.name}"


def is_site_name(name: str) -> bool:
    """Return whether a site can have this name: a letter followed by at most 39 letters, digits and underscores."""
    return _SITE.match(name) is not None


def check_site_name(name: str) -> str:
    """Return a valid site name unchanged.

    Raises:
        SiteNameError: it is not a letter followed by at most 39 letters, digits and underscores.
    """
    if not _SITE.match(name):
        raise SiteNameError(
            f"{name!r} cannot be a site's name: use a letter, then up to 39 letters, digits and underscores"
        )
    return name


def site_of_key_name(name: str) -> str:
    """Return the site to which keys with a name belong. ``red`` and ``red-2`` are keys of site ``red``: newer keys have
    a new name so that the old ones can be shut out.

    Raises:
        SiteNameError: keys cannot have this name.
    """
    site, dash, number = name.partition("-")
    if not _SITE.match(site) or (dash and not _KEYS_NUMBER.match(number)):
        raise SiteNameError(
            f"{name!r:.80} cannot be a site's name: use a letter, then up to 39 letters, digits and underscores; newer "
            "keys of a site have a number after its name, such as red-2"
        )
    return site


def is_topic_name(name: str) -> bool:
    """Return whether a topic with this name can be shared: the name is a full one, legal, and not too long."""
    return len(name) <= MAX_NAME_LENGTH and len(name) > 1 and name[0] == "/" and name[-1] != "/" and is_legal_name(name)


def parse_shared_name(text: str) -> SharedName:
    """Parse a shared name such as ``red:/odom``.

    Raises:
        SiteNameError: the text is not a shared name.
    """
    site, colon, name = text.partition(":")
    if not (colon and _SITE.match(site) and is_topic_name(name)):
        raise SiteNameError(f"{text!r:.80} is not a site and a topic, such as red:/odom")
    return SharedName(site, name)


class Pattern:
    """A pattern of shared names: ``/odom``, ``/camera/**``, ``red:/cmd_vel``, ``red:**`` or ``*:/odom``.

    In topic names, ``*`` stands for any text without a slash, and ``/**`` at the end, or ``**`` between slashes, for
    any number of parts.

    Args:
        text: the pattern.

    Attributes:
        site: the site; empty for the site that the pattern belongs to, ``*`` for all other sites.
        path: the pattern for topic names, which begins with a slash.

    Raises:
        SiteNameError: the text is not a pattern.
    """

    __slots__ = ("_parts", "path", "site", "text")

    def __init__(self, text: str) -> None:
        site, colon, path = text.rpartition(":")
        if path == "**":
            path = "/**"
        self.text = text
        self.site = site
        self.path = path
        chunks = path.split("/")
        if colon and site != "*":
            check_site_name(site)
        if len(text) > MAX_NAME_LENGTH or not path.startswith("/") or not all(_is_chunk(part) for part in chunks[1:]):
            raise SiteNameError(
                f"{text!r:.80} is not a pattern of topics: write /odom, /camera/**, red:/cmd_vel, red:** or *:/odom"
            )
        self._parts = chunks[1:]

    @property
    def is_literal(self) -> bool:
        """Whether the pattern matches only one topic name."""
        return "*" not in self.path

    @property
    def subtree(self) -> str | None:
        """For a pattern such as ``/camera/**``, the part before ``/**``; None for other patterns."""
        base = self.path.removesuffix("/**")
        return base if base != self.path and "*" not in base else None

    def matches_name(self, name: str) -> bool:
        """Return whether the pattern matches a topic's name, ignoring the site."""
        # On a mismatch, only the last ** needs to match one more part, so the time is never exponential.
        parts, chunks = self._parts, name.split("/")[1:]
        part = chunk = received = 0
        last = -1
        while chunk < len(chunks):
            if part < len(parts) and parts[part] == "**":
                last, received = part, chunk
                part += 1
            elif part < len(parts) and _matches_chunk(parts[part], chunks[chunk]):
                part += 1
                chunk += 1
            elif last >= 0:
                received += 1
                part, chunk = last + 1, received
            else:
                return False
        return all(each == "**" for each in parts[part:])

    def matches(self, shared: SharedName, own_site: str) -> bool:
        """Return whether the pattern matches a shared name.

        Args:
            shared: the name.
            own_site: the site whose rules contain the pattern.
        """
        is_site = shared.site != own_site if self.site == "*" else shared.site == (self.site or own_site)
        return is_site and self.matches_name(shared.name)

    def __repr__(self) -> str:
        return f"Pattern({self.text!r})"


def _is_chunk(text: str) -> bool:
    return _CHUNK.match(text) is not None and ("**" not in text or text == "**")


def _matches_chunk(pattern: str, text: str) -> bool:
    """Return whether a part of a name matches a pattern, in which ``*`` stands for any text."""
    first, *others = pattern.split("*")
    if not others:
        return pattern == text
    last = others.pop()
    if len(text) < len(first) + len(last) or not (text.startswith(first) and text.endswith(last)):
        return False
    position, end = len(first), len(text) - len(last)
    for piece in others:  # the leftmost match leaves most for the others
        position = text.find(piece, position, end)
        if position < 0:
            return False
        position += len(piece)
    return True
