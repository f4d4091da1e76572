"""Sends separate packets to slow sites, so that they do not hold up the others. No I/O.

Heartbeats tell a slow site to stop listening to the packets for all sites. After some time it shares packets with the
others again, since its network may have improved; whenever it turns out to be slow again, the time doubles.
"""

from __future__ import annotations

from collections.abc import Container

FIRST_TIME = 30.0
LONGEST_TIME = 900.0
"""The initial and the maximum number of seconds for which a slow site gets its own packets."""
OVERLAP = 2.0
"""Seconds for which a site still gets its own packets after it was told to listen to the common ones, since switching
takes some time.
"""


class _SlowSite:
    def __init__(self) -> None:
        self.duration = FIRST_TIME / 2
        self.until = 0.0


class SlowSites:
    """The sites that the sender has found to be slow."""

    def __init__(self) -> None:
        self._sites: dict[str, _SlowSite] = {}
        self._separate: dict[str, _SlowSite] = {}

    @property
    def separate(self) -> frozenset[str]:
        """The sites that get their own packets."""
        return frozenset(self._separate)

    def is_flagged(self, site: str, now: float) -> bool:
        """Return whether heartbeats tell a site that it gets its own packets."""
        found = self._separate.get(site)
        return found is not None and now < found.until

    def add(self, site: str, now: float) -> None:
        """Record that a site is slow; nothing changes if it is already known to be."""
        found = self._sites.setdefault(site, _SlowSite())
        if not self.is_flagged(site, now):
            found.duration = min(LONGEST_TIME, 2 * found.duration)
            found.until = now + found.duration
            self._separate[site] = found

    def tick(self, now: float, known: Container[str]) -> bool:
        """Let sites share packets with the others again once their time is over, and forget sites that are not known.

        Returns:
            Whether any site shares packets with others again, or was forgotten.
        """
        self._sites = {name: site for name, site in self._sites.items() if name in known}
        before = len(self._separate)
        self._separate = {
            name: site for name, site in self._separate.items() if name in known and now < site.until + OVERLAP
        }
        return len(self._separate) < before
