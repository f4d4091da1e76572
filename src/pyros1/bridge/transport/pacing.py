"""How much may be on its way to other sites, so that what is urgent does not wait behind what is bulky. No I/O.

A slow network queues what it is given, in places that no priority reaches. So some bulky packets are followed by a
*probe* of the same priority, which the sites that get it answer at once. Not more than a window of bytes is sent beyond
the last probe that all have answered. The window grows as long as answers come nearly as fast as they ever did, and
shrinks when they take longer, since then packets queue on the way. All times are in seconds.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import count

FIRST_WINDOW = 64 << 10
SMALLEST_WINDOW = 8 << 10
LARGEST_WINDOW = 16 << 20
QUEUE_TIME = 0.08
"""How much longer than at best an answer may take, before the window shrinks."""
PATIENCE = 2.0
"""Time after which an answer is not waited for any longer."""
IGNORE_TIME = 30.0
"""Time for which a site that does not answer is left out: it must not slow down what others get."""


_CAREFUL_GROWTH = 0.1
"""By which part of what is confirmed the window grows once it has been too large."""


class _Probe:
    def __init__(self, sent_at: float, total: int) -> None:
        self.sent_at = sent_at
        self.total = total
        self.awaited: set[str] | None = None  # None until it is known who gets it


class Pacing:
    """Decides when bulky packets may be sent.

    Attributes:
        window: the number of bytes that may be on their way.
    """

    def __init__(self) -> None:
        self.window = float(FIRST_WINDOW)
        self._numbers = count(1)
        self._probes: dict[int, _Probe] = {}
        self._sent = 0  # bytes so far
        self._arrived = 0
        self._probed = 0
        self._best = float("inf")
        self._growth = 1.0  # of what is confirmed; so the window doubles with each round trip until it is too large
        self._ignored_until: dict[str, float] = {}

    def may_send(self, now: float) -> bool:
        """Return whether a packet may be sent now; of any size, so that large ones are possible."""
        for number, probe in list(self._probes.items()):
            if now - probe.sent_at <= PATIENCE:
                break
            self._ignored_until.update(dict.fromkeys(probe.awaited or (), now + IGNORE_TIME))
            self.window = max(SMALLEST_WINDOW, self.window / 2)
            self._finish(number)
        return self._sent - self._arrived < self.window or not self._probes

    def on_sent(self, size: int, now: float) -> int | None:
        """Note that a packet is being sent; return the number of the probe to send after it, if there must be one."""
        self._sent += size
        if self._sent - self._probed < self.window / 4:
            return None
        self._probed = self._sent
        number = next(self._numbers)
        self._probes[number] = _Probe(now, self._sent)
        return number

    def on_probe_reply(self, number: int, sites: Iterable[str], now: float) -> None:
        """Note to which sites a probe is sent."""
        probe = self._probes.get(number)
        if probe is not None:
            probe.awaited = {site for site in sites if self._ignored_until.get(site, now) <= now}
            if not probe.awaited:
                self._finish(number)

    def on_answer(self, site: str, number: int, now: float) -> None:
        """Note that a site has answered a probe."""
        probe = self._probes.get(number)
        if probe is None or not probe.awaited or site not in probe.awaited:
            return
        probe.awaited.remove(site)
        if probe.awaited:
            return
        took = now - probe.sent_at
        self._best = min(took, self._best * 1.001)  # the way may have become longer
        most = self._best + QUEUE_TIME
        if took <= most:
            self.window = min(LARGEST_WINDOW, self.window + (probe.total - self._arrived) * self._growth)
        else:
            self._growth = _CAREFUL_GROWTH
            self.window = max(SMALLEST_WINDOW, self.window * max(0.5, most / took))
        self._finish(number)

    def _finish(self, number: int) -> None:
        """Count everything up to a probe as arrived."""
        self._arrived = max(self._arrived, self._probes[number].total)
        for earlier in [each for each in self._probes if each <= number]:
            del self._probes[earlier]
