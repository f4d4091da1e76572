"""Rate limits for the requests of each other site. No I/O."""

from __future__ import annotations

from collections.abc import Container

from pyros1.bridge.exchange.pending_lists import PendingLists
from pyros1.bridge.exchange.token_bucket import TokenBucket
from pyros1.bridge.protocol.packets import MAX_NODES

_PROBE_RATE = 500
_PROBE_BURST = 100
"""Maximum number of a site's probes that are answered, per second and in one burst; others are dropped, as if lost."""
_DEFINITION_RATE = 50e3
_DEFINITION_BURST = 2e6
"""Maximum bytes of a site's definitions that are read, per second and in one burst: a thousand bytes take about a
millisecond. A robot's types all fit into the burst, and definitions that were not read are requested again.
"""
_SEPARATE_RATE = 1.0
_SEPARATE_BURST = 3
"""Number of times that a site may change whether it sends separate packets, per second and in one burst: each change
affects all topics that are received from it.
"""
_NODE_RATE = 1
_NODE_BURST = MAX_NODES
"""Maximum number of a site's nodes that begin to be represented here, per second and in one burst."""
_MAX_SITES = 1_000


class SiteLimits:
    """The rate limits of one site.

    Attributes:
        lists: the lists that wait to be applied.
        probes: limits how many probes are answered.
        definitions: limits how many bytes of definitions are read.
        separate: limits how often the site may change whether it sends separate packets.
        nodes: limits how many of its nodes begin to be represented here.
    """

    def __init__(self) -> None:
        self.lists = PendingLists()
        self.probes = TokenBucket(_PROBE_RATE, _PROBE_BURST)
        self.definitions = TokenBucket(_DEFINITION_RATE, _DEFINITION_BURST)
        self.separate = TokenBucket(_SEPARATE_RATE, _SEPARATE_BURST)
        self.nodes = TokenBucket(_NODE_RATE, _NODE_BURST)


class Limits:
    """The limits of all sites. They outlive a run of a site, so reconnecting does not reset them."""

    def __init__(self) -> None:
        self._sites: dict[str, SiteLimits] = {}

    def of(self, site: str, known: Container[str]) -> SiteLimits:
        """Return the limits of a site.

        Args:
            site: the site.
            known: the sites that are known now; if limits are kept for too many sites, those of all others are
                forgotten.
        """
        limits = self._sites.get(site)
        if limits is None:
            if len(self._sites) >= _MAX_SITES:
                self._sites = {name: limits for name, limits in self._sites.items() if name in known}
            limits = self._sites[site] = SiteLimits()
        return limits
