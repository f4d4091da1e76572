"""A bag that is being recorded: named ``.active`` until it is closed, and written to disk every second.

If this process crashes, the messages of the last second may be lost; after a power failure, a few more.
"""

from __future__ import annotations

import contextlib
import errno
import os
import threading
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from io import FileIO
from typing import IO, Generic, TypeVar

from pyros1.bag.errors import BagError
from pyros1.bag.format.compression import Buffer
from pyros1.bag.format.writer import EMPTY_BAG_SIZE, BagWriter, Entries, entry_count

_K = TypeVar("_K")

ACTIVE_SUFFIX = ".active"
FLUSH_INTERVAL = 0.9
"""Time in seconds after which a chunk is closed even if it is not full."""

_LOCKED_MESSAGE = "another recording is writing this file"
_DISK_FULL_CODES = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def set_aside_leftover(path: str) -> str:
    """Rename a file that a killed recording left behind, so that a new recording can use its path.

    Args:
        path: path with the suffix ``.active``.

    Returns:
        The new path of the file; empty if there was none, or it contained no messages.

    Raises:
        BagError: another recording is writing to the file.
        OSError: the file cannot be renamed.
    """
    try:
        with open(path, "rb") as file:
            _lock(file)
            if os.fstat(file.fileno()).st_size <= EMPTY_BAG_SIZE:
                return ""
    except FileNotFoundError:
        return ""
    except BlockingIOError:
        raise BagError(path, _LOCKED_MESSAGE) from None
    suffix_number = 1
    while os.path.lexists(f"{path}.{suffix_number}"):
        suffix_number += 1
    os.rename(path, f"{path}.{suffix_number}")
    return f"{path}.{suffix_number}"


def _lock(file: IO[bytes] | FileIO) -> None:
    """Lock a file until it is closed; raise BlockingIOError if another process has locked it."""
    try:
        import fcntl  # noqa: PLC0415 - not on Windows

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except (OSError, ImportError):
        pass  # some file systems have no locks


class RecordWriter(BagWriter):
    """A writer that can close its bag on a full disk. It locks the file, so that other recordings do not use it.

    Attributes:
        lost: connection id -> number of messages that were lost because the disk was full.
    """

    def __init__(self, path: str, compression: str, chunk_threshold: int) -> None:
        super().__init__(path, compression, chunk_threshold)
        try:
            _lock(self._file)
        except BlockingIOError:
            self.abort()
            raise BagError(path, _LOCKED_MESSAGE) from None
        self.lost: Counter[int] = Counter()

    def _write_stored_chunk(self, compression: str, size: int, parts: Sequence[Buffer], entries: Entries) -> None:
        """Write a chunk; if it does not fit on the disk, count its messages as lost."""
        try:
            super()._write_stored_chunk(compression, size, parts, entries)
        except OSError:
            self.lost.update({conn: entry_count(packed) for conn, packed in entries.items()})
            raise

    def descriptor(self) -> int:
        """Return a descriptor of the file that stays valid after the bag is closed; the caller must close it."""
        return os.dup(self._file.fileno())

    def _write_end(self) -> None:
        """Write the index; if there is not enough space for it, remove the last chunks."""
        while True:
            try:
                super()._write_end()
                return
            except OSError as error:
                if error.errno not in _DISK_FULL_CODES or not self._chunks:
                    raise
            chunk = self._chunks.pop()
            self.lost.update(chunk.counts)
            self.messages -= sum(chunk.counts.values())
            self._size = chunk.pos
            self._file.truncate(chunk.pos)
            self._file.seek(chunk.pos)


