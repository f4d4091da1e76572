"""Caches type lookups, which are slow, including failed ones. No I/O.

A ROS 2 program can name any number of unknown types, so both the time spent on their lookups and the number of cached
failures are limited. Types that were found are cached separately, so that failures cannot displace them.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Generic, TypeVar

from pyros1.ground.errors import Error, UnknownTypeError

MAX_FAILURES = 25_000
"""Maximum number of cached failures: more than there can be publishers, subscribers etc. at a time."""
_MAX_FOUND = 5_000
_BUDGET = 2.0
_BUDGET_RATE = 0.2
_MAX_TEXT = 1000
_Found = TypeVar("_Found")
_Key = tuple[str | None, ...]


class TimeBudget:
    """Limits how much CPU time a thread may spend on something.

    Args:
        seconds: the most that may be spent at once, after a pause.
        rate: how much may be spent per second.
        clock: returns seconds.
        spent: returns the CPU time of this thread in seconds.
    """

    def __init__(
        self,
        seconds: float = _BUDGET,
        rate: float = _BUDGET_RATE,
        clock: Callable[[], float] = time.monotonic,
        spent: Callable[[], float] = time.thread_time,
    ) -> None:
        self._seconds = self._left = seconds
        self._rate = rate
        self._clock = clock
        self._spent = spent
        self._at = clock()

    @property
    def has_time_left(self) -> bool:
        """Whether the budget is not used up."""
        now = self._clock()
        self._left = min(self._seconds, self._left + (now - self._at) * self._rate)
        self._at = now
        return self._left > 0

    def run(self, find: Callable[[], _Found]) -> _Found:
        """Call a function, and count the time that it takes."""
        start = self._spent()
        try:
            return find()
        finally:
            self._left -= self._spent() - start


class LookupCache(Generic[_Found]):
    """A cache of results and failures, by key. Not thread-safe.

    Args:
        budget: the time for limited lookups.
    """

    def __init__(self, budget: TimeBudget) -> None:
        self._budget = budget
        self._found: dict[_Key, _Found] = {}
        # Only the texts of errors are kept: an exception would keep its callers' frames alive, with whole plans.
        self._failures: dict[_Key, str] = {}

    def get(self, key: _Key, find: Callable[[], _Found], *, is_limited: bool) -> _Found:
        """Return the entry for a key; look it up if it is not cached.

        Args:
            key: the key.
            find: finds it, or raises an Error.
            is_limited: whether finding it counts against the budget.

        Raises:
            UnknownTypeError: it was not found, or there is no time to look for it now.
        """
        if key in self._found:
            return self._found[key]
        if key not in self._failures:
            if is_limited and not self._budget.has_time_left:
                raise UnknownTypeError("ROS 2 uses too many unknown types; this one will be looked up later")
            try:
                found = self._budget.run(find) if is_limited else find()
            except Error as error:
                if len(self._failures) >= MAX_FAILURES:
                    del self._failures[next(iter(self._failures))]
                self._failures[key] = str(error)[:_MAX_TEXT]
            else:
                self.put(key, found)
                return found
        raise UnknownTypeError(self._failures[key])

    def put(self, key: _Key, found: _Found) -> None:
        """Cache a result."""
        if len(self._found) >= _MAX_FOUND and key not in self._found:
            del self._found[next(iter(self._found))]
        self._found[key] = found
