"""One side of a bond (https://wiki.ros.org/bond), by which two processes notice when the other one exits. No I/O.

Both publish a bond/Status on the same topic every second. The bond is formed when a status from the other side arrives,
and breaks when that side ends it, or is silent for `HEARTBEAT_TIMEOUT`.
"""

from __future__ import annotations

from enum import Enum, auto
from math import inf
from typing import Any

from pyros1.msgs.bond.msg import Constants, Status

CONNECT_TIMEOUT: float = Constants.DEFAULT_CONNECT_TIMEOUT
HEARTBEAT_TIMEOUT: float = Constants.DEFAULT_HEARTBEAT_TIMEOUT


class State(Enum):
    """The state of one side of a bond."""

    WAITING = auto()  # waiting for the other side
    ALIVE = auto()
    ENDING = auto()  # this side has ended the bond, and tells the other side until it confirms
    BROKEN = auto()


class Bond:
    """One side of a bond.

    Args:
        id: the bond's name, the same on both sides.
        instance_id: a name for this side.
        now: a monotonic time in seconds, as in the other methods.
        connect_timeout: how many seconds the other side may take to appear.
        heartbeat_timeout: how many seconds the other side may be silent; infinity for no limit.

    Attributes:
        state: the state of this side.
    """

    def __init__(
        self,
        id: str,
        instance_id: str,
        now: float,
        connect_timeout: float = CONNECT_TIMEOUT,
        heartbeat_timeout: float = HEARTBEAT_TIMEOUT,
    ) -> None:
        self.state = State.WAITING
        self._id, self._instance_id = id, instance_id
        self._other = ""
        self._heartbeat_timeout = heartbeat_timeout
        self._deadline = now + connect_timeout
        self._next_status = now

    def receive(self, status: Any, now: float) -> None:
        """Handle any bond/Status received on the topic."""
        if status.id != self._id or status.instance_id in ("", self._instance_id):
            return
        if self.state is State.WAITING and status.active:
            self._other, self.state = status.instance_id, State.ALIVE
        if status.instance_id != self._other:  # from an earlier bond, or a third process
            return
        if self.state is State.ALIVE and status.active:
            self._deadline = now + self._heartbeat_timeout
        elif not status.active and self.state is not State.BROKEN:
            self.state, self._deadline = State.BROKEN, inf
            self._next_status = now  # to confirm it

    def end(self, now: float) -> None:
        """End the bond from this side."""
        if self.state is State.ALIVE:
            self.state, self._deadline = State.ENDING, now + Constants.DEFAULT_DISCONNECT_TIMEOUT
        elif self.state is State.WAITING:
            self.state, self._deadline = State.BROKEN, inf
        self._next_status = now

    def tick(self, now: float) -> Status | None:
        """Check the timeouts, and return a status if one must be published now.

        To be called after `receive`, after `end`, and at `next_time`.
        """
        if now >= self._deadline and self.state is not State.BROKEN:
            self.state, self._deadline = State.BROKEN, inf
            self._next_status = now
        if now < self._next_status:
            return None
        period = {State.ENDING: Constants.DEAD_PUBLISH_PERIOD, State.BROKEN: inf}
        self._next_status = now + period.get(self.state, Constants.DEFAULT_HEARTBEAT_PERIOD)
        return Status(
            id=self._id,
            instance_id=self._instance_id,
            active=self.state in (State.WAITING, State.ALIVE),
            heartbeat_timeout=min(self._heartbeat_timeout, 1e9),
            heartbeat_period=Constants.DEFAULT_HEARTBEAT_PERIOD,
        )

    @property
    def next_time(self) -> float:
        """The time at which to call `tick` next."""
        return min(self._next_status, self._deadline)
