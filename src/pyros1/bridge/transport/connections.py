"""Who is connected to a router, and what it logs when that changes. No I/O."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple

from pyros1.bridge.names import SiteNameError, site_of_keys


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


class Connections:
    """The connections of a router.

    Args:
        allowed: the names in certificates of those who may do something; empty for all.
    """

    def __init__(self, allowed: Collection[str]) -> None:
        self._allowed = frozenset(allowed)
        self._open: frozenset[Connection] = frozenset()

    def update(self, connections: Iterable[Connection]) -> list[str]:
        """Return what to log now that there are these connections."""
        found = frozenset(connections)
        lines = [f"{_describe(each)} disconnected ({each.address})" for each in sorted(self._open - found)]
        lines += [self._welcome(each, found) for each in sorted(found - self._open)]
        self._open = found
        return lines

    def _welcome(self, new: Connection, found: frozenset[Connection]) -> str:
        text = f"{_describe(new)} connected ({new.address})"
        if self._allowed and new.certificate not in self._allowed:
            return f"WARNING: {text}: it is not named under `sites`, so it can neither send nor take anything"
        if new.certificate and any(new.certificate == each.certificate for each in found - {new}):
            # Usually, its earlier connection has broken unnoticed.
            return f"{text}; there is another connection with the same keys"
        return text


def _describe(connection: Connection) -> str:
    name = connection.certificate
    try:
        site = site_of_keys(name)
    except SiteNameError:
        return f"somebody with keys of {name[:60]!r}" if name else "somebody without keys"
    return f"site {site}" + f" (keys {name})" * (site != name)
