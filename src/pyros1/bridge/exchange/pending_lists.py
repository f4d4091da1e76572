"""Pending lists of other sites: applying one takes a few milliseconds, so their rate is limited.

Only the newest list of each kind is kept. No I/O.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pyros1.bridge.exchange.token_bucket import TokenBucket
from pyros1.bridge.protocol.packets import Kind

_RATE = 1.0
"""Number of lists of one kind from one site that are applied per second."""
_BURST = 3
"""Number of lists applied at once after a pause: topics often come and go together."""


class PendingLists:
    """The pending lists of one other site."""

    def __init__(self) -> None:
        self._pending: dict[Kind, Sequence[Any]] = {}
        self._buckets = {kind: TokenBucket(_RATE, _BURST) for kind in (Kind.OFFER, Kind.REQUEST, Kind.SERVICES)}

    def put(self, kind: Kind, entries: Sequence[Any]) -> None:
        """Keep a received list."""
        self._pending[kind] = entries

    def take(self, now: float) -> list[tuple[Kind, Sequence[Any]]]:
        """Remove and return the lists to apply now."""
        kinds = [kind for kind in self._pending if self._buckets[kind].take(now)]
        return [(kind, self._pending.pop(kind)) for kind in kinds]

    def clear(self) -> None:
        """Forget the waiting lists, since the site is gone or has restarted."""
        self._pending.clear()
