"""Flow control: limits the bytes in transit to other sites, so urgent packets do not wait behind bulky ones. No I/O.

A slow network queues packets where priorities have no effect. So some bulky packets are followed by a *probe* of the
same priority, which its receivers answer at once. At most a window of bytes is sent beyond the last probe that all
receivers have answered. While at least half of it is used, the window grows if answers are nearly as fast as the
fastest so far. It shrinks if they take longer, because packets are then queueing on the way. All times are in seconds.

A probe costs each side as much as a message. So on fast networks, where nearly everything is confirmed at once, probes
are sent only every `_CALM_PERIOD` or half window, whichever comes first, instead of every quarter of a window.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from itertools import count

FIRST_WINDOW = 64 << 10
SMALLEST_WINDOW = 8 << 10
LARGEST_WINDOW = 16 << 20
QUEUE_TIME = 0.08
"""Seconds by which an answer may exceed the fastest one plus a round trip before the window shrinks. The additional
round trip allows for resending a lost packet, which does not indicate a queue.
"""
PATIENCE = 2.0
"""Seconds to wait for an answer."""
SLOW_COUNT = 3
SLOW_TIME = 20.0
"""A site is slow if its answers alone made the window shrink `SLOW_COUNT` times within `SLOW_TIME` seconds."""
_CALM_PERIOD = 0.15
"""Seconds between probes while nearly everything is confirmed at once."""
_FIRST_PERIOD = 1.0
"""Minimum seconds between probes after the first packet following a pause."""
_LOSS_ROUND_TRIPS = 3
_LONGER_WAY_COUNT = 3
_CAREFUL_GROWTH = 0.1
"""The fraction of the confirmed bytes by which the window grows once it has been too large."""


class _Probe:
    """A probe that some sites have not answered.

    Attributes:
        awaited: the sites that have not answered; None until its receivers are known.
        in_time: the sites that have answered in time.
        late: the other sites, each with the time that its answer took; infinite if there was none.
    """

    def __init__(self, sent_at: float, total: int) -> None:
        self.sent_at = sent_at
        self.total = total
        self.awaited: set[str] | None = None
        self.in_time: set[str] = set()
        self.late: dict[str, float] = {}


class Pacer:
    """Decides when bulky packets may be sent to one site, or to several that get the same packets.

    Args:
        numbers: yields the numbers of the next probes; None to count from 1.

    Attributes:
        window: maximum number of unconfirmed bytes.
    """

    def __init__(self, numbers: Iterator[int] | None = None) -> None:
        self.window = float(FIRST_WINDOW)
        self._numbers = count(1) if numbers is None else numbers
        self._probes: dict[int, _Probe] = {}
        self._sent = 0  # total bytes
        self._arrived = 0
        self._probed = 0
        self._calm_bytes = 0.0  # sent per `_CALM_PERIOD`; 0 unless nearly all are confirmed at once
        self._best: dict[str, float] = {}  # site -> the shortest time of an answer
        self._round_trips: dict[str, float] = {}
        self._growth = 1.0  # the fraction of the confirmed bytes by which the window grows; 1 doubles it per round trip
        self._probed_at = self._used_at = self._shrunk_at = self._confirmed_at = float("-inf")
        self._late_alone: dict[str, deque[float]] = {}  # site -> when its answers alone made the window shrink
        self._slow: list[str] = []
        self._late_at_smallest = 0
        self._late_at: float | None = None  # when answers began to be late

    @property
    def is_idle(self) -> bool:
        """Whether everything that was sent has been confirmed."""
        return not self._probes

    @property
    def unconfirmed_bytes(self) -> int:
        """Number of bytes that have not been confirmed."""
        return self._sent - self._arrived

    @property
    def is_calm(self) -> bool:
        """Whether nearly everything is confirmed at once."""
        return self._calm_bytes > 0

    def may_send(self, now: float) -> bool:
        """Return whether a packet of any size may be sent now: large ones may exceed the window."""
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
        """Record that a packet is being sent; return the number of the probe to send after it, if one is due."""
        self._sent += size
        if self._sent - self._arrived >= self.window / 2:
            self._used_at = now
        is_first = not self._probes and now - self._probed_at >= _FIRST_PERIOD  # no earlier packets can delay it
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
            sites: the sites, each with the shortest of its last round trips (of small packets).
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
        """Stop waiting for answers from a site that gets separate packets from now on."""
        self._late_alone.pop(site, None)
        for number, probe in [*self._probes.items()]:
            if probe.awaited is not None and number in self._probes:
                probe.awaited.discard(site)
                if not probe.awaited:
                    self._finish(number)
        self._growth = 1.0  # the others may be much faster

    def pop_slow(self) -> list[str]:
        """Return the sites that delay others; each is returned once."""
        slow, self._slow = self._slow, []
        return slow

    def _complete(self, number: int, probe: _Probe, now: float) -> None:
        """Adjust the window to the answers to a probe."""
        if not probe.late:
            self._late_at_smallest, self._late_at = 0, None
            if self._used_at >= probe.sent_at:  # a hardly used window says nothing about a larger one
                self.window = min(LARGEST_WINDOW, self.window + (probe.total - self._arrived) * self._growth)
            is_calm = self._sent - probe.total < self.window / 4
            took = probe.sent_at - self._confirmed_at
            self._calm_bytes = (probe.total - self._arrived) / max(took, 1e-6) * _CALM_PERIOD if is_calm else 0.0
        elif self._late_at is None and self._may_be_loss(probe):
            self._calm_bytes = 0.0
            self._late_at = now  # wait for the next probe: a queue persists, a loss does not
        elif probe.sent_at >= (self._late_at or self._shrunk_at):  # earlier probes met the same queue
            self._growth, self._calm_bytes = _CAREFUL_GROWTH, 0.0
            self._raise_best_time(probe)
            self.window = max(SMALLEST_WINDOW, self.window / 2)
            self._shrunk_at, self._late_at = now, None
            self._note_late(probe, now)
        self._finish(number)

    def _time_limit(self, site: str) -> float:
        """Return how long an answer may take before it counts as late."""
        round_trip = self._round_trips.get(site, 0.0)
        return max(self._best.get(site, 0.0), round_trip) + round_trip + QUEUE_TIME

    def _may_be_loss(self, probe: _Probe) -> bool:
        """Return whether answers may be late because packets were lost and sent again, perhaps more than once."""
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
            self._late_alone.clear()  # no site answered in time: the whole network is slow, not single sites
        for site in probe.late if probe.in_time else ():
            times = self._late_alone.setdefault(site, deque(maxlen=SLOW_COUNT))
            times.append(now)
            if len(times) == SLOW_COUNT and now - times[0] <= SLOW_TIME:
                self._slow.append(site)
                times.clear()

    def _finish(self, number: int) -> None:
        """Mark everything up to a probe as arrived."""
        self._arrived = max(self._arrived, self._probes[number].total)
        self._confirmed_at = max(self._confirmed_at, self._probes[number].sent_at)
        for earlier in [each for each in self._probes if each <= number]:
            del self._probes[earlier]
