"""The state of another site: whether it is present, since when, and how old its messages are. No I/O.

The states, and the transitions between them:

- *heard*: a packet came under the site's name. Recorded packets can be sent again, and the network can delay
  packets, so this proves nothing yet.
- *present*: it has answered a heartbeat that was sent after its current run (its *epoch*) was first heard, so the
  answer is not an echo from an earlier run. From now on its lists and messages are accepted if they carry this epoch.
- *lost*: no new answer came within the delay set by this site's rules. Its state is kept, since it may come back.

A lost site that answers again is present. A restarted site is first heard with a new epoch and becomes present with its
first answer; the state of its earlier run is then discarded. A lost site is forgotten after `FORGET_DELAY`, a site that
was only heard after `HEARD_DELAY`, and one that says goodbye at once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from typing import NamedTuple

from pyros1.bridge.exchange.clock_offset import ClockOffset
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.packets import Heartbeat, Tail
from pyros1.bridge.rules.rules import LOSS_DELAY

_PERIODS = 5
"""Number of heartbeats within the delay after which a site is lost. A heartbeat is answered by the other site's next
one, so even without packet loss the last answered heartbeat can be two periods and a round trip old.
"""
MIN_PERIOD = 0.2
"""Minimum seconds between heartbeats, even if another site asks for more."""
FORGET_DELAY = 60.0
"""Seconds after which a lost site is forgotten."""
HEARD_DELAY = 10.0
"""Seconds after which a site that was never present is forgotten: made-up names must not displace other sites for long.
"""
_ANSWER_PERIOD = 0.1
"""Minimum seconds between heartbeats in response to packets of a site that is not present yet, so that a flood of such
packets does not cause a flood of heartbeats."""
_NAMESAKE_TIME = 10.0
"""Seconds after which packets of a previous run cannot be merely delayed ones: two bridges must have the same name."""
_NAMESAKE_TURNS = 5
_SHARED_TIME = 60.0
"""Seconds for which the status reports two bridges with the same name after the last sign of them."""
_KEPT_RUNS = 64
"""Number of earlier runs that are remembered, to recognise their packets."""
_KEPT_HEARTBEATS = 64
"""Number of sent heartbeats that are remembered, to recognise their answers."""


class State(Enum):
    """The states of another site."""

    HEARD = "heard"
    PRESENT = "present"
    LOST = "lost"


class SiteStatus(NamedTuple):
    """The state of another site, for the status.

    Attributes:
        nodes: the names of its nodes on this site's master.
        is_slow: whether it gets separate packets, since it would delay other sites.
        is_shared: whether two bridges use its name.
    """

    name: str
    state: State
    round_trip: float | None
    nodes: list[str]
    is_slow: bool
    is_shared: bool


class _Candidate(NamedTuple):
    """A run of the site that has not yet proved to be the current one."""

    epoch: int
    first_heartbeat: int
    """Number of the first heartbeat sent after it was heard; only an answer to this or a later one counts."""


class Change(Enum):
    """The change that a heartbeat has caused."""

    NONE = "none"
    OUTDATED = "outdated"
    """None, since the heartbeat is a repetition, or was overtaken by a later one: what it says no longer holds."""
    STARTED = "started"
    """The site is present in a new run: discard the state of the earlier one."""
    RETURNED = "returned"
    """The site was lost, and responds again."""


class Peer:
    """Another site, as its packets describe it. All times are in seconds of this site's clock.

    Args:
        name: the other site's name.
        own_epoch: this site's epoch.
        numbers: the numbers of heartbeats; shared by all peers of a site. A run never reuses a number, not even for a
            peer it had forgotten, since the peer may remember the number.
        now: the current time.
        loss_delay: seconds after sending the last answered heartbeat until the site is lost.

    Attributes:
        state: its state.
        epoch: the number of its current run; 0 if it was never present.
        clock: the offset of its clock.
        answer_due: whether a heartbeat must be sent now.
        offer_wanted, request_wanted: the versions of its lists for us; 0 if unknown.
        offer_seen, request_seen, services_seen: the versions of our lists that it has; -1 for none.
        lost_at: when it was lost.
        alternates: whether the current run replaced one that was present, and had been current before: two bridges with
            the same name take turns.
        is_shared: whether two bridges have used this name within the last minute.
    """

    def __init__(
        self, name: str, own_epoch: int, numbers: Iterator[int], now: float, loss_delay: float = LOSS_DELAY
    ) -> None:
        self.name = name
        self.state = State.HEARD
        self.epoch = 0
        self.clock = ClockOffset()
        self.answer_due = False
        self.offer_wanted = self.request_wanted = 0
        self.offer_seen = self.request_seen = self.services_seen = -1
        self.lost_at = now
        self.alternates = self.is_shared = False
        self._own_epoch = own_epoch
        self._loss_delay = loss_delay
        self._period = self._their_period = max(MIN_PERIOD, loss_delay / _PERIODS)
        self._candidate: _Candidate | None = None
        self._heard_at = now
        self._answered_at = now  # when the newest heartbeat it has answered was sent
        self._sent: dict[int, float] = {}
        self._numbers = numbers
        self._last_number = 0
        self._heartbeat_sent_at = float("-inf")
        self._received: dict[
            int, tuple[int, float]
        ] = {}  # epoch -> number and arrival of the last heartbeat of that run
        self._former_epoch = 0  # the run before this one
        self._runs: deque[int] = deque(maxlen=_KEPT_RUNS)  # the epochs of all runs so far
        self._former_candidate = self._turns = 0
        self._started_at = now
        self._has_namesake = self._is_namesake_reported = False
        self._namesake_at = now

    @property
    def is_present(self) -> bool:
        """Whether the site is present."""
        return self.state is State.PRESENT

    def is_current(self, epoch: int, to_epoch: int) -> bool:
        """Return whether a packet is from the site's current run, and for our current run or for all sites."""
        return self.state is State.PRESENT and epoch == self.epoch and to_epoch in (0, self._own_epoch)

    def hear(self, epoch: int, now: float) -> None:
        """Handle the epoch of a packet that is not a valid answer, and so proves nothing."""
        if self.state is not State.LOST:
            self._heard_at = now
        if epoch and epoch == self._former_epoch and now - self._started_at >= _NAMESAKE_TIME:
            self._note_namesake(now)
        if epoch == self.epoch and self.state is State.PRESENT:
            return
        if self._candidate is None or self._candidate.epoch != epoch:
            self._note_turn(epoch, now)
            self._candidate = _Candidate(epoch, self._last_number + 1)
        self.answer_due = self.answer_due or now - self._heartbeat_sent_at >= _ANSWER_PERIOD

    def _note_turn(self, epoch: int, now: float) -> None:
        """Handle a packet of another run: if two runs alternate, two bridges have the same name."""
        self._turns = self._turns + 1 if epoch == self._former_candidate else 0
        self._former_candidate = self._candidate.epoch if self._candidate else 0
        if self._turns >= _NAMESAKE_TURNS:
            self._note_namesake(now)

    def _note_namesake(self, now: float) -> None:
        self._has_namesake = self.is_shared = True
        self._namesake_at = now

    def on_heartbeat(self, epoch: int, to_epoch: int, heartbeat: Heartbeat, now: float) -> Change:
        """Handle a heartbeat from the site, and return what it changes."""
        number, _ = self._received.get(epoch, (0, 0.0))
        if heartbeat.number <= number:
            return Change.OUTDATED
        is_answer = to_epoch == self._own_epoch and heartbeat.echo in self._sent
        if not is_answer or (epoch != self.epoch and not self._confirms(epoch, heartbeat.echo)):
            self.hear(epoch, now)
            self._note_arrival(epoch, heartbeat.number, now)
            return Change.NONE
        change = self._on_answer(epoch, heartbeat, now)
        self._note_arrival(epoch, heartbeat.number, now)
        return change

    def _note_arrival(self, epoch: int, number: int, now: float) -> None:
        runs = (self.epoch, self._candidate.epoch if self._candidate else 0)
        self._received = {run: last for run, last in self._received.items() if run in runs}
        if epoch in runs:
            self._received[epoch] = (number, now)

    def _confirms(self, epoch: int, echo: int) -> bool:
        """Return whether the answer to a heartbeat shows that this run of the site is the current one."""
        candidate = self._candidate
        return candidate is not None and candidate.epoch == epoch and echo >= candidate.first_heartbeat

    def _on_answer(self, epoch: int, heartbeat: Heartbeat, now: float) -> Change:
        change = Change.NONE
        if epoch != self.epoch:
            change = Change.STARTED
            if epoch in self._runs:
                self._note_namesake(now)
            self.alternates = self.state is State.PRESENT and epoch in self._runs
            if epoch not in self._runs:
                self._runs.append(epoch)
            self._former_epoch, self._started_at = self.epoch, now
            self.epoch = epoch
            self.clock = ClockOffset()
            self._answered_at = float("-inf")
            self.answer_due = True  # the other site may be waiting for our answer, too
        self._candidate = None
        sent_at = self._sent[heartbeat.echo]
        self._answered_at = max(self._answered_at, sent_at)
        self.clock.add(sent_at, now, heartbeat.sent_at, heartbeat.reply_delay)
        self.offer_wanted, self.request_wanted = heartbeat.offer, heartbeat.request
        self.offer_seen, self.request_seen = heartbeat.offer_seen, heartbeat.request_seen
        self.services_seen = heartbeat.services_seen
        self._their_period = heartbeat.period
        if self.state is not State.PRESENT and now - self._answered_at < self._loss_delay:
            if change is Change.NONE:
                change = Change.STARTED if self.state is State.HEARD else Change.RETURNED
            self.state = State.PRESENT
        return change

    def pop_namesake(self) -> bool:
        """Return whether two bridges have begun to use this name since the last call."""
        is_new = self._has_namesake and not self._is_namesake_reported
        self._is_namesake_reported = self._has_namesake
        return is_new

    def tick(self, now: float) -> bool:
        """Return whether the site has just been lost."""
        self.is_shared = self.is_shared and now - self._namesake_at < _SHARED_TIME
        if self.state is not State.PRESENT or now - self._answered_at < self._loss_delay:
            return False
        self.state, self.lost_at = State.LOST, now
        return True

    def is_forgotten(self, now: float) -> bool:
        """Return whether the site has been away for so long that its state can be discarded."""
        if self.state is State.PRESENT:
            return False
        if self.state is State.LOST:
            return now - self.lost_at >= FORGET_DELAY
        return now - self._heard_at >= HEARD_DELAY

    def wants_heartbeat(self, now: float) -> bool:
        """Return whether a heartbeat is due now: both sites use the shorter of their periods."""
        period = max(MIN_PERIOD, min(self._period, self._their_period if self.is_present else self._period))
        return self.answer_due or now - self._heartbeat_sent_at >= period

    def make_heartbeat(
        self,
        now: float,
        offer: int,
        request: int,
        seen: tuple[int, int],
        tails: Mapping[SharedName, Tail],
        services: tuple[int, int] = (0, -1),
        nodes: Sequence[str] = (),
        is_separate: bool = False,
    ) -> tuple[int, Heartbeat]:
        """Return the epoch of the run that the next heartbeat is for, and the heartbeat.

        Args:
            now: the current time.
            offer, request: the versions of our lists for it.
            seen: the versions of its lists that we have; -1 for none.
            tails, nodes, is_separate: see `Heartbeat`.
            services: the version of our list of services for it, and the version of its list that we have.
        """
        number = self._last_number = next(self._numbers)
        self._sent[number] = now
        if len(self._sent) > _KEPT_HEARTBEATS:
            del self._sent[min(self._sent)]
        # A packet of another run may be old: one heartbeat goes to that run, the others keep the current one alive.
        asks = self._candidate is not None and (self.answer_due or self.state is not State.PRESENT)
        epoch = self._candidate.epoch if asks and self._candidate else self.epoch
        self._heartbeat_sent_at, self.answer_due = now, False
        echo, arrived_at = self._received.get(epoch, (0, now))
        reply_delay, versions = now - arrived_at, (offer, request, *seen)
        return epoch, Heartbeat(
            number, now, echo, reply_delay, *versions, tails, *services, self._period, nodes, is_separate
        )
