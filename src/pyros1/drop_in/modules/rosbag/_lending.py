"""Keeps the readers of a bag open while iterators use them, even if the bag is written meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from pyros1.bag.format.reader import BagReader


class Lending:
    """Lends readers to iterators, and closes replaced readers when no iterator uses them.

    Args:
        lock: held while the current reader is obtained or replaced.
    """

    def __init__(self, lock: threading.RLock) -> None:
        self._lock = lock
        self._lent: list[BagReader] = []
        self._retired: list[BagReader] = []

    @contextmanager
    def lend(self, get_reader: Callable[[], BagReader]) -> Iterator[BagReader]:
        """Lend the current reader, which a function returns, to an iterator."""
        with self._lock:
            reader = get_reader()
            self._lent.append(reader)
        try:
            yield reader
        finally:
            with self._lock:
                self._lent.remove(reader)
                if reader not in self._lent and reader in self._retired:
                    self._retired.remove(reader)
                    reader.close()

    def retire(self, reader: BagReader | None) -> None:
        """Close a replaced reader: now, or when the last iterator has returned it."""
        if reader is not None and reader in self._lent:
            self._retired.append(reader)
        elif reader is not None:
            reader.close()
