"""Flow control: limits the bytes in transit to other sites, so urgent packets do not wait behind bulky ones. No I/O.

A slow network queues packets in places where priorities have no effect. So some bulky packets are followed by a
*probe* of the same priority, which the sites that get it answer at once. Not more than a window of bytes is sent beyond
the last probe that all have answered. The window grows as long as it is used and answers come nearly as fast as they
ever did, and shrinks when they take longer, since then packets queue on the way. All times are in seconds.

A probe costs each side as much as a message. So where nearly everything is confirmed at once, there are fewer: not one
in a quarter of the window, but one in a short time, at least one in half the window.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from itertools import count

FIRST_WINDOW = 64 << 10
SMALLEST_WINDOW = 8 << 10
LARGEST_WINDOW = 16 << 20
QUEUE_TIME = 0.08
"""How much longer than at best, by more than a round trip, an answer may take before the window shrinks. A round trip
more, since it takes that time to send a packet again that was lost: that is no queue."""
PATIENCE = 2.0
"""Time after which an answer is not waited for any longer."""
SLOW_COUNT = 3
SLOW_TIME = 20.0
"""A site is slow if its answers alone made the window shrink this many times within this time."""
_CALM_PERIOD = 0.15
"""Seconds between probes where nearly everything is confirmed at once."""
_FIRST_PERIOD = 1.0
"""Seconds between probes that follow the first packet after a pause."""
_LOSS_ROUND_TRIPS = 3
_LONGER_WAY_COUNT = 3
_CAREFUL_GROWTH = 0.1
"""The fraction of the confirmed bytes by which the window grows once it has been too large."""


class _Probe:
    """A probe that some sites have not answered.

    Attributes:
        awaited: the sites that have not answered; None until it is known who gets it.
        in_time: the sites that have answered in time.
        late: the sites that have not, each with the time that its answer took; infinite if it was given up.
    """

    def __init__(self, sent_at: float, total: int) -> None:
        self.sent_at = sent_at
        self.total = total
        self.awaited: set[str] | None = None
        self.in_time: set[str] = set()
        self.late: dict[str, float] = {}


class Pacer:
    """Decides when bulky packets may be sent to one site, or to several that get the same.

    Args:
        numbers: the numbers of the next probes.

    Attributes:
        window: the number of bytes that may be on their way.
    """

    def __init__(self, numbers: Iterator[int] | None = None) -> None:
        self.window = float(FIRST_WINDOW)
        self._numbers = count(1) if numbers is None else numbers
        self._probes: dict[int, _Probe] = {}
        self._sent = 0  # bytes so far
        self._arrived = 0
        self._probed = 0
        self._calm_bytes = 0.0  # how much is sent in `_CALM_PERIOD`; 0 if it is not confirmed at once
        self._best: dict[str, float] = {}  # site -> the shortest time of an answer
        self._round_trips: dict[str, float] = {}
        self._growth = 1.0  # of what is confirmed; so the window doubles with each round trip until it is too large
        self._probed_at = self._used_at = self._shrunk_at = self._confirmed_at = float("-inf")
        self._late_alone: dict[str, deque[float]] = {}  # site -> when it alone has made the window shrink
        self._slow: list[str] = []
        self._late_at_smallest = 0
        self._late_at: float | None = None  # when an answer came late for the first time, after one in time

    @property
    def is_idle(self) -> bool:
        """Whether everything that was sent has been confirmed."""
        return not self._probes

    @property
    def unconfirmed_bytes(self) -> int:
        """How many bytes may still be on their way."""
        return self._sent - self._arrived

    @property
    def is_calm(self) -> bool:
        """Whether nearly everything is confirmed at once."""
        return self._calm_bytes > 0

    def may_send(self, now: float) -> bool:
        """Return whether a packet may be sent now; of any size, so that large ones are possible."""
        if not self._probes:
            return True
        for number, probe in [*self._probes.items()]:
            if now - probe.sent_at <= PATIENCE:
                break
            if number in self._probes:
                probe.late.update(dict.fromkeys(probe.awaited or (), float("inf")))
                self._complete(number, probe, now)
        return self._sent - self._arrived < self.window or not self._probes

    def on_sent(self, size: int, now: float) -> int | None:
        """Record that a packet is being sent; return the number of the probe to send after it, if there must be one."""
        self._sent += size
        if self._sent - self._arrived >= self.window / 2:
            self._used_at = now
        is_first = not self._probes and now - self._probed_at >= _FIRST_PERIOD  # it meets no queue of ours
        enough = min(self.window / 2, max(self.window / 4, self._calm_bytes))
        if self._sent - self._probed < enough and not is_first:
            return None
        self._probed, self._probed_at = self._sent, now
        number = next(self._numbers)
        self._probes[number] = _Probe(now, self._sent)
        return number

    def on_probe_sent(self, number: int, sites: Mapping[str, float]) -> None:
        """Record to which sites a probe is sent.

        Args:
            number: the probe's number.
            sites: the sites, each with the shortest one of its last round trips, of small packets.
        """
        self._round_trips.update(sites)
        probe = self._probes.get(number)
        if probe is not None:
            probe.awaited = {*sites}
            if not probe.awaited:
                self._finish(number)

    def on_answer(self, site: str, number: int, now: float) -> None:
        """Record that a site has answered a probe."""
        probe = self._probes.get(number)
        if probe is None or not probe.awaited or site not in probe.awaited:
            return
        took = now - probe.sent_at
        self._best[site] = min(took, self._best.get(site, took))
        if took > self._time_limit(site):
            probe.late[site] = took
        else:
            probe.in_time.add(site)
        probe.awaited.remove(site)
        if not probe.awaited:
            self._complete(number, probe, now)

    def remove(self, site: str) -> None:
        """Stop waiting for answers of a site: it gets other packets from now on."""
        self._late_alone.pop(site, None)
        for number, probe in [*self._probes.items()]:
            if probe.awaited is not None and number in self._probes:
                probe.awaited.discard(site)
                if not probe.awaited:
                    self._finish(number)
        self._growth = 1.0  # the others may be much faster

    def pop_slow(self) -> list[str]:
        """Return the sites that hold up others; each is returned once."""
        slow, self._slow = self._slow, []
        return slow

    def _complete(self, number: int, probe: _Probe, now: float) -> None:
        """Adjust the window to the answers to a probe."""
        if not probe.late:
            self._late_at_smallest, self._late_at = 0, None
            if self._used_at >= probe.sent_at:  # otherwise nobody knows whether a larger one is possible
                self.window = min(LARGEST_WINDOW, self.window + (probe.total - self._arrived) * self._growth)
            is_calm = self._sent - probe.total < self.window / 4
            took = probe.sent_at - self._confirmed_at
            self._calm_bytes = (probe.total - self._arrived) / max(took, 1e-6) * _CALM_PERIOD if is_calm else 0.0
        elif self._late_at is None and self._may_be_loss(probe):
            self._calm_bytes = 0.0
            self._late_at = now  # a queue stays
        elif probe.sent_at >= (self._late_at or self._shrunk_at):  # what was sent before has met the same queue
            self._growth, self._calm_bytes = _CAREFUL_GROWTH, 0.0
            self._raise_best_time(probe)
            self.window = max(SMALLEST_WINDOW, self.window / 2)
            self._shrunk_at, self._late_at = now, None
            self._note_late(probe, now)
        self._finish(number)

    def _time_limit(self, site: str) -> float:
        """Return how long an answer may take."""
        round_trip = self._round_trips.get(site, 0.0)
        return max(self._best.get(site, 0.0), round_trip) + round_trip + QUEUE_TIME

    def _may_be_loss(self, probe: _Probe) -> bool:
        """Return whether answers are perhaps late since packets were lost, even more than once, and sent again."""
        return all(
            took < self._best.get(site, 0.0) + _LOSS_ROUND_TRIPS * self._round_trips.get(site, 0.0)
            for site, took in probe.late.items()
        )

    def _raise_best_time(self, probe: _Probe) -> None:
        """Raise the best round trip if answers are late although hardly anything is in transit."""
        self._late_at_smallest = self._late_at_smallest + 1 if self.window == SMALLEST_WINDOW else 0
        if self._late_at_smallest >= _LONGER_WAY_COUNT:
            self._best.update({site: took for site, took in probe.late.items() if took < PATIENCE})
            self._late_at_smallest, self._growth = 0, 1.0

    def _note_late(self, probe: _Probe, now: float) -> None:
        if not probe.in_time:
            self._late_alone.clear()  # it is the network of all of them
        for site in probe.late if probe.in_time else ():
            times = self._late_alone.setdefault(site, deque(maxlen=SLOW_COUNT))
            times.append(now)
            if len(times) == SLOW_COUNT and now - times[0] <= SLOW_TIME:
                self._slow.append(site)
                times.clear()

    def _finish(self, number: int) -> None:
        """Count everything up to a probe as arrived."""
        self._arrived = max(self._arrived, self._probes[number].total)
        self._confirmed_at = max(self._confirmed_at, self._probes[number].sent_at)
        for earlier in [each for each in self._probes if each <= number]:
            del self._probes[earlier]
