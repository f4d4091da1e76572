"""Watches the local nodes whose topics other sites request, since a killed node stays registered with the master."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Iterable
from itertools import islice

from pyros1.bridge.names import is_topic_name
from pyros1.node import Node
from pyros1.node.watching.liveness import Sighting
from pyros1.node.watching.watch import Watch

MAX_WATCHED = 200
"""Maximum number of watched nodes, each asked several times per loss delay; others count as alive as long as they are
registered.
"""
_PERIODS = 5
_MAX_PERIOD = 0.5


class PublisherWatch:
    """Watches the local nodes whose topics other sites want.

    Args:
        node: the bridge's node.
        loss_delay: seconds without a response after which a node is lost; one that exits is lost at once.
        on_change: called when a node is found or lost, in a separate thread.
    """

    def __init__(self, node: Node, loss_delay: float, on_change: Callable[[], object]) -> None:
        self._node = node
        self._period = min(_MAX_PERIOD, loss_delay / _PERIODS)
        self._limit = loss_delay - self._period
        self._on_change = on_change
        self._watches: dict[str, Watch] = {}
        self._names: set[str] = set()  # watched nodes; a node may be found before `watch` returns
        self._lock = threading.Lock()
        self._responding: frozenset[str] = frozenset()
        self._lost: frozenset[str] = frozenset()

    @property
    def responding(self) -> frozenset[str]:
        """The watched nodes that respond."""
        return self._responding

    @property
    def lost(self) -> frozenset[str]:
        """The watched nodes that have responded before, and no longer do."""
        return self._lost

    def update(self, wanted: Iterable[str], registered: Collection[str]) -> None:
        """Set the nodes to watch.

        Args:
            wanted: the nodes that publish topics other sites want. A master accepts any names, but nodes whose names
                are not legal cannot be watched, or named to other sites.
            registered: the nodes that the master knows. Watched nodes stay watched as long as they are among these,
                since otherwise a lost one would count as found.
        """
        for name in [name for name in self._watches if name not in registered]:
            self._watches.pop(name).close()  # a callback may be running
            with self._lock:
                self._names.discard(name)
                self._note(name, None)
        new = [name for name in wanted if name not in self._watches and is_topic_name(name)]
        for name in islice(new, max(0, MAX_WATCHED - len(self._watches))):
            with self._lock:
                self._names.add(name)
            self._watches[name] = self._node.watch(
                name, self._on_sighting, self._on_sighting, period=self._period, limit=self._limit
            )

    def _on_sighting(self, sighting: Sighting) -> None:
        name, responds = sighting.name, sighting.alive
        with self._lock:
            if name not in self._names:
                return
            self._note(name, responds)
        self._on_change()

    def _note(self, name: str, responds: bool | None) -> None:
        """Record whether a node responds; None if it is no longer watched. Called with the lock held."""
        self._responding = self._responding | {name} if responds else self._responding - {name}
        self._lost = self._lost | {name} if responds is False else self._lost - {name}

    def close(self) -> None:
        """Stop watching."""
        self.update((), ())
