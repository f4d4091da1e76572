"""Queues actions for the thread that talks to the master, which may be slow, and messages that depend on them.

For each topic, only the net change is kept: whether to stop what exists, and what to start. Nothing is kept for a topic
that was never started and is no longer wanted, so another site cannot fill this queue by changing its requests or
making up names. Messages for a topic that is about to be published wait until it is, unless they get too old meanwhile.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable
from itertools import chain
from operator import itemgetter

from pyros1.bridge.clock import steady_now
from pyros1.bridge.conversions.conversion import Conversion
from pyros1.bridge.exchange.actions import Advertise, Forget, Publish, SetOrigins, Source, Subscribe, Withdraw

Change = Subscribe | Advertise | SetOrigins | Withdraw
"""A change to register with the master."""
MAX_MESSAGES = 5_000
"""Maximum number of messages held for topics that are not published yet."""
MAX_BYTES = 64 << 20
"""Maximum total size in bytes of the messages held for topics that are not published yet; at least one is held."""
RETURN_DELAY = 0.5
"""Minimum seconds until a withdrawn topic is published again. Until stock rospy's subscribers have noticed that their
connections were closed, they mistake a new publisher with the same address for the old one.
"""
_MAX_WITHDRAWN = 10_000
_SWEEP_PERIOD = 0.1
_Key = tuple[bool, str, Conversion | None]  # whether it is a subscription, the topic, and its conversion


class _PendingActions:
    """A topic's pending actions: an end, then a start, then a change; any may be missing."""

    def __init__(self) -> None:
        self.end: Change | None = None
        self.begin: Change | None = None
        self.change: SetOrigins | None = None

    @property
    def replaces_publisher(self) -> bool:
        """Whether messages must wait: a topic's new original publishers alone do not affect them."""
        return self.end is not None or self.begin is not None

    def actions(self) -> list[Change]:
        return [action for action in (self.end, self.begin, self.change) if action is not None]


