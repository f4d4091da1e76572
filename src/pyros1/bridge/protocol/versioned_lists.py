"""Synchronises lists with another site by versions and pages, despite lost packets. No I/O.

The sender resends a list until one of the receiver's heartbeats names its version. A run of a site never reuses a
version, not even after it has forgotten a list, since the receiver may remember it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from pyros1.bridge.protocol.packets import Page, encode_pages

_REPEAT_PERIOD = 0.7
"""Seconds after which a list is sent again if the receiver does not have it."""


_STEP = 5
"""Number of pages by which the first page to send moves on each time the list is resent."""


class ListSender:
    """A list for one other site.

    Args:
        versions: yields the next version numbers; shared by all lists of a site.

    Attributes:
        version: the version of the entries.
        entries: the list.
    """

    def __init__(self, versions: Iterator[int]) -> None:
        self._versions = versions
        self.version = next(versions)
        self.entries: Sequence[Any] = ()
        self._sent_at = float("-inf")
        self._times_sent = 0

    def update(self, entries: Sequence[Any]) -> None:
        """Replace the list; the version changes if the list differs."""
        if [*entries] != [*self.entries]:
            self.version = next(self._versions)
            self.entries = entries
            self._sent_at = float("-inf")
            self._times_sent = 0

    def is_due(self, seen: int, now: float) -> bool:
        """Return whether the list must be sent now; if so, record it as sent.

        Args:
            seen: the version that the receiver has.
            now: the current time in seconds.
        """
        if seen == self.version or now - self._sent_at < _REPEAT_PERIOD:
            return False
        self._sent_at = now
        return True

    def pages(self) -> list[bytes]:
        """Return the pages to send, in a different order each time, so that all get through a network that drops most
        of them.
        """
        pages = [*encode_pages(self.version, self.entries)]
        first = _STEP * self._times_sent % len(pages)
        self._times_sent += 1
        return pages[first:] + pages[:first]


class ListReceiver:
    """A list from another site.

    Attributes:
        version: the version of the last complete list; -1 before the first.
        entries: its entries.
    """

    def __init__(self) -> None:
        self.version = -1
        self.entries: list[Any] = []
        self._pages: dict[int, Page] = {}

    def accept(self, page: Page) -> list[Any] | None:
        """Handle a page; return the list's entries if it is now complete, otherwise None."""
        if page.version <= self.version:
            return None
        known = next(iter(self._pages.values()), page)
        if page.version < known.version:
            return None
        if page.version > known.version or page.page_count != known.page_count:
            self._pages.clear()
        self._pages[page.number] = page
        if len(self._pages) < page.page_count:
            return None
        self.entries = [entry for number in sorted(self._pages) for entry in self._pages[number].entries]
        self.version = page.version
        self._pages.clear()
        return self.entries
