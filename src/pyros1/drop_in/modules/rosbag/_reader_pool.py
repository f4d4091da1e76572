"""Keeps a bag's readers open while iterators use them, even if the bag is being written to."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from pyros1.bag.format.reader import BagReader


class ReaderPool:
    """Counts the iterators that use each reader; closes a replaced reader once no iterator uses it.

    Args:
        lock: held while the current reader is obtained or replaced.
    """

    def __init__(self, lock: threading.RLock) -> None:
        self._lock = lock
        self._in_use: list[BagReader] = []
        self._retired: list[BagReader] = []

    @contextmanager
    def use(self, get_reader: Callable[[], BagReader]) -> Iterator[BagReader]:
        """Keep the current reader, which ``get_reader`` returns, open for the duration of a ``with`` block."""
        with self._lock:
            reader = get_reader()
            self._in_use.append(reader)
        try:
            yield reader
        finally:
            with self._lock:
                self._in_use.remove(reader)
                if reader not in self._in_use and reader in self._retired:
                    self._retired.remove(reader)
                    reader.close()

    def retire(self, reader: BagReader | None) -> None:
        """Close a replaced reader: now, or when the last iterator that uses it has finished."""
        if reader is not None and reader in self._in_use:
            self._retired.append(reader)
        elif reader is not None:
            reader.close()
