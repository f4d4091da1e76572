"""The state of a watched node, as a state machine. Pure.

A node is *unseen* until it answers for the first time, then *found*, and *lost* when it

* closed its port: it ended, or was killed (reported at once);
* did not answer for ``limit`` seconds: it hangs, is stopped, or its machine or the network is down;
* is another process, or the master gives another address for it: it was replaced, which counts as lost and found.

A lost node that answers again is found. For a node that answers, it does not matter if the master is silent or
does not know the node (any more): a new master does not know stock nodes.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class State(Enum):
    """The states of a watched node."""

    UNSEEN = "unseen"
    FOUND = "found"
    LOST = "lost"


class Sighting(NamedTuple):
    """News of a watched node.

    Attributes:
        name: its full name.
        alive: whether it was found, not lost.
        reason: how it was lost or found, in words.
        silent: seconds since its last answer; 0 if it was found.
        uri: of its slave API.
        pid: its process id; None if it does not report it.
    """

    name: str
    alive: bool
    reason: str
    silent: float
    uri: str
    pid: int | None

    def __str__(self) -> str:
        return f"{self.name} is {'found' if self.alive else 'lost'}: {self.reason}"


class WatchedNode:
    """A watched node. Times are monotonic, in seconds.

    Args:
        name: its full name.
        limit: seconds without an answer after which it counts as lost.

    Attributes:
        state: its current state.
        uri: of its slave API; empty until the master has given it.
    """

    def __init__(self, name: str, limit: float) -> None:
        self.name = name
        self.state = State.UNSEEN
        self.uri = ""
        self._limit = limit
        self._pid: int | None = None
        self._last_answer = 0.0
        self._failing_since: float | None = None

    def remaining_time(self, now: float) -> float:
        """Return the seconds that a request sent now may take."""
        if self.state is not State.FOUND or self._failing_since is None:
            return self._limit
        return max(0.0, self._failing_since + self._limit - now)

    def is_new(self, pid: int | None) -> bool:
        """Return whether an answer with that process id comes from a process that has not been found there yet."""
        return self.state is State.UNSEEN or pid != self._pid

    def looked_up(self, uri: str, now: float) -> list[Sighting]:
        """Handle the address that the master gives."""
        if uri == self.uri:
            return []
        news = self._mark_lost(f"replaced by a node of the same name at {uri}", now)
        self.uri = uri
        self._pid = None
        return news

    def answered(self, pid: int | None, now: float) -> list[Sighting]:
        """Handle an answer of the node at `uri`."""
        news: list[Sighting] = []
        if self.state is State.FOUND and pid != self._pid:
            news = self._mark_lost("replaced: another process answers in its place", now)
        came_back = self.state is State.LOST and self._pid == pid
        self._pid = pid
        self._last_answer = now
        self._failing_since = None
        if self.state is not State.FOUND:
            self.state = State.FOUND
            news.append(self._sighting("it answers again" if came_back else "it answers", 0.0))
        return news

    def failed(self, reason: str, asked_at: float, now: float, closed: bool = False) -> list[Sighting]:
        """Handle that the node at `uri` did not answer.

        Args:
            reason: in words.
            asked_at: when the request was sent.
            closed: whether its machine reports that the port is closed.
        """
        if self._failing_since is None:
            self._failing_since = asked_at
        if closed:
            return self._mark_lost(f"its port is closed: it has exited ({reason})", now)
        # A timer may fire some microseconds early.
        return self._mark_lost(reason, now) if now >= self._failing_since + self._limit - 1e-3 else []

    def stalled(self) -> None:
        """Handle that this process itself was suspended, so that the last failure means nothing."""
        self._failing_since = None

    def _mark_lost(self, reason: str, now: float) -> list[Sighting]:
        self._failing_since = None
        if self.state is not State.FOUND:
            return []
        self.state = State.LOST
        return [self._sighting(reason, now - self._last_answer)]

    def _sighting(self, reason: str, silent: float) -> Sighting:
        return Sighting(self.name, self.state is State.FOUND, reason, silent, self.uri, self._pid)
