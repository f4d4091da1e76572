"""Deadlines of subscriptions: notification of messages that do not come."""

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
    """Notification that no message came in time.

    Attributes:
        topic: full name.
        silent: seconds of the node's time since the last message, or since the first publisher was connected.
        publishers: names of the nodes that are connected as publishers now.
    """

    topic: str
    silent: float
    publishers: tuple[str, ...]

    def __str__(self) -> str:
        whose = (
            f", from {', '.join(map(terminal_text.one_line, self.publishers))}" if self.publishers else ", no publisher"
        )
        return f"no message on {self.topic} for {self.silent:.3g} s{whose}"


class Deadline:
    """Calls a function when no message has come for a while: once per gap.

    It replaces the callback and records when a message comes; nothing else is done for each message. It uses the node's
    time, so nothing is missed while a simulation is paused.

    Args:
        seconds: maximum time without a message.
        callback: receives the messages.
        on_missed: called with a `Missed`.
        context: the node.
        clock: its clock.
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
        self._last: float | None = None  # None before the first message and publisher
        self._reported: float | None = None  # when the last reported gap began
        self._is_watching = self._closed = False

    def take(self, message: Any) -> None:
        """Receive a message: the callback of the subscriber."""
        self._last = self._now()
        self._callback(message)

    def __repr__(self) -> str:
        return repr(self._callback)  # for the log, if it raises

    def begin(self, subscription: Subscription) -> None:
        """Start checking as soon as a publisher is connected."""
        self._subscription = subscription
        self._notifier = self._notifiers.make(f"deadline of {subscription.topic}")
        subscription.on_change.append(self._links_changed)
        self._links_changed()

    def close(self) -> None:
        """Stop checking. Threads and signal handlers may call it."""
        self._closed = True
        if self._notifier is not None:
            self._notifiers.end(self._notifier)
            self._context.loop.call_soon(self._stop_watching)

    def _links_changed(self) -> None:
        self._context.loop.call_soon(self._begin)

    # On the loop ------------------------------------------------------------------------------------------------------

    def _begin(self) -> None:
        subscription = self._subscription
        has_source = subscription is not None and (subscription.links or self._last is not None)
        if self._closed or self._is_watching or not has_source:
            return
        self._is_watching = True
        self._unwatch_links()
        if self._last is None:
            self._last = self._now()
        if self._clock.simulated:
            self._clock.on_tick.append(self._check)
        else:
            self._check_and_reschedule()

    def _unwatch_links(self) -> None:
        subscription = self._subscription
        if subscription is not None and self._links_changed in subscription.on_change:
            subscription.on_change.remove(self._links_changed)

    def _stop_watching(self) -> None:
        self._unwatch_links()
        if self._check in self._clock.on_tick:
            self._clock.on_tick.remove(self._check)

    def _check_and_reschedule(self) -> None:
        """Check now, and again when the deadline ends if no message comes meanwhile."""
        if not self._closed:
            self._context.loop.call_later(self._check(), self._check_and_reschedule)

    def _check(self) -> float:
        """Report a missed message; return the seconds until the next check. On the loop, or in the thread of /clock."""
        now, last = self._now(), self._last
        if not last or now < last:  # simulated time has only begun, or jumped back
            self._last = now
            return self._seconds
        silent = now - last
        if silent < self._seconds:
            return max(0.001, self._seconds - silent)
        if last != self._reported and not self._closed and self._notifier is not None:
            self._reported = last
            self._notifier.notify(partial(self._call_on_missed, last), silent)
        return self._seconds

    # Where callbacks run ----------------------------------------------------------------------------------------------

    def _call_on_missed(self, last: float, silent: float) -> None:
        came_meanwhile = self._context.callbacks is not None and self._last != last  # it had come, but waited for spin
        if self._closed or came_meanwhile or self._subscription is None:
            return
        links = self._subscription.links
        names = tuple(sorted(str(link.header.get("callerid", "?")) for link in links))
        self._on_missed(Missed(self._subscription.topic, silent, names))
