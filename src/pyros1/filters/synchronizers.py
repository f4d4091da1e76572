"""Finds messages of several topics with equal or nearly equal time stamps, and stores recent messages
(https://wiki.ros.org/message_filters).

This module receives and sends nothing: its callers pass messages with their stamps, and get matching sets back.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections.abc import Sequence
from operator import methodcaller
from typing import Any

from pyros1.ground.timing import Duration, Time

_TO_NANOSECONDS = methodcaller("to_nsec")
"""Sort key for Time objects: comparing its results is much faster than comparing the objects."""


class ExactTime:
    """Finds messages of all topics with the same time stamp.

    Args:
        count: number of topics.
        queue_size: maximum number of waiting messages per topic; beyond that, those with the oldest stamps are dropped.
    """

    def __init__(self, count: int, queue_size: int) -> None:
        self.queues: list[dict[Time, Any]] = [{} for _ in range(count)]
        self.queue_size = queue_size

    def add(self, index: int, stamp: Time, message: Any) -> list[tuple[Any, ...]]:
        """Add a message of one topic; return the sets that the message completes, the oldest first.

        Args:
            index: index of the topic, starting at 0.
            stamp: the message's time stamp.
            message: the message.
        """
        self.keep(index, stamp, message)
        return self.complete(index, stamp)

    def complete(self, index: int, stamp: Time) -> list[tuple[Any, ...]]:
        """Remove and return the sets that a message of topic ``index`` completes."""
        common_stamps = set.intersection(*map(set, self.queues))
        return [self._pop_set([common_stamp] * len(self.queues)) for common_stamp in sorted(common_stamps)]

    def keep(self, index: int, stamp: Time, message: Any) -> None:
        """Queue a message until matching messages arrive. If too many are queued, drop those with the oldest stamps."""
        queue = self.queues[index]
        queue[stamp] = message
        while len(queue) > self.queue_size:
            del queue[min(queue, key=_TO_NANOSECONDS)]

    def _pop_set(self, stamps: Sequence[Time]) -> tuple[Any, ...]:
        return tuple(queue.pop(stamp) for queue, stamp in zip(self.queues, stamps, strict=True))

    def clear(self) -> None:
        """Discard all messages. Must be called when time has jumped back."""
        for queue in self.queues:
            queue.clear()


class ApproximateTime(ExactTime):
    """Finds messages of all topics whose time stamps are less than ``slop`` apart.

    Each new message is first matched with the nearest one of every other topic.

    Args:
        count, queue_size: see `ExactTime`.
        slop: the stamps in a set are less than this many seconds apart.
    """

    def __init__(self, count: int, queue_size: int, slop: float) -> None:
        super().__init__(count, queue_size)
        self.slop = Duration.from_sec(slop)

    def complete(self, index: int, stamp: Time) -> list[tuple[Any, ...]]:
        """Remove and return the set that the newest message of topic ``index`` completes, if any."""
        if stamp not in self.queues[index] or not self.slop > Duration():
            return []  # the message was dropped already, or no stamp can be near enough
        candidates: list[list[Time]] = []
        for other_index in range(len(self.queues)):
            stamps = [stamp] if other_index == index else self._nearby_stamps(other_index, stamp)
            if not stamps:
                return []
            candidates.append(stamps)
        combination = self._find_combination(candidates, stamp, stamp)
        return [self._pop_set(combination)] if combination is not None else []

    def _nearby_stamps(self, index: int, stamp: Time) -> list[Time]:
        """Return the stamps of a topic that may match, the nearest first, and equally near ones in order of arrival."""
        center, max_distance = stamp.to_nsec(), self.slop.to_nsec()
        nearby: list[tuple[int, int, Time]] = []
        for arrival_index, other_stamp in enumerate(self.queues[index]):
            distance = abs(other_stamp.to_nsec() - center)
            if distance <= max_distance:
                nearby.append((distance, arrival_index, other_stamp))
        nearby.sort()
        return [other_stamp for _, _, other_stamp in nearby]

    def _find_combination(self, candidates: list[list[Time]], low: Time, high: Time) -> list[Time] | None:
        """Return the first combination of stamps, one per topic, that is less than ``slop`` apart, including the stamps
        ``low`` and ``high``; None if there is none.
        """
        if not candidates:
            return []
        for stamp in candidates[0]:
            minimum, maximum = min(low, stamp), max(high, stamp)
            if maximum - minimum < self.slop:
                other_stamps = self._find_combination(candidates[1:], minimum, maximum)
                if other_stamps is not None:
                    return [stamp, *other_stamps]
        return None


class Recent:
    """The newest messages of a topic, in order of their time stamps.

    Args:
        size: maximum number of messages.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self._items: list[tuple[Time, int, Any]] = []
        self._last_number = 0

    def add(self, stamp: Time, message: Any) -> None:
        """Add a message; if there are now too many, remove the one with the oldest stamp."""
        self._last_number += 1
        insort(self._items, (stamp, self._last_number, message), key=lambda item: item[:2])
        if len(self._items) > self.size:
            del self._items[0]

    def between(self, first: Time, last: Time) -> list[Any]:
        """Return the messages with stamps from ``first`` to ``last``, both included."""
        start_index = bisect_left(self._items, first, key=lambda item: item[0])
        end_index = bisect_right(self._items, last, key=lambda item: item[0])
        return [item[2] for item in self._items[start_index:end_index]]

    def after(self, stamp: Time) -> Any:
        """Return the oldest message that is not older than a stamp; None if there is none."""
        index = bisect_left(self._items, stamp, key=lambda item: item[0])
        return self._items[index][2] if index < len(self._items) else None

    def before(self, stamp: Time) -> Any:
        """Return the newest message that is not newer than a stamp; None if there is none."""
        index = bisect_right(self._items, stamp, key=lambda item: item[0])
        return self._items[index - 1][2] if index else None

    @property
    def oldest(self) -> Time | None:
        """Stamp of the oldest message; None if there is none."""
        return self._items[0][0] if self._items else None

    @property
    def newest(self) -> Time | None:
        """Stamp of the newest message; None if there is none."""
        return self._items[-1][0] if self._items else None


def make_matcher(count: int, queue_size: int, slop: float | None) -> ExactTime:
    """Return a matcher for ``count`` topics with equal stamps, or with stamps less than ``slop`` apart.

    Args:
        count, queue_size: see `ExactTime`.
        slop: maximum difference of the stamps in seconds (exclusive); None for equal stamps.
    """
    return ExactTime(count, queue_size) if slop is None else ApproximateTime(count, queue_size, slop)


def stamp_of(message: Any, default: Time | None = None) -> Time:
    """Return the time stamp in a message's header.

    Args:
        message: the message.
        default: the stamp to return if the message has no header; None for no default.

    Raises:
        TypeError: there is neither a header nor a default.
    """
    stamp = getattr(getattr(message, "header", None), "stamp", default)
    if stamp is None:
        raise TypeError(f"{getattr(message, '_type', type(message).__name__)} has no header with a time stamp")
    return stamp
