"""What a site knows of another one: whether it is there, since when, and how old its messages are. No I/O.

The states, and what leads from one to the next:

- *heard*: a packet came under the site's name. Whoever records packets can send them again, and the network can delay
  them, so nothing is believed yet.
- *present*: it has answered a beat that was sent to it after this run of it (its *epoch*) was first heard of, so it is
  not an echo of an earlier run. From now on its lists and messages count, if they carry this epoch.
- *lost*: no new answer came for `LOSS_DELAY`. What is known of it is kept, since it may come back.

A lost site that answers again is present. One that has started again is heard under another epoch, and becomes present
under that one as soon as it has answered; then everything that was known of its earlier run is void. A lost site that
does not come back within `FORGET_DELAY`, and one that says goodbye, is forgotten.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import Enum
from typing import NamedTuple

from pyros1.bridge.clock_offset import ClockOffset
from pyros1.bridge.names import SharedName
from pyros1.bridge.packets import Beat

BEAT_PERIOD = 1.0
"""Seconds between beats."""
LOSS_DELAY = 5.0
"""Seconds after the sending of the last beat that was answered, until the site is lost. The next beat brings the
answer, so even without losses this time grows to two periods and a round trip."""
FORGET_DELAY = 60.0
"""Seconds after which a lost site is forgotten."""
_ANSWER_PERIOD = 0.1
"""Minimum seconds between beats that answer packets of a site that is not present yet, so that they cannot be used to
make this site send without end."""
_KEPT_BEATS = 64
"""Number of sent beats whose answers are recognised."""


class State(Enum):
    """The states of another site."""

    HEARD = "heard"
    PRESENT = "present"
    LOST = "lost"


class _Candidate(NamedTuple):
    """A run of the site that has not shown yet that it is running now."""

    epoch: int
    first_beat: int
    """The number of the first beat that was sent after it was heard; only an answer to this or a later one counts."""


class Change(Enum):
    """What a beat has changed."""

    NONE = "none"
    STARTED = "started"
    """The site is present in a new run: what was known of an earlier one is void."""
    RETURNED = "returned"


class Peer:
    """Another site, as its packets describe it. All times are in seconds of this site's clock.

    Args:
        name: the other site's name.
        own_epoch: this site's epoch.
        numbers: the numbers of beats; shared by all peers of a site. A run never uses a number twice, not even for a
            peer that it has forgotten meanwhile, since the other side may remember it.
        now: the current time.

    Attributes:
        state: its state.
        epoch: its current run; 0 if it was never present.
        clock: the offset of its clock.
        answer_due: whether a beat must be sent now.
        offer_wanted, wish_wanted: the versions of its lists for us; 0 if it has not said.
        offer_seen, wish_seen: the versions of our lists that it has; -1 for none.
        lost_at: when it was lost.
    """

    def __init__(self, name: str, own_epoch: int, numbers: Iterator[int], now: float) -> None:
        self.name = name
        self.state = State.HEARD
        self.epoch = 0
        self.clock = ClockOffset()
        self.answer_due = False
        self.offer_wanted = self.wish_wanted = 0
        self.offer_seen = self.wish_seen = -1
        self.lost_at = now
        self._own_epoch = own_epoch
        self._candidate: _Candidate | None = None
        self._heard_at = now
        self._answered_at = now  # when the newest beat that it has answered was sent
        self._sent: dict[int, float] = {}
        self._numbers = numbers
        self._last_number = 0
        self._beat_sent_at = float("-inf")
        self._received: dict[int, tuple[int, float]] = {}  # epoch -> number and arrival of the last beat of that run

    @property
    def is_present(self) -> bool:
        """Whether the site is present."""
        return self.state is State.PRESENT

    def is_current(self, epoch: int, to_epoch: int) -> bool:
        """Return whether a packet is from the present run of the site, and for this run of ours, or for all sites."""
        return self.state is State.PRESENT and epoch == self.epoch and to_epoch in (0, self._own_epoch)

    def hear(self, epoch: int, now: float) -> None:
        """Note that a packet with an epoch came; this alone proves nothing."""
        if self.state is not State.LOST:
            self._heard_at = now
        if epoch == self.epoch and self.state is State.PRESENT:
            return
        if self._candidate is None or self._candidate.epoch != epoch:
            self._candidate = _Candidate(epoch, self._last_number + 1)
        self.answer_due = self.answer_due or now - self._beat_sent_at >= _ANSWER_PERIOD

    def on_beat(self, epoch: int, to_epoch: int, beat: Beat, now: float) -> Change:
        """Note a beat from the site, and return what it changes."""
        number, _ = self._received.get(epoch, (0, 0.0))
        if beat.number <= number:
            return Change.NONE  # repeated, or overtaken by a later one
        is_answer = to_epoch == self._own_epoch and beat.echo in self._sent
        if not is_answer or (epoch != self.epoch and not self._proves(epoch, beat.echo)):
            self.hear(epoch, now)
            self._note_arrival(epoch, beat.number, now)
            return Change.NONE
        change = self._on_answer(epoch, beat, now)
        self._note_arrival(epoch, beat.number, now)
        return change

    def _note_arrival(self, epoch: int, number: int, now: float) -> None:
        runs = (self.epoch, self._candidate.epoch if self._candidate else 0)
        self._received = {run: last for run, last in self._received.items() if run in runs}
        if epoch in runs:
            self._received[epoch] = (number, now)

    def _proves(self, epoch: int, echo: int) -> bool:
        """Return whether the answer to a beat shows that a run of the site is the current one."""
        candidate = self._candidate
        return candidate is not None and candidate.epoch == epoch and echo >= candidate.first_beat

    def _on_answer(self, epoch: int, beat: Beat, now: float) -> Change:
        change = Change.NONE
        if epoch != self.epoch:
            change = Change.STARTED
            self.epoch = epoch
            self.clock = ClockOffset()
            self._answered_at = float("-inf")
            self.answer_due = True  # it may wait for an answer of ours, too
        self._candidate = None
        sent_at = self._sent[beat.echo]
        self._answered_at = max(self._answered_at, sent_at)
        self.clock.add(sent_at, now, beat.sent_at, beat.held)
        self.offer_wanted, self.wish_wanted = beat.offer, beat.wish
        self.offer_seen, self.wish_seen = beat.offer_seen, beat.wish_seen
        if self.state is not State.PRESENT and now - self._answered_at < LOSS_DELAY:
            if change is Change.NONE:
                change = Change.STARTED if self.state is State.HEARD else Change.RETURNED
            self.state = State.PRESENT
        return change

    def tick(self, now: float) -> bool:
        """Return whether the site is lost now, and was not before."""
        if self.state is not State.PRESENT or now - self._answered_at < LOSS_DELAY:
            return False
        self.state, self.lost_at = State.LOST, now
        return True

    def is_forgotten(self, now: float) -> bool:
        """Return whether the site has been away for so long that nothing needs to be kept of it."""
        if self.state is State.PRESENT:
            return False
        since = self.lost_at if self.state is State.LOST else self._heard_at
        return now - since >= FORGET_DELAY

    def wants_beat(self, now: float) -> bool:
        """Return whether a beat must be sent to the site now."""
        return self.answer_due or now - self._beat_sent_at >= BEAT_PERIOD

    def make_beat(
        self, now: float, offer: int, wish: int, seen: tuple[int, int], tails: Mapping[SharedName, int]
    ) -> tuple[int, Beat]:
        """Return the next beat to the site, after the epoch of the run that it is for.

        Args:
            now: the current time.
            offer, wish: the versions of our lists for it.
            seen: the versions of its lists that we have; -1 for none.
            tails: see `Beat`.
        """
        number = self._last_number = next(self._numbers)
        self._sent[number] = now
        if len(self._sent) > _KEPT_BEATS:
            del self._sent[min(self._sent)]
        # A packet of another run may be old: one beat asks that run, the others keep up what there is.
        asks = self._candidate is not None and (self.answer_due or self.state is not State.PRESENT)
        epoch = self._candidate.epoch if asks and self._candidate else self.epoch
        self._beat_sent_at, self.answer_due = now, False
        echo, arrived_at = self._received.get(epoch, (0, now))
        return epoch, Beat(number, now, echo, now - arrived_at, offer, wish, *seen, tails)
