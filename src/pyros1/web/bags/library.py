"""The open bags, each opened once, and the current recording."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from pyros1.ground.terminal_text import untrusted
from pyros1.web.bags.bag_folders import BagFolders
from pyros1.web.server.wire import RequestError

if TYPE_CHECKING:
    from pyros1.web.bags.open_bag import OpenBag
    from pyros1.web.bags.recording import Recording

MAX_OPEN = 16
"""Maximum number of bags open at the same time."""
MAX_JOBS = 3
"""Maximum number of bags read completely at the same time, for plots; more wait."""


_Key = tuple[Path, int, int]
"""A file: its path, device and inode. An open file may be replaced at its path when a bag is recorded again."""


class _Entry:
    def __init__(self) -> None:
        self.users = 0
        self.bag: OpenBag | None = None
        self.opening = threading.Lock()


class Library:
    """The bags.

    Args:
        bag_folders: the folders that pages may see.
        may_see: whether pages may see a topic.

    Attributes:
        jobs: acquired by a thread while it reads a whole bag.
        recording: the current or the last recording; None if there was none.
    """

    def __init__(self, bag_folders: BagFolders, may_see: Callable[[str], bool]) -> None:
        self.bag_folders = bag_folders
        self.jobs = threading.BoundedSemaphore(MAX_JOBS)
        self.recording: Recording | None = None
        self._may_see = may_see
        self._lock = threading.Lock()
        self._entries: dict[_Key, _Entry] = {}

    def open(self, text: str, progress: Callable[[int], object]) -> OpenBag:
        """Open a bag, or return it if it is open. It stays open until `release` is called as many times.

        Args:
            text: its path.
            progress: called with the number of bytes read, while a bag without an index is scanned; it may raise.

        Raises:
            RequestError: pages may not see it, or too many bags are open.
            BagError: it cannot be read.
        """
        key = self._key(text)
        with self._lock:
            entry = self._entries.get(key)
            if entry is None:
                if len(self._entries) >= MAX_OPEN:
                    raise RequestError(f"{MAX_OPEN} bags are open: close one of them first")
                entry = self._entries[key] = _Entry()
            entry.users += 1
        try:
            with entry.opening:
                if entry.bag is None:
                    from pyros1.web.bags.open_bag import OpenBag  # noqa: PLC0415 - rarely needed

                    entry.bag = OpenBag(str(key[0]), self._may_see, progress)
                return entry.bag
        except BaseException:
            self._release_key(key)
            raise

    def borrow(self, text: str) -> OpenBag:
        """Return an open bag; it stays open until `release`.

        Raises:
            RequestError: it is not open.
        """
        key = self._key(text)
        with self._lock:
            entry = self._entries.get(key)
            if entry is None or entry.bag is None:
                replaced = any(path == key[0] for path, *_ in self._entries)
                raise RequestError("this file has been replaced: open it again" if replaced else "this bag is not open")
            entry.users += 1
            return entry.bag

    def release(self, bag: OpenBag) -> None:
        """Release a bag; it is closed when everything that opened or borrowed it has released it."""
        with self._lock:
            key = next((key for key, entry in self._entries.items() if entry.bag is bag), None)
        if key is not None:
            self._release_key(key)

    def record(self, begin: Callable[[], Recording]) -> None:
        """Start a recording.

        Args:
            begin: creates it.

        Raises:
            RequestError: a recording is running.
        """
        with self._lock:
            if self.recording is not None and self.recording.running:
                raise RequestError("a recording is running: stop it first")
            self.recording = begin()

    def close(self) -> None:
        """Stop the recording and close all bags."""
        if self.recording is not None:
            self.recording.stop()
        with self._lock:
            entries, self._entries = list(self._entries.values()), {}
        for entry in entries:
            if entry.bag is not None:
                entry.bag.close()

    def _key(self, text: str) -> _Key:
        path = self.bag_folders.file(text)
        try:
            facts = path.stat()
        except OSError as error:  # it was just deleted
            raise RequestError(f"{untrusted(str(path))}: {error.strerror}") from None
        return path, facts.st_dev, facts.st_ino

    def _release_key(self, key: _Key) -> None:
        with self._lock:
            entry = self._entries.get(key)
            if entry is None:
                return
            entry.users -= 1
            if entry.users:
                return
            del self._entries[key]
        if entry.bag is not None:
            entry.bag.close()
