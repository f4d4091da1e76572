"""A node's clock, rates and timers: wall time, or the time that a simulation publishes on /clock
(https://wiki.ros.org/Clock).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from pyros1.ground.errors import NodeShutdownError, TimeMovedBackwardsError
from pyros1.ground.timing import Duration, Time
from pyros1.net.signal_safe import Condition, Event
from pyros1.node.checks import check_callback, check_positive, check_seconds

if TYPE_CHECKING:
    from pyros1.node.callback_queue import CallbackQueue
    from pyros1.node.context import Context
    from pyros1.node.log.logger import Log

MAX_PERIOD = 1e9
"""Maximum period of a timer, in seconds."""
POLL_INTERVAL = 0.3
"""Maximum number of seconds to wait for a tick of simulated time before checking again whether the node is shutting
down."""
TICK_TIMEOUT = 1.0
"""While the node shuts down, sleeps are interrupted after this many seconds without a tick of simulated time, since the
simulation may have exited first."""


class Clock:
    """The source of a node's time.

    Args:
        stopping: set when the node shuts down; interrupts all sleeps.

    Attributes:
        simulated: whether the node uses the time that is published on /clock.
        ending: whether the node has started to shut down; its early hooks may still sleep.
        tick_listeners: functions to call after each change of simulated time, in the thread that receives it.
    """

    def __init__(self, stopping: threading.Event) -> None:
        self.simulated = False
        self.ending = False
        self.tick_listeners: list[Callable[[], object]] = []
        self._stopping = stopping
        self._now = Time()
        self._ticked = Condition()

    def use_simulated_time(self) -> None:
        """Switch to simulated time, which is 0 until `tick` sets it."""
        self.simulated = True

    def tick(self, now: Time) -> None:
        """Set simulated time to ``now``, which was received on /clock, and call the functions in ``tick_listeners``."""
        self._now = now
        self._ticked.notify_all()
        for callback in tuple(self.tick_listeners):
            callback()

    def wake(self) -> None:
        """Wake threads that sleep in simulated time, so that they notice that the node is shutting down."""
        self._ticked.notify_all()

    def now(self) -> Time:
        """Return the current time."""
        if self.simulated:
            return self._now
        return Time.of_clock(time.time_ns())

    def seconds(self) -> float:
        """Return the time in seconds, for measuring durations: monotonic time, which never jumps, or simulated time."""
        return self._now.to_sec() if self.simulated else time.monotonic()

    def now_and_is_simulated(self) -> tuple[Time, bool]:
        """Return the current time, and whether it is simulated time."""
        return self.now(), self.simulated

    def sleep(self, seconds: float) -> bool:
        """Sleep for ``seconds`` of the node's time.

        Args:
            seconds: how long to sleep; if 0 or less, the method returns immediately.

        Returns:
            False if the sleep was interrupted because the node is shutting down. While early hooks run, the sleep is
            only interrupted if simulated time stands still for `TICK_TIMEOUT` seconds.

        Raises:
            TimeMovedBackwardsError: simulated time jumped back during the sleep.
        """
        if not self.simulated:
            return not (self._stopping.wait(seconds) if seconds > 0 else self._stopping.is_set())
        if seconds <= 0:
            return not self._stopping.is_set()
        self._wait_while(lambda: self._now.is_zero())  # noqa: PLW0108 - _now is replaced at each tick
        start = previous = self._now
        deadline = start + Duration.from_sec(seconds)

        def must_wait() -> bool:
            nonlocal previous
            now = self._now
            # Compared with `start`, not `previous`: with two publishers, /clock may step back a little between ticks,
            # which is not a jump.
            if now < start:
                raise TimeMovedBackwardsError((now - previous).to_sec())
            previous = now
            return now < deadline

        return self._wait_while(must_wait)

    def await_tick(self) -> bool:
        """Wait briefly for simulated time to change; return False if the node is shutting down."""
        self._wait_for_change(self._now)
        return not self._stopping.is_set()

    def _wait_for_change(self, last_seen: Time) -> None:
        self._ticked.wait_for(lambda: self._now is not last_seen or self._stopping.is_set(), POLL_INTERVAL)

    def _wait_while(self, must_wait: Callable[[], bool]) -> bool:
        last_tick = time.monotonic()
        while True:
            now = self._now
            if not must_wait():
                break
            if self._stopping.is_set() or (self.ending and time.monotonic() - last_tick > TICK_TIMEOUT):
                return False
            self._wait_for_change(now)
            if self._now is not now:
                last_tick = time.monotonic()
        return not self._stopping.is_set()


class Rate:
    """Keeps a loop at a fixed rate (https://wiki.ros.org/rospy/Overview/Time).

    Args:
        clock: the node's clock.
        frequency: the rate in Hz.
    """

    def __init__(self, clock: Clock, frequency: float) -> None:
        check_positive(frequency, "a rate", "Hz")
        self.period = 1.0 / frequency
        self._clock = clock
        self._next_time = clock.seconds() + self.period

    def remaining(self) -> float:
        """Return the seconds remaining in the current cycle; negative if the cycle is overdue."""
        return self._next_time - self._clock.seconds()

    def sleep(self) -> bool:
        """Sleep until the end of the current cycle.

        If a cycle is overdue by more than one period, the next one starts now. Returns immediately when the node is
        shutting down.

        Returns:
            False if the node is shutting down.
        """
        now = self._clock.seconds()
        if now < self._next_time - 2 * self.period:  # simulated time has jumped back
            self._next_time = now + self.period
        try:
            is_running = self._clock.sleep(self._next_time - now)
        except TimeMovedBackwardsError:
            is_running = True
        now = self._clock.seconds()
        self._next_time += self.period
        if not self._next_time - 2 * self.period <= now <= self._next_time:
            self._next_time = now + self.period
        return is_running


class TimerEvent:
    """The argument of a timer's callback, as in rospy and roscpp.

    Attributes:
        last_expected, last_real: when the previous call was due, and when it was made; None for the first call.
        current_expected, current_real: when this call was due, and when it was made.
        last_duration: duration of the previous callback in seconds; None for the first call.
    """

    __slots__ = ("current_expected", "current_real", "last_duration", "last_expected", "last_real")

    def __init__(
        self,
        last_expected: Time | None,
        last_real: Time | None,
        current_expected: Time,
        current_real: Time,
        last_duration: float | None,
    ) -> None:
        self.last_expected = last_expected
        self.last_real = last_real
        self.current_expected = current_expected
        self.current_real = current_real
        self.last_duration = last_duration


class Timer:
    """Calls a function periodically; created by ``Node.timer``.

    Args:
        clock: the node's clock.
        period: seconds between calls.
        callback: called with a TimerEvent.
        oneshot: whether to call only once.
        callback_queue: the callback queue of a node that spins, else None.
        log: logs exceptions raised by the callback.
    """

    def __init__(
        self,
        clock: Clock,
        period: float,
        callback: Callable[[TimerEvent], object],
        oneshot: bool,
        callback_queue: CallbackQueue | None,
        log: Log,
    ) -> None:
        check_positive(period, "a timer's period", "s", MAX_PERIOD)
        self._clock = clock
        self._period = period
        self._callback = callback
        self._oneshot = oneshot
        self._callback_queue = callback_queue
        self._log = log
        self._stopped = Event()
        self._is_queued = False
        self._last_call: tuple[Time, Time, float] | None = None  # when it was due and made, and the callback's duration
        self._thread = threading.Thread(target=self._run, name="timer", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        rate = Rate(self._clock, 1.0 / self._period)
        while not self._stopped.is_set():
            due_time = self._clock.now() + Duration.from_sec(max(0.0, rate.remaining()))
            is_running = self._sleep_simulated(rate) if self._clock.simulated else self._sleep(rate)
            if not is_running or self._stopped.is_set():
                return
            if self._callback_queue is None:
                self._fire(due_time)
            elif not self._is_queued:  # a program that spins too rarely receives one call instead of many
                self._is_queued = True
                self._callback_queue.push(lambda due_time=due_time: self._fire(due_time))  # type: ignore[misc]
            if self._oneshot:
                return

    def _sleep_simulated(self, rate: Rate) -> bool:
        """Sleep in simulated time until the next call; return False if the timer or the node is shut down.

        `shutdown` interrupts the sleep at the next tick, or within `POLL_INTERVAL` seconds if there is none.
        """
        while 0 < rate.remaining() <= 2 * self._period:  # if more remains, time has jumped back: `Rate` handles that
            if self._stopped.is_set() or not self._clock.await_tick():
                return False
        return rate.sleep()

    def _sleep(self, rate: Rate) -> bool:
        """Sleep in wall time until the next call; return False if the timer or the node is shut down meanwhile."""
        while (remaining := rate.remaining()) > 0.2:
            if self._stopped.wait(0.2 if remaining > 0.4 else remaining - 0.2):
                return False
            if not self._clock.sleep(0):
                return False
        return rate.sleep()

    def _fire(self, due_time: Time) -> None:
        self._is_queued = False
        if self._stopped.is_set():
            return
        called_at = self._clock.now()
        last_call = self._last_call
        event = TimerEvent(
            last_call and last_call[0], last_call and last_call[1], due_time, called_at, last_call and last_call[2]
        )
        started_at = time.perf_counter()
        try:
            self._callback(event)
        except NodeShutdownError:
            return
        except Exception as error:  # noqa: BLE001 - raised by user code: the timer continues
            self._log.exception(f"bad timer callback {self._callback!r}", error=error)
        self._last_call = (due_time, called_at, time.perf_counter() - started_at)

    @property
    def alive(self) -> bool:
        """Whether the timer will make further calls."""
        return self._thread.is_alive()

    def shutdown(self) -> None:
        """Stop the timer; a running callback is not interrupted."""
        self._stopped.set()

    def join(self, timeout: float) -> None:
        """Wait for the timer's thread to exit, at most ``timeout`` seconds."""
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout)