class DeferredActions:
    """Actions queued for the master. May be used in several threads.

    Args:
        clock: returns seconds; the messages' `expires` refers to it.

    Attributes:
        dropped: how many messages were dropped because too many were waiting, they waited for too long, or their topic
            was withdrawn.
    """

    def __init__(self, clock: Callable[[], float] = steady_now) -> None:
        self.dropped = 0
        self._clock = clock
        self._withdrawn_at: dict[_Key, float] = {}
        self._lock = threading.Lock()
        self._changed = threading.Condition(self._lock)
        self._pending: dict[_Key, _PendingActions] = {}
        self._failed: dict[_Key, _PendingActions] = {}
        self._busy: _Key | None = None
        self._popped = _PendingActions()  # the actions popped last
        self._begun: set[_Key] = set()  # topics that are or may be registered with the master
        self._held: dict[str, dict[Source, deque[tuple[int, Publish]]]] = {}  # by topic, with sequence numbers
        self._held_number = self._held_count = self._held_bytes = 0
        self._next_sweep = 0.0  # when the messages of all sources may be searched for old ones again
        self._is_woken = False

    def put(self, action: Change) -> None:
        """Add an action."""
        key = _key(action)
        with self._lock:
            pending = self._failed.pop(key, None)
            pending = self._pending.setdefault(key, pending or _PendingActions())
            if isinstance(action, SetOrigins):
                pending.change = action
            elif _is_start(action):
                pending.begin, pending.change = action, None
            else:
                pending.end, pending.begin, pending.change = action, None, None
                if isinstance(action, Withdraw):
                    self.dropped += len(self._take_waiting(action.local))
                if key not in self._begun:
                    del self._pending[key]  # it was never started, so nothing is left to do
            self._changed.notify()

    def hold(self, action: Publish | Forget) -> bool:
        """Return whether a topic is about to be published, changed or withdrawn; if so, hold a message until then. A
        `Forget` discards its source's held messages, and is never held itself.
        """
        local = action.local
        with self._lock:
            if isinstance(action, Forget):
                gone = self._held.get(local, {}).pop(action.source, ())
                self._count_waiting(-1, [message for _, message in gone])
                return False
            if local not in self._held and not self._must_wait(local):
                return False
            self._drop_expired(self._held.get(local, {}).get(action.source, deque()))
            if self._has_no_room(action) and self._clock() >= self._next_sweep:
                self._next_sweep = self._clock() + _SWEEP_PERIOD
                for sources in self._held.values():
                    for source in [*sources]:
                        self._drop_expired(sources[source])
                        if not sources[source]:
                            del sources[source]
            if self._has_no_room(action):
                self.dropped += 1
            else:  # a queue is kept only with a message in it, since another site may invent any number of sources
                self._held_number += 1
                messages = self._held.setdefault(local, {}).setdefault(action.source, deque())
                messages.append((self._held_number, action))
                self._count_waiting(1, [action])
            return True

    def _has_no_room(self, message: Publish) -> bool:
        return self._held_count > 0 and (
            self._held_count >= MAX_MESSAGES or self._held_bytes + len(message.body) > MAX_BYTES
        )

    def _must_wait(self, local: str) -> bool:
        """Return whether messages of a topic must wait."""
        key = (False, local, None)
        if key == self._busy and self._popped.replaces_publisher:
            return True
        for actions in (self._pending, self._failed):
            if (pending := actions.get(key)) is not None and pending.replaces_publisher:
                return True
        return False

    def _drop_expired(self, messages: deque[tuple[int, Publish]]) -> None:
        """Drop the oldest messages of a source as far as they are too old, so that they take no room from new ones."""
        now = self._clock() if messages else 0.0
        while messages and _is_expired(messages[0][1], now):
            self._count_waiting(-1, [messages.popleft()[1]])
            self.dropped += 1

    def _count_waiting(self, sign: int, messages: Iterable[Publish]) -> None:
        for message in messages:
            self._held_count += sign
            self._held_bytes += sign * len(message.body)

    def _take_waiting(self, local: str) -> list[Publish]:
        held = sorted(chain.from_iterable(self._held.pop(local, {}).values()), key=itemgetter(0))
        messages = [message for _, message in held]
        self._count_waiting(-1, messages)
        return messages

    def pop(self, timeout: float = 0.0) -> list[Change]:
        """Wait for actions, and return those due for one topic, in order. The caller must then call `finish` or `fail`;
        if a bug prevents both, the actions count as failed.

        Args:
            timeout: maximum seconds to wait; after that, the list may be empty.
        """
        with self._lock:
            if self._busy is not None:
                self._fail(self._popped.actions())
            key = self._next_due()
            if key is None and timeout and not self._is_woken:
                self._changed.wait(timeout)
                key = self._next_due()
            self._is_woken = False
            if key is None:
                return []
            self._busy = key
            self._begun.add(key)
            pending = self._pending[key]
            if isinstance(pending.end, Withdraw) and pending.begin is not None:
                self._popped = _PendingActions()  # the start follows later
                self._popped.end, pending.end = pending.end, None
            else:
                self._popped = self._pending.pop(key)
            return self._popped.actions()

    def _next_due(self) -> _Key | None:
        for key in self._pending:
            since = self._withdrawn_at.get(key)
            if since is None or self._clock() - since >= RETURN_DELAY:
                self._withdrawn_at.pop(key, None)
                return key
        return None

    def finish_if_nothing_waits(self) -> bool:
        """Mark the popped actions as done, unless messages are waiting for them; return whether they were marked."""
        with self._lock:
            if self._busy is not None and self._busy[1] in self._held:
                return False
            self._finish()
            return True

    def finish(self) -> list[Publish]:
        """Mark the popped actions as done, and return the messages that waited for them, in order, unless too old."""
        with self._lock:
            return self._finish()

    def _finish(self) -> list[Publish]:
        key, self._busy = self._busy, None
        if key is not None and self._popped.end is not None and self._popped.begin is None:
            self._begun.discard(key)
            if isinstance(self._popped.end, Withdraw):
                if len(self._withdrawn_at) >= _MAX_WITHDRAWN:
                    self._withdrawn_at.clear()
                self._withdrawn_at[key] = self._clock()
        if key is None or key[0] or self._must_wait(key[1]):
            return []
        messages = self._take_waiting(key[1])
        now = self._clock() if messages else 0.0
        fresh = [message for message in messages if not _is_expired(message, now)]
        self.dropped += len(messages) - len(fresh)
        return fresh

    def fail(self, actions: list[Change]) -> None:
        """Record that some of the popped actions failed: `retry` queues them again, unless newer ones have superseded
        them.
        """
        with self._lock:
            self._fail(actions)

    def _fail(self, actions: list[Change]) -> None:
        key, self._busy = self._busy, None
        if key is None:
            return
        newer = self._pending.get(key)
        pending = newer or self._failed.setdefault(key, _PendingActions())
        is_superseded = pending.end is not None or pending.begin is not None
        for action in actions:
            if isinstance(action, SetOrigins):
                if not is_superseded:
                    pending.change = pending.change or action
            elif not _is_start(action):
                pending.end = pending.end or action
            elif not is_superseded:
                pending.begin = action

    def retry(self) -> None:
        """Queue the failed actions again."""
        with self._lock:
            self._pending.update(self._failed)
            self._failed.clear()

    def wake(self) -> None:
        """Wake the thread that waits in `pop`, or let the next `pop` return at once."""
        with self._lock:
            self._is_woken = True
            self._changed.notify_all()


def _is_expired(message: Publish, now: float) -> bool:
    return message.expires is not None and now > message.expires


def _is_start(action: Change) -> bool:
    return isinstance(action, Advertise) or (isinstance(action, Subscribe) and action.on)


def _key(action: Change) -> _Key:
    return isinstance(action, Subscribe), action.local, action.conversion if isinstance(action, Subscribe) else None
