"""Handles packets from the link: in the link's own thread while nothing waits, since a thread switch would double the
cost; otherwise in a worker thread, which also calls the state machine's timer.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

from pyros1.bridge.protocol.key_expressions import Key
from pyros1.bridge.transport.inbox import Inbox, Received

TICK = 0.1
"""Seconds between ticks of the state machine."""
_DIRECT_TIME = 0.05
"""Maximum seconds between two ticks for which the link's threads handle packets. In a flood, sites must take turns, but
packets waiting in the link keep their order of arrival.
"""
_JOIN_TIME = 3.0


class PacketWorker:
    """Handles packets one at a time, in the order of the inbox.

    Args:
        lock: guards the state machine; held while the functions below are called.
        clock: returns the site's time in seconds.
        on_packet: handles a packet.
        on_tick: called each tenth of a second with the time.
        on_error: called with exceptions that these functions raise, which are bugs in pyros1.

    Attributes:
        inbox: the waiting packets.
    """

    def __init__(
        self,
        lock: threading.RLock,
        clock: Callable[[], float],
        on_packet: Callable[[Received, float], object],
        on_tick: Callable[[float], object],
        on_error: Callable[[Exception], object],
    ) -> None:
        self.inbox = Inbox()
        self._state_lock = lock
        self._clock = clock
        self._on_packet = on_packet
        self._on_tick = on_tick
        self._on_error = on_error
        self._lock = threading.Lock()
        self._changed = threading.Condition(self._lock)
        self._is_busy = False  # whether a thread is handling a packet
        self._direct_time = 0.0  # how long the link's threads have handled packets since the last tick
        self._is_started = False
        self._is_closing = False
        self._thread = threading.Thread(target=self._run, name="bridge: packets", daemon=True)

    def start(self) -> None:
        """Start handling packets; those that have already arrived are waiting."""
        with self._lock:
            self._is_started = True
        self._thread.start()

    def receive(self, key: Key, head: bytes, body: bytes) -> None:
        """Handle a packet, or leave it to the worker thread. Called in the link's threads; never waits for a packet
        that another thread is handling.
        """
        packet = (key, head, body)
        with self._lock:
            if not self._may_handle(packet):
                self.inbox.put(packet)
                if not self._is_busy:  # the busy thread checks the queue again
                    self._changed.notify()
                return
            self._is_busy = True
        start = self._clock()
        try:
            self._handle(packet)
        finally:
            self._state_lock.release()
            with self._lock:
                self._is_busy = False
                self._direct_time += self._clock() - start
                if not self.inbox.is_empty or self._is_closing:
                    self._changed.notify_all()

    def _may_handle(self, packet: Received) -> bool:
        """Return whether the link's thread may handle a packet at once; if so, it has the state machine's lock."""
        return (
            not self._is_busy
            and self.inbox.is_empty  # otherwise the inbox decides which packet is next
            and self.inbox.is_cheap(packet)  # other sites' packets wait in the link meanwhile
            and self._direct_time < _DIRECT_TIME
            and self._is_started
            and not self._is_closing
            and self._state_lock.acquire(blocking=False)
        )

    def _handle(self, packet: Received) -> None:
        try:
            self._on_packet(packet, self._clock())
        except Exception as error:  # noqa: BLE001 - a bug must not end the bridge silently
            self._on_error(error)

    def _run(self) -> None:
        next_tick = self._clock()
        while not self._is_closing:
            if (packet := self._next(next_tick)) is not None:
                with self._state_lock:
                    self._handle(packet)
                with self._lock:
                    self._is_busy = False
                    if self._is_closing:
                        self._changed.notify_all()
            now = self._clock()
            if now >= next_tick:
                next_tick = now + TICK
                with self._lock:
                    self._direct_time = 0.0
                try:
                    with self._state_lock:
                        self._on_tick(self._clock())  # later than `now` if packets had the lock
                except Exception as error:  # noqa: BLE001 - see above
                    self._on_error(error)

    def _next(self, next_tick: float) -> Received | None:
        """Wait for a packet until the next tick, and return it."""
        with self._lock:
            if self._is_busy or self.inbox.is_empty:
                self._changed.wait(max(0.0, next_tick - self._clock()))
            packet = None if self._is_busy else self.inbox.pop()
            self._is_busy = self._is_busy or packet is not None
            return packet

    def close(self) -> None:
        """Stop handling packets, and end the thread. This waits a short time for a packet that is being handled."""
        deadline = self._clock() + _JOIN_TIME
        with self._lock:
            self._is_closing = True
            self._changed.notify_all()
            self._changed.wait_for(lambda: not self._is_busy, _JOIN_TIME)
        if self._is_started:
            self._thread.join(max(0.0, deadline - self._clock()))
