"""The open bags, which all pages share, and the current recording."""

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

MAX_OPEN_BAGS = 16
"""Maximum number of bags open at the same time."""
MAX_COMPLETE_READS = 3
"""Maximum number of bags that are read completely at the same time, for plots; further plots wait."""


_FileKey = tuple[Path, int, int]
"""A file's path, device and inode. The path is not enough, since another file may replace a bag while it is open."""


class _Entry:
    def __init__(self) -> None:
        self.num_users = 0
        self.bag: OpenBag | None = None
        self.open_lock = threading.Lock()


class Library:
    """Keeps track of open bags and of the recording.

    Args:
        bag_folders: the folders that pages may see.
        may_see: returns whether pages may see a topic.

    Attributes:
        read_slots: semaphore that a thread must hold while it reads a whole bag.
        recording: the current or last recording; None if there was none.
    """

    def __init__(self, bag_folders: BagFolders, may_see: Callable[[str], bool]) -> None:
        self.bag_folders = bag_folders
        self.read_slots = threading.BoundedSemaphore(MAX_COMPLETE_READS)
        self.recording: Recording | None = None
        self._may_see = may_see
        self._lock = threading.Lock()
        self._entries: dict[_FileKey, _Entry] = {}

    def open(self, raw_path: str, progress: Callable[[int], object]) -> OpenBag:
        """Open a bag, or return it if it is already open. Each call must be matched by one call of `release`.

        Args:
            raw_path: the bag's path, as sent by the page.
            progress: called with the number of bytes read so far while a bag without an index is scanned; may raise an
                error to stop the scan.

        Raises:
            RequestError: pages are not allowed to see the bag, or too many bags are open.
            BagError: the bag cannot be read.
        """
        key = self._file_key(raw_path)
        with self._lock:
            entry = self._entries.get(key)
            if entry is None:
                if len(self._entries) >= MAX_OPEN_BAGS:
                    raise RequestError(f"{MAX_OPEN_BAGS} bags are open: close one of them first")
                entry = self._entries[key] = _Entry()
            entry.num_users += 1
        try:
            with entry.open_lock:
                if entry.bag is None:
                    from pyros1.web.bags.open_bag import OpenBag  # noqa: PLC0415 - rarely needed

                    entry.bag = OpenBag(str(key[0]), self._may_see, progress)
                return entry.bag
        except BaseException:
            self._release_key(key)
            raise

    def borrow(self, raw_path: str) -> OpenBag:
        """Return a bag that is already open, and keep it open until `release` is called.

        Raises:
            RequestError: the bag is not open.
        """
        key = self._file_key(raw_path)
        with self._lock:
            entry = self._entries.get(key)
            if entry is None or entry.bag is None:
                replaced = any(path == key[0] for path, *_ in self._entries)
                raise RequestError("this file has been replaced: open it again" if replaced else "this bag is not open")
            entry.num_users += 1
            return entry.bag

    def release(self, bag: OpenBag) -> None:
        """Release an opened or borrowed bag. The bag is closed when all its users have released it."""
        with self._lock:
            key = next((key for key, entry in self._entries.items() if entry.bag is bag), None)
        if key is not None:
            self._release_key(key)

    def record(self, begin: Callable[[], Recording]) -> None:
        """Start a recording.

        Args:
            begin: creates and starts the recording.

        Raises:
            RequestError: a recording is running.
        """
        with self._lock:
            if self.recording is not None and self.recording.is_running:
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

    def _file_key(self, raw_path: str) -> _FileKey:
        path = self.bag_folders.find_file(raw_path)
        try:
            file_status = path.stat()
        except OSError as error:  # the file was just deleted
            raise RequestError(f"{untrusted(str(path))}: {error.strerror}") from None
        return path, file_status.st_dev, file_status.st_ino

    def _release_key(self, key: _FileKey) -> None:
        with self._lock:
            entry = self._entries.get(key)
            if entry is None:
                return
            entry.num_users -= 1
            if entry.num_users:
                return
            del self._entries[key]
        if entry.bag is not None:
            entry.bag.close()
