"""The responding nodes of other sites that publish the topics this site requests. No I/O.

Each is represented here by a node with the same name in its site's namespace, which lives as long as the original, so
programs can watch it like any other node. A site names only nodes that respond to it, so no dead node is represented.

Each of them costs threads and calls of the master here. So sites share the room for them fairly, and cannot make nodes
come and go without end; but a node that is no longer named ends at once, since others may depend on it.
"""

from __future__ import annotations

from collections.abc import Sequence

from pyros1.bridge.exchange.actions import Action, Log, RepresentNode
from pyros1.bridge.exchange.token_bucket import TokenBucket
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
        self._names: dict[str, dict[str, str]] = {}  # site -> name here -> name there, in order of arrival
        self._incomplete: set[str] = set()  # sites some of whose nodes are not represented, which has been logged

    def update(self, site: str, names: Sequence[str], starts: TokenBucket, now: float) -> list[Action]:
        """Record which nodes of a site respond, and return the actions that follow.

        Args:
            site: the site.
            names: the nodes.
            starts: limits how many nodes of this site begin to be represented; the others wait for a later call.
            now: the current time in seconds.
        """
        known = self._names.get(site, {})
        if set(names) == set(known.values()):
            self._incomplete.discard(site)
            return []
        others = {local for each, nodes in self._names.items() if each != site for local in nodes}
        # Always in a namespace: otherwise a site could replace local nodes by giving its own nodes their names.
        prefix = self._rules.prefix(site) or f"/{site}"
        wanted = {
            prefix + name: name
            for name in names
            if len(prefix + name) <= MAX_NAME_LENGTH and prefix + name not in others
        }
        nodes = self._names[site] = {local: name for local, name in known.items() if local in wanted}
        actions: list[Action] = [RepresentNode(local, "", "") for local in known if local not in nodes]
        for local in sorted(wanted.keys() - nodes.keys()):
            largest = self._largest_if_full()
            if (largest is not None and len(largest) <= len(nodes) + 1) or not starts.take(now):
                break
            if largest is not None:
                actions.append(RepresentNode(largest.popitem()[0], "", ""))
            nodes[local] = wanted[local]
            actions.append(RepresentNode(local, site, wanted[local]))
        return actions + self._warn(site, len(nodes) < len({*names}))

    def _warn(self, site: str, is_incomplete: bool) -> list[Action]:
        """Return a warning if some of a site's nodes are not represented, unless this has been logged."""
        was_incomplete = site in self._incomplete
        (self._incomplete.add if is_incomplete else self._incomplete.discard)(site)
        if was_incomplete or not is_incomplete:
            return []
        text = "there are too many, they change too often, or their names here are taken or too long"
        return [Log(f"some nodes of site {site} cannot be watched here: {text}", is_warning=True)]

    def _largest_if_full(self) -> dict[str, str] | None:
        """Return the nodes of the site with the most if no more can be represented, so that it gives up its newest one
        for a site with fewer; None if there is room.
        """
        if sum(map(len, self._names.values())) < MAX_REPRESENTED:
            return None
        return max(self._names.values(), key=len)

    def drop(self, site: str) -> list[Action]:
        """Return the actions that end the stand-ins for a site's nodes."""
        self._incomplete.discard(site)
        return [RepresentNode(local, "", "") for local in self._names.pop(site, ())]

    def names(self, site: str) -> list[str]:
        """Return the local names of a site's nodes."""
        return sorted(self._names.get(site, ()))
