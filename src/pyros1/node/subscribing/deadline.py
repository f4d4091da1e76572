"""Deadlines of subscriptions: notify the program if no message arrives in time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

from pyros1.ground import terminal_text

if TYPE_CHECKING:
    from pyros1.node.clock import Clock
    from pyros1.node.context import Context
    from pyros1.node.subscribing.subscription import Subscription
    from pyros1.node.watching.notifiers import Notifier, Notifiers


class Missed(NamedTuple):
    """Notification that no message arrived in time.

    Attributes:
        topic: the topic's full name.
        silent: seconds of the node's time since the last message, or since the first publisher was connected.
        publishers: names of the publishing nodes that are connected now.
    """

    topic: str
    silent: float
    publishers: tuple[str, ...]

    def __str__(self) -> str:
        publishers_text = (
            f", from {', '.join(map(terminal_text.one_line, self.publishers))}" if self.publishers else ", no publisher"
        )
        return f"no message on {self.topic} for {self.silent:.3g} s{publishers_text}"


class Deadline:
    """Calls a function, once for each gap, when no message has arrived for ``seconds`` seconds.

    A Deadline takes the place of the callback: it records when each message arrives, and calls the actual callback. It
    uses the node's time, so no message counts as missed while a simulation is paused.

    Args:
        seconds: maximum time without a message, in seconds.
        callback: receives the messages.
        on_missed: called with a `Missed`.
        context: the node's context.
        clock: the node's clock.
        notifiers: call ``on_missed``.
    """

    def __init__(
        self,
        seconds: float,
        callback: Callable[[Any], object],
        on_missed: Callable[[Missed], object],
        context: Context,
        clock: Clock,
        notifiers: Notifiers,
    ) -> None:
        self._seconds = seconds
        self._callback = callback
        self._on_missed = on_missed
        self._context = context
        self._clock = clock
        self._notifiers = notifiers
        self._notifier: Notifier | None = None
        self._subscription: Subscription | None = None
        self._now = clock.seconds if clock.simulated else monotonic
        self._last_arrival_at: float | None = None  # of the last message, else of the first publisher; None if neither
        self._reported_gap_start: float | None = None  # when the last reported gap began
        self._is_watching = self._closed = False

    def on_message(self, message: Any) -> None:
        """Record when a message arrives, and call the actual callback. Passed to the subscriber as its callback."""
        self._last_arrival_at = self._now()
        self._callback(message)

    def __repr__(self) -> str:
        return repr(self._callback)  # for the log, if the callback raises

    def begin(self, subscription: Subscription) -> None:
        """Start checking for missed messages as soon as a publisher is connected."""
        self._subscription = subscription
        self._notifier = self._notifiers.make(f"deadline of {subscription.topic}")
        subscription.change_listeners.append(self._on_links_changed)
        self._on_links_changed()

    def close(self) -> None:
        """Stop checking. Thread-safe, and allowed in signal handlers."""
        self._closed = True
        if self._notifier is not None:
            self._notifiers.end(self._notifier)
            self._context.loop.call_soon(self._stop_watching)

    def _on_links_changed(self) -> None:
        self._context.loop.call_soon(self._begin)

    # On the loop ------------------------------------------------------------------------------------------------------

    def _begin(self) -> None:
        subscription = self._subscription
        has_source = subscription is not None and (subscription.links or self._last_arrival_at is not None)
        if self._closed or self._is_watching or not has_source:
            return
        self._is_watching = True
        self._unwatch_links()
        if self._last_arrival_at is None:
            self._last_arrival_at = self._now()
        if self._clock.simulated:
            self._clock.tick_listeners.append(self._check)
        else:
            self._check_and_reschedule()

    def _unwatch_links(self) -> None:
        subscription = self._subscription
        if subscription is not None and self._on_links_changed in subscription.change_listeners:
            subscription.change_listeners.remove(self._on_links_changed)

    def _stop_watching(self) -> None:
        self._unwatch_links()
        if self._check in self._clock.tick_listeners:
            self._clock.tick_listeners.remove(self._check)

    def _check_and_reschedule(self) -> None:
        """Check now, and again when the deadline ends if no message arrives meanwhile."""
        if not self._closed:
            self._context.loop.call_later(self._check(), self._check_and_reschedule)

    def _check(self) -> float:
        """Report a missed message; return the seconds until the next check. Called on the loop, or in the thread that
        receives /clock.
        """
        now, last_arrival_at = self._now(), self._last_arrival_at
        if not last_arrival_at or now < last_arrival_at:  # simulated time has just begun, or jumped back
            self._last_arrival_at = now
            return self._seconds
        silent = now - last_arrival_at
        if silent < self._seconds:
            return max(0.001, self._seconds - silent)
        if last_arrival_at != self._reported_gap_start and not self._closed and self._notifier is not None:
            self._reported_gap_start = last_arrival_at
            self._notifier.notify(partial(self._call_on_missed, last_arrival_at), silent)
        return self._seconds

    # Where callbacks run ----------------------------------------------------------------------------------------------

    def _call_on_missed(self, last_arrival_at: float, silent: float) -> None:
        # a message had arrived, but was waiting for `spin`
        has_arrived_meanwhile = self._context.callback_queue is not None and self._last_arrival_at != last_arrival_at
        if self._closed or has_arrived_meanwhile or self._subscription is None:
            return
        links = self._subscription.links
        publishers = tuple(sorted(str(link.header.get("callerid", "?")) for link in links))
        self._on_missed(Missed(self._subscription.topic, silent, publishers))
