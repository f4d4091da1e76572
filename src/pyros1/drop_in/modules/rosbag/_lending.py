"""Readers of a bag that is also written, which iterators use while newer ones take their place."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from pyros1.bag.format.reader import BagReader


class Lending:
    """Keeps readers open while iterators use them.

    Args:
        lock: held when the present reader is asked for and replaced.
    """

    def __init__(self, lock: threading.RLock) -> None:
        self._lock = lock
        self._lent: list[BagReader] = []
        self._retired: list[BagReader] = []

    @contextmanager
    def lend(self, present: Callable[[], BagReader]) -> Iterator[BagReader]:
        """Lend the present reader, which a function returns, to an iterator."""
        with self._lock:
            reader = present()
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
        """Close a reader that has a successor: now, or when the last iterator has given it back."""
        if reader is not None and reader in self._lent:
            self._retired.append(reader)
        elif reader is not None:
            reader.close()