class RecordFile(Generic[_K]):
    """An open recording.

    Args:
        path: final path of the file.
        compression: ``none``, ``bz2`` or ``lz4``.
        chunk_threshold: size in bytes above which a chunk is closed.

    Attributes:
        leftover_path: the new path of a file that a killed recording had left behind under this name; empty if there
            was none.

    Raises:
        BagError: another recording is writing to the file.
        OSError: the file cannot be created.
    """

    def __init__(self, path: str, compression: str, chunk_threshold: int) -> None:
        self.path = path
        if os.path.isdir(path):
            raise IsADirectoryError(
                errno.EISDIR, os.strerror(errno.EISDIR), path
            )  # before the recording: otherwise, renaming the file would fail at its end
        self.leftover_path = set_aside_leftover(path + ACTIVE_SUFFIX)
        self._writer = RecordWriter(path + ACTIVE_SUFFIX, compression, chunk_threshold)
        self._keys: dict[int, _K] = {}
        self._conn_ids: dict[_K, int] = {}
        self._flush_at = time.monotonic() + FLUSH_INTERVAL
        try:
            self._disk_sync = _DiskSync(self._writer.descriptor())
        except OSError:
            self._writer.abort()
            os.remove(path + ACTIVE_SUFFIX)
            raise

    @property
    def size(self) -> int:
        """Number of bytes written so far, including the open chunk."""
        return self._writer.size

    @property
    def messages(self) -> int:
        """Number of messages in the file."""
        return self._writer.messages

    def write(self, key: _K, topic: str, header: Mapping[str, str], stamp: int, data: bytes) -> None:
        """Write a message.

        Args:
            key: identifies its connection.
            topic: its topic.
            header: its publisher's connection header; like the topic, it is used only for the first message from a
                connection.
            stamp: receive time in nanoseconds.
            data: its bytes.

        Raises:
            BagError: the time cannot be stored in a bag.
            OSError: the file cannot be written.
        """
        conn = self._conn_ids.get(key)
        if conn is None:
            fields = {name: value.encode("utf-8", "surrogateescape") for name, value in header.items()}
            for name in ("type", "md5sum", "message_definition"):
                fields.setdefault(name, b"")
            conn = self._conn_ids[key] = self._writer.add_connection(topic, fields)
            self._keys[conn] = key
        self._writer.write(conn, stamp, data)

    def flush_if_due(self) -> None:
        """Flush data, and request a sync to disk, about once a second; must be called often.

        Raises:
            OSError: the file cannot be written.
        """
        now = time.monotonic()
        if now >= self._flush_at:
            self._flush_at = now + FLUSH_INTERVAL
            if self._writer.pending:
                self._writer.flush()
            self._disk_sync.request()

    @property
    def lost(self) -> dict[_K, int]:
        """Connection key -> number of messages that were lost because the disk was full."""
        return {self._keys[conn]: count for conn, count in self._writer.lost.items()}

    def discard(self) -> None:
        """Close and remove the file, which must not contain messages."""
        self._disk_sync.close()
        self._writer.abort()
        with contextlib.suppress(OSError):
            os.remove(self.path + ACTIVE_SUFFIX)

    def close(self) -> None:
        """Write the index and give the file its final name.

        Raises:
            OSError: the file cannot be written; it keeps the suffix ``.active`` and can be reindexed.
        """
        self._disk_sync.close()
        try:
            self._writer.close()
        except OSError as error:
            # The last chunk was lost on the full disk; the bag is still valid, unless even its index did not fit.
            if error.errno not in _DISK_FULL_CODES or not self._has_index():
                raise
        os.replace(self.path + ACTIVE_SUFFIX, self.path)

    def _has_index(self) -> bool:
        from pyros1.bag.format.files import BagFile  # noqa: PLC0415 - for a full disk only

        file = BagFile(self.path + ACTIVE_SUFFIX)
        try:
            return file.index_pos > 0
        finally:
            file.close()


class _DiskSync:
    """Syncs a file to disk in a separate thread, since this takes seconds on some disks."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._sync_requested = threading.Event()
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="bag:sync", daemon=True)
        self._thread.start()

    def request(self) -> None:
        """Request a sync. Requests made during a sync are combined into one, which follows it."""
        self._sync_requested.set()

    def close(self) -> None:
        """Stop the thread, without waiting for the disk."""
        self._closed = True
        self._sync_requested.set()
        self._thread.join(0.2)

    def _run(self) -> None:
        sync = getattr(os, "fdatasync", os.fsync)
        while True:
            self._sync_requested.wait()
            self._sync_requested.clear()
            if self._closed:
                break
            with contextlib.suppress(OSError):
                sync(self._descriptor)
        os.close(self._descriptor)
