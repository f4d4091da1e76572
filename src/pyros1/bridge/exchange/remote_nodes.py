"""The responding nodes of other sites that publish the topics this site requests. No I/O.

Each is represented here by a node with the same name in its site's namespace, which lives as long as the original, so
programs can watch it like any other node. A site names only nodes that respond to it, so no dead node is represented.
"""

from __future__ import annotations

from collections.abc import Sequence

from pyros1.bridge.exchange.actions import Action, RepresentNode
from pyros1.bridge.names import MAX_NAME_LENGTH
from pyros1.bridge.rules.rules import Rules

MAX_REPRESENTED = 200
"""Maximum total number of represented nodes of all other sites."""


class RemoteNodes:
    """The nodes of other sites that are represented here.

    Args:
        rules: this site's rules, which set each site's namespace.
    """

    def __init__(self, rules: Rules) -> None:
        self._rules = rules
        self._names: dict[str, dict[str, str]] = {}  # site -> name here -> name there

    def update(self, site: str, names: Sequence[str]) -> list[Action]:
        """Record which nodes of a site respond, and return the actions that follow."""
        known = self._names.get(site, {})
        if set(names) == set(known.values()):
            return []
        others = {local for each, nodes in self._names.items() if each != site for local in nodes}
        # Always in a namespace: otherwise a site could replace local nodes by giving its own nodes their names.
        prefix = self._rules.prefix(site) or f"/{site}"
        wanted = {
            prefix + name: name
            for name in names
            if len(prefix + name) <= MAX_NAME_LENGTH and prefix + name not in others
        }
        kept = {local: name for local, name in known.items() if local in wanted}
        new = [local for local in sorted(wanted) if local not in kept]
        new = new[: max(0, MAX_REPRESENTED - len(others) - len(kept))]
        self._names[site] = kept | {local: wanted[local] for local in new}
        if not self._names[site]:
            del self._names[site]
        actions: list[Action] = [RepresentNode(local, "", "") for local in known if local not in kept]
        return actions + [RepresentNode(local, site, wanted[local]) for local in new]

    def drop(self, site: str) -> list[Action]:
        """Return the actions that end the stand-ins for a site's nodes."""
        return self.update(site, ())

    def names(self, site: str) -> list[str]:
        """Return the local names of a site's nodes."""
        return sorted(self._names.get(site, ()))
