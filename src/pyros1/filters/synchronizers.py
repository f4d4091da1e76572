"""Messages that belong together: those of several topics with equal, or nearly equal, time stamps; and those of a while
ago (https://wiki.ros.org/message_filters).

Pure: messages and their stamps go in, and what belongs together comes out.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

from pyros1.ground.timing import Duration, Time


class ExactTime:
    """Finds messages of all topics with the same time stamp.

    Args:
        count: number of topics.
        queue_size: messages of each topic that wait for the others; those with the oldest stamps are dropped.
    """

    def __init__(self, count: int, queue_size: int) -> None:
        self.queues: list[dict[Time, Any]] = [{} for _ in range(count)]
        self.queue_size = queue_size

    def add(self, index: int, stamp: Time, message: Any) -> list[tuple[Any, ...]]:
        """Take a message of one topic; return the sets that are complete now, the oldest first."""
        self._keep(index, stamp, message)
        common = set.intersection(*map(set, self.queues))
        return [self._take([each] * len(self.queues)) for each in sorted(common)]

    def _keep(self, index: int, stamp: Time, message: Any) -> None:
        queue = self.queues[index]
        queue[stamp] = message
        while len(queue) > self.queue_size:
            del queue[min(queue)]

    def _take(self, stamps: Sequence[Time]) -> tuple[Any, ...]:
        return tuple(queue.pop(stamp) for queue, stamp in zip(self.queues, stamps, strict=True))

    def clear(self) -> None:
        """Forget all messages, because time has jumped back."""
        for queue in self.queues:
            queue.clear()


class ApproximateTime(ExactTime):
    """Finds messages of all topics whose time stamps are less than ``slop`` apart.

    Each new message is matched with the nearest of every other topic first.

    Args:
        count, queue_size: as for `ExactTime`.
        slop: seconds.
    """

    def __init__(self, count: int, queue_size: int, slop: float) -> None:
        super().__init__(count, queue_size)
        self.slop = Duration.from_sec(slop)

    def add(self, index: int, stamp: Time, message: Any) -> list[tuple[Any, ...]]:
        """Take a message of one topic; return the set that is complete now, if there is one."""
        self._keep(index, stamp, message)
        if stamp not in self.queues[index]:  # too old
            return []
        for stamps in product(*self._near(index, stamp)):
            if max(stamps) - min(stamps) < self.slop:
                return [self._take(stamps)]
        return []

    def _near(self, index: int, stamp: Time) -> Iterator[list[Time]]:
        """Yield the stamps of each topic that may match, the nearest first."""
        for position, queue in enumerate(self.queues):
            if position == index:
                yield [stamp]
                continue
            distances = sorted((abs((each - stamp).to_nsec()), order) for order, each in enumerate(queue))
            stamps = list(queue)
            most = self.slop.to_nsec()
            yield [stamps[order] for distance, order in distances if distance <= most]


class Cache:
    """The newest messages of a topic, in the order of their time stamps.

    Args:
        size: most messages.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self._items: list[tuple[Time, int, Any]] = []
        self._number = 0

    def add(self, stamp: Time, message: Any) -> None:
        """Take a message; the oldest one goes if there are too many."""
        self._number += 1
        insort(self._items, (stamp, self._number, message), key=lambda item: item[:2])
        if len(self._items) > self.size:
            del self._items[0]

    def between(self, first: Time, last: Time) -> list[Any]:
        """Return the messages with a stamp from ``first`` to ``last``, both included."""
        begin = bisect_left(self._items, first, key=lambda item: item[0])
        end = bisect_right(self._items, last, key=lambda item: item[0])
        return [item[2] for item in self._items[begin:end]]

    def after(self, stamp: Time) -> Any:
        """Return the oldest message that is not older than a stamp; None if there is none."""
        begin = bisect_left(self._items, stamp, key=lambda item: item[0])
        return self._items[begin][2] if begin < len(self._items) else None

    def before(self, stamp: Time) -> Any:
        """Return the newest message that is not newer than a stamp; None if there is none."""
        end = bisect_right(self._items, stamp, key=lambda item: item[0])
        return self._items[end - 1][2] if end else None

    @property
    def oldest(self) -> Time | None:
        """Stamp of the oldest message."""
        return self._items[0][0] if self._items else None

    @property
    def newest(self) -> Time | None:
        """Stamp of the newest message."""
        return self._items[-1][0] if self._items else None