class Timers:
    """A node's timers.

    Args:
        clock, callback_queue, log: passed to each `Timer`.
    """

    def __init__(self, clock: Clock, callback_queue: CallbackQueue | None, log: Log) -> None:
        self._clock = clock
        self._callback_queue = callback_queue
        self._log = log
        self._timers: list[Timer] = []

    def start(self, period: float, callback: Callable[[TimerEvent], object], oneshot: bool) -> Timer:
        """Start a timer and return it."""
        timer = Timer(self._clock, period, callback, oneshot, self._callback_queue, self._log)
        self._timers = [*(other for other in self._timers if other.alive), timer]
        return timer

    def shutdown(self) -> None:
        """Stop all timers."""
        for timer in self._timers:
            timer.shutdown()

    def join(self, timeout: float) -> None:
        """Wait for the threads of all timers to exit, at most ``timeout`` seconds for each."""
        for timer in self._timers:
            timer.join(timeout)


class TimeMethods:
    """The methods of `Node` that deal with time; a base class of `Node`."""

    _context: Context
    _clock: Clock
    _timers: Timers

    def now(self) -> Time:
        """Return the current time: wall time, or simulated time if /use_sim_time is set.

        Simulated time is 0 until the first message on /clock.
        """
        return self._clock.now()

    @property
    def simulated_time(self) -> bool:
        """Whether the node uses simulated time, as published on /clock."""
        return self._clock.simulated

    def sleep(self, seconds: float) -> bool:
        """Sleep for ``seconds`` of the node's time; return True, or False as soon as the node shuts down.

        Raises:
            TimeMovedBackwardsError: simulated time jumped back during the sleep.
            TypeError, ValueError: ``seconds`` is not a number.
        """
        check_seconds(seconds, "sleep: seconds")
        return self._clock.sleep(seconds)

    def rate(self, frequency: float) -> Rate:
        """Return a Rate whose `sleep` keeps a loop at ``frequency`` Hz.

        Raises:
            TypeError, ValueError: ``frequency`` is not a number above 0.
        """
        return Rate(self._clock, frequency)

    def timer(self, period: float, callback: Callable[[TimerEvent], object], oneshot: bool = False) -> Timer:
        """Start a timer and return it.

        Args:
            period: seconds of the node's time between calls.
            callback: called with a TimerEvent.
            oneshot: whether to call only once, after one period.

        Raises:
            TypeError, ValueError: an argument is invalid.
            NodeShutdownError: the node is shutting down.
        """
        check_callback(callback, "timer(period, callback)", "callback")
        self._context.check_running()
        return self._timers.start(period, callback, oneshot)
