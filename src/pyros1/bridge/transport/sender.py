"""Sends packets over the link: immediately while nothing waits, since a thread switch would double the cost; otherwise
in threads that may block on the network, one for urgent packets and subscriptions, one for other packets.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable
from functools import partial
from time import monotonic

from pyros1.bridge.exchange.actions import Probe, Send
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.lanes import Lanes, ProbeDue
from pyros1.bridge.transport.link import Link

MakeProbes = Callable[[str, int, Priority], list[Probe]]
_PACING_PERIOD = 0.1
"""Seconds between checks for missing answers."""
_DIRECT_TIME = 0.0005
"""Seconds that sending a packet immediately may take. If two packets in succession take longer, or one takes much
longer, the network is saturated; a single one may have waited for the processor on a busy machine.
"""
_LONG_DIRECT_TIME = 0.02
_DIRECT_PAUSE = 0.1
_LONGEST_PAUSE = 300.0
_PAUSE_FACTOR = 100
"""Seconds for which the thread sends all packets after a slow immediate send, so that slow sends do not block the
callers of `put`: the minimum, the maximum, and the number of seconds per second that the slow send took, so that
callers lose at most a hundredth of their time.
"""
FLUSH_TIME = 0.5
"""Maximum seconds that closing waits for queued packets to be sent."""


def _make_none(*_: object) -> list[Probe]:
    return []


class SendingThread:
    """A thread that sends packets that cannot be sent immediately, in order of priority.

    Args:
        name: the thread's name.
        link: where to send them.
        clock: returns the site's time in seconds.
        on_error: called with an exception that sending has raised.
        make_probes: returns the probes to send after a packet, see `pyros1.bridge.transport.pacer`; called with the
            site that gets the packet (an empty string for all sites) and the probe's number and priority, in the thread
            that puts a packet or in this one. None for a thread that does not wait for answers.
        on_slow: called with a site that holds up others.
    """

    def __init__(
        self,
        name: str,
        link: Link,
        clock: Callable[[], float],
        on_error: Callable[[Exception], object],
        make_probes: MakeProbes | None = None,
        on_slow: Callable[[str], object] = lambda _: None,
    ) -> None:
        self.lanes = Lanes(is_paced=make_probes is not None)
        self._make_probes = make_probes or _make_none
        self._on_slow = on_slow
        self._tasks: deque[Callable[[], object]] = deque()
        # Site and key, see `Link.listen` -> whether to listen, and since when this waits. Only the last change counts.
        self._listens: dict[tuple[str, str], tuple[bool, float]] = {}
        self._link = link
        self._clock = clock
        self._on_error = on_error
        self._lock = threading.Lock()
        self._changed = threading.Condition(self._lock)
        self._is_closing = False
        self._is_flushing = False
        self._is_sending = False
        self._direct_from = float("-inf")
        self._was_slow = False  # whether the last immediately sent packet took long
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def put(self, packet: Send) -> None:
        """Send a packet immediately, or queue it for the thread."""
        now = self._clock()
        with self._lock:
            if self._is_closing:
                return
            lane = None
            is_busy = self._is_sending or self._tasks or self._listens
            if not is_busy and now >= self._direct_from:
                lane = self.lanes.lane_if_idle(packet, now)
            if lane is None:
                self.lanes.put(packet, now)
                if not self._is_sending:  # the sending thread checks the queue again
                    self._changed.notify()
                return
            self._is_sending = True
            probe = self.lanes.on_sent(lane, packet, now)
        self._send_directly(packet, probe, now)

    def _send_directly(self, packet: Send, probe: ProbeDue | None, start: float) -> None:
        try:
            try:
                self._transmit_directly(packet)
                if probe is not None:
                    self._send_probes(probe, packet.priority, self._transmit_directly)
            except Exception as error:  # noqa: BLE001 - the link's library has errors of its own
                self._on_error(error)
        finally:
            end = self._clock()
            with self._lock:
                took = end - start
                if took > _LONG_DIRECT_TIME or (took > _DIRECT_TIME and self._was_slow):
                    self._direct_from = end + min(_LONGEST_PAUSE, max(_DIRECT_PAUSE, _PAUSE_FACTOR * took))
                self._was_slow = took > _DIRECT_TIME
                self._is_sending = False
                if self._tasks or self._listens or not self.lanes.is_empty or self._is_flushing:
                    self._changed.notify_all()

    def _transmit_directly(self, packet: Send) -> None:
        if self._tasks or not self._link.try_send(packet):
            self._tasks.append(partial(self._link.send, packet))

    def listen(self, site: str, key: str, on: bool) -> None:
        """Receive what another site sends on a key, or stop. Later packets wait for this, except urgent ones."""
        with self._lock:
            if not self._is_closing:
                _, since = self._listens.get((site, key), (on, self._clock()))
                self._listens[site, key] = on, since
                self._changed.notify()

    def _run(self) -> None:
        while (task := self._next()) is not None:
            try:
                task()
            except Exception as error:  # noqa: BLE001 - the link's library has errors of its own
                self._on_error(error)
            with self._lock:
                self._is_sending = False
                if self._is_flushing:
                    self._changed.notify_all()

    def _next(self) -> Callable[[], object] | None:
        """Wait for something to do, and return it; None if the thread closes."""
        with self._lock:
            while not self._is_closing:
                task = None if self._is_sending else self._pop()
                if task is not None:
                    self._is_sending = True
                    return task
                self._changed.wait(None if self.lanes.is_empty else _PACING_PERIOD)
        return None

    def _pop(self) -> Callable[[], object] | None:
        """Return the next thing to do; None if there is nothing, or everything must wait."""
        self._note_slow()
        if self._tasks:
            return self._tasks.popleft()
        oldest = next(iter(self._listens), None)
        before = math.inf if oldest is None else self._listens[oldest][1]
        if (popped := self.lanes.pop(self._clock(), before)) is not None:
            return partial(self._send, *popped)
        return None if oldest is None else partial(self._link.listen, *oldest, self._listens.pop(oldest)[0])

    def _send(self, lane: str, packet: Send) -> None:
        self._link.send(packet)
        with self._lock:
            probe = self.lanes.on_sent(lane, packet, self._clock())
        if probe is not None:
            self._send_probes(probe, packet.priority, self._link.send)

    def _send_probes(self, probe: ProbeDue, priority: Priority, transmit: Callable[[Send], object]) -> None:
        probes = self._make_probes(probe.lane, probe.number, priority)
        with self._lock:
            self.lanes.on_probe_sent(probe, {each.site: each.round_trip for each in probes})
        for each in probes:
            transmit(each.packet)

    def on_probe_reply(self, site: str, number: int) -> None:
        """Record that a site has answered a probe."""
        with self._lock:
            self.lanes.on_answer(site, number, self._clock())
            self._note_slow()
            if not self._is_sending and (self._tasks or not self.lanes.is_empty):
                self._changed.notify()

    def _note_slow(self) -> None:
        self._tasks.extend(partial(self._on_slow, site) for site in self.lanes.pop_slow())

    @property
    def _has_work(self) -> bool:
        return self._is_sending or bool(self._tasks) or not self.lanes.is_empty

    def close(self) -> None:
        """Send the queued packets, for at most `FLUSH_TIME`, and end the thread."""
        deadline = monotonic() + FLUSH_TIME
        with self._lock:
            self._is_flushing = True
            while self._has_work and (left := deadline - monotonic()) > 0:
                self._changed.wait(left)
            self._is_closing = True
            self._changed.notify_all()
        self._thread.join(FLUSH_TIME)


class Sender:
    """Sends packets in two threads, so that bulky packets waiting for the network do not delay heartbeats and commands.

    Args:
        link, clock, on_error, make_probes, on_slow: see `SendingThread`.
    """

    def __init__(
        self,
        link: Link,
        clock: Callable[[], float],
        on_error: Callable[[Exception], object],
        make_probes: MakeProbes = _make_none,
        on_slow: Callable[[str], object] = lambda _: None,
    ) -> None:
        self._link = link
        self._urgent = SendingThread("bridge: urgent packets", link, clock, on_error)
        self._bulk = SendingThread("bridge: other packets", link, clock, on_error, make_probes, on_slow)

    def put(self, packet: Send) -> None:
        """Send a packet, in the thread for its priority."""
        (self._urgent if packet.priority <= Priority.HIGH else self._bulk).put(packet)

    def listen(self, site: str, key: str, on: bool) -> None:
        """Receive what another site sends on a key, or stop. Later packets wait for this, except urgent ones."""
        self._urgent.listen(site, key, on)

    def on_probe_reply(self, site: str, number: int) -> None:
        """Record that a site has answered a probe."""
        self._bulk.on_probe_reply(site, number)

    def drops(self, key: str) -> dict[str, int]:
        """Return how many packets with a key were dropped for each reason."""
        found: dict[str, int] = {}
        for thread in (self._urgent, self._bulk):
            for reason, number in thread.lanes.drops(key).items():
                found[reason] = found.get(reason, 0) + number
        return found

    @property
    def waiting_bytes(self) -> int:
        """Total size of the queued packets."""
        return self._urgent.lanes.waiting_bytes + self._bulk.lanes.waiting_bytes

    def close(self) -> None:
        """Send the queued packets, for a short time, and end the threads."""
        self._urgent.close()
        self._bulk.close()
