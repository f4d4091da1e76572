"""The connections of a router or bridge, and what it logs when they change."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from typing import Any, NamedTuple

from pyros1.bridge.names import SiteNameError, site_of_key_name


class Connection(NamedTuple):
    """A connection.

    Attributes:
        zid: zenoh's random name of the program at the other end.
        certificate: the name in its certificate; empty if it has none.
        address: the other end, such as ``10.0.0.2:51234``.
    """

    zid: str
    certificate: str
    address: str


class Event(NamedTuple):
    """A log message about a connection."""

    text: str
    is_warning: bool


class Connections:
    """The connections of a router or a bridge.

    Args:
        allowed: the certificate names that have any permissions; empty for all.
    """

    def __init__(self, allowed: Collection[str]) -> None:
        self._allowed = frozenset(allowed)
        self._open: frozenset[Connection] = frozenset()

    def update(self, connections: Iterable[Connection]) -> list[Event]:
        """Return the messages to log, given the current connections."""
        found = frozenset(connections)
        events = [
            Event(f"{_describe(each)} disconnected ({each.address})", False) for each in sorted(self._open - found)
        ]
        events += [self._connected_event(each, found) for each in sorted(found - self._open)]
        self._open = found
        return events

    def _connected_event(self, new: Connection, found: frozenset[Connection]) -> Event:
        text = f"{_describe(new)} connected ({new.address})"
        if self._allowed and new.certificate not in self._allowed:
            return Event(f"{text}: it is not named under `sites`, so it can neither send nor receive anything", True)
        if new.certificate and any(new.certificate == each.certificate for each in found - {new}):
            # Usually its earlier connection broke without being noticed.
            text += "; there is another connection with the same keys"
        return Event(text, False)


def _describe(connection: Connection) -> str:
    name = connection.certificate
    try:
        site = site_of_key_name(name)
    except SiteNameError:
        return f"somebody with keys of {name[:60]!r}" if name else "somebody without keys"
    return f"site {site}" + f" (keys {name})" * (site != name)


def session_connections(session: Any) -> list[Connection]:
    """Return the connections of a zenoh session; none if this version of zenoh cannot tell."""
    links = getattr(session.info, "links", None)
    if links is None:
        return []
    return [Connection(str(link.zid), link.auth_identifier or "", _address(link.dst)) for link in links()]


def _address(endpoint: str) -> str:
    """Return the address of an endpoint; IPv4-mapped IPv6 addresses are written as IPv4."""
    return re.sub(r"\[::ffff:([\d.]+)\]", r"\1", endpoint.partition("/")[2])
