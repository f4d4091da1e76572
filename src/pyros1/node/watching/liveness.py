"""The state of a watched node, as a state machine without clocks and sockets.

A node is *unseen* until it responds for the first time, then *found*, and *lost* when

* its port is closed, because it has exited or was killed (reported immediately);
* it does not respond for ``limit`` seconds, because it hangs, is stopped, or its machine or the network is down;
* another process responds, or the master reports another address for it: the node was replaced, which is reported as
  lost and found.

A lost node that responds again is found. As long as a node responds, it does not matter whether the master responds or
(still) knows the node: stock nodes do not register again with a restarted master.
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
    """A change of the state of a watched node.

    Attributes:
        name: the node's full name.
        alive: True if the node was found, False if it was lost.
        reason: why the node is considered found or lost.
        silent: seconds since the node's last response; 0 if it was found.
        uri: URI of the node's slave API.
        pid: the node's process id; None if the node does not report it.
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
    """A watched node. All times are monotonic, in seconds.

    Args:
        name: the node's full name.
        limit: seconds without a response after which the node is considered lost.

    Attributes:
        state: its current state.
        uri: URI of its slave API; empty until the master has reported it.
    """

    def __init__(self, name: str, limit: float) -> None:
        self.name = name
        self.state = State.UNSEEN
        self.uri = ""
        self._limit = limit
        self._pid: int | None = None
        self._last_response_at = 0.0
        self._failing_since: float | None = None

    def remaining_time(self, now: float) -> float:
        """Return the timeout in seconds for a request sent now."""
        if self.state is not State.FOUND or self._failing_since is None:
            return self._limit
        return max(0.0, self._failing_since + self._limit - now)

    def is_new_process(self, pid: int | None) -> bool:
        """Return whether process ``pid``, which has responded, is a different process from the one that was found."""
        return self.state is State.UNSEEN or pid != self._pid

    def on_address(self, uri: str, now: float) -> list[Sighting]:
        """Process the address that the master reports for the node; return the resulting changes."""
        if uri == self.uri:
            return []
        changes = self._mark_lost(f"replaced by a node of the same name at {uri}", now)
        self.uri = uri
        self._pid = None
        return changes

    def on_response(self, pid: int | None, now: float) -> list[Sighting]:
        """Process a response from the node at `uri`; return the resulting changes."""
        changes: list[Sighting] = []
        if self.state is State.FOUND and pid != self._pid:
            changes = self._mark_lost("replaced: another process answers in its place", now)
        is_same_process = self.state is State.LOST and self._pid == pid
        self._pid = pid
        self._last_response_at = now
        self._failing_since = None
        if self.state is not State.FOUND:
            self.state = State.FOUND
            changes.append(self._sighting("it answers again" if is_same_process else "it answers", 0.0))
        return changes

    def on_failure(self, reason: str, requested_at: float, now: float, is_port_closed: bool = False) -> list[Sighting]:
        """Process a failed request to the node at `uri`; return the resulting changes.

        Args:
            reason: why the request failed.
            requested_at: when the request was sent.
            now: the current time.
            is_port_closed: whether the node's machine reports that the port is closed.
        """
        if self._failing_since is None:
            self._failing_since = requested_at
        if is_port_closed:
            return self._mark_lost(f"its port is closed: it has exited ({reason})", now)
        # A timer may fire a few microseconds early.
        return self._mark_lost(reason, now) if now >= self._failing_since + self._limit - 1e-3 else []

    def ignore_failure(self) -> None:
        """Ignore the last failure: it says nothing about the node, since this process was suspended."""
        self._failing_since = None

    def _mark_lost(self, reason: str, now: float) -> list[Sighting]:
        self._failing_since = None
        if self.state is not State.FOUND:
            return []
        self.state = State.LOST
        return [self._sighting(reason, now - self._last_response_at)]

    def _sighting(self, reason: str, silent: float) -> Sighting:
        return Sighting(self.name, self.state is State.FOUND, reason, silent, self.uri, self._pid)
