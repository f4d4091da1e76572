"""One side of a bond (https://wiki.ros.org/bond): two processes that notice when the other one ends. No I/O.

Both publish a bond/Status on the same topic every second. The bond is formed when a status of the other side comes, and
breaks when that side says so, or is silent for `HEARTBEAT_TIMEOUT`.
"""

from __future__ import annotations

from enum import Enum, auto
from math import inf
from typing import Any

from pyros1.msgs.bond.msg import Constants, Status

CONNECT_TIMEOUT: float = Constants.DEFAULT_CONNECT_TIMEOUT
HEARTBEAT_TIMEOUT: float = Constants.DEFAULT_HEARTBEAT_TIMEOUT


class State(Enum):
    """The state of one side."""

    WAITING = auto()  # for the other side
    ALIVE = auto()
    ENDING = auto()  # this side has ended the bond, and tells the other one until that confirms it
    BROKEN = auto()


class Bond:
    """One side of a bond.

    Args:
        id: the bond's name, the same on both sides.
        instance_id: a name for this side.
        now: a monotonic time in seconds, as for the other methods.
        connect_timeout: how many seconds the other side may take to appear.
        heartbeat_timeout: how many seconds it may be silent; infinity for any time.

    Attributes:
        state: the state.
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
        """Take a bond/Status of anyone on the topic."""
        if status.id != self._id or status.instance_id in ("", self._instance_id):
            return
        if self.state is State.WAITING and status.active:
            self._other, self.state = status.instance_id, State.ALIVE
        if status.instance_id != self._other:  # the end of an earlier bond, or a third side
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
        """Do what is due, and return a status to publish if that is.

        To be called when a status came, after `end`, and when `next_time` has come.
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
        """When `tick` has something to do."""
        return min(self._next_status, self._deadline)
