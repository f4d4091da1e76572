"""A log file that is rotated at a maximum size, and continues after a full disk."""

from __future__ import annotations

import contextlib
import os
import sys
from io import FileIO
from time import monotonic

RETRY_INTERVAL = 5.0
"""Seconds between a failed attempt to write and the next attempt."""


class LogFile:
    """A log file, created together with its folder when the first line is written. Not thread-safe.

    An error, such as a full disk, is reported once on stderr. Lines in the next RETRY_INTERVAL seconds are dropped;
    then writing is tried again, and the file says how many lines are missing.

    Args:
        path: path of the file; if the path is empty, nothing is written. Older parts are called ``<path>.1``,
            ``<path>.2`` and so on.
        max_size: maximum size of a part in bytes.
        num_backups: number of older parts to keep.
    """

    def __init__(self, path: str, max_size: int, num_backups: int) -> None:
        self._path = path or None
        self._max_size = max_size
        self._num_backups = num_backups
        self._file: FileIO | None = None
        self._is_line_incomplete = False  # whether the file ends with part of a line
        self._num_lost = 0
        self._failure_reason = ""
        self._retry_at = 0.0  # monotonic time

    def write(self, text: str) -> None:
        """Append lines. Errors are reported on stderr, not raised."""
        if self._path is None:
            return
        if self._num_lost and monotonic() < self._retry_at:
            self._num_lost += text.count("\n")
            return
        try:
            if self._file is None:
                os.makedirs(os.path.dirname(self._path) or ".", exist_ok=True)
                self._file = open(self._path, "ab", buffering=0, opener=_open_nonblocking)  # noqa: SIM115 - stays open
            if self._num_lost:
                line_break = "\n" if self._is_line_incomplete else ""
                self._append(
                    self._file,
                    f"{line_break}... {self._num_lost} lines are missing here: {self._failure_reason}\n",
                )
                self._num_lost = 0
            self._append(self._file, text)
            if self._file.seekable() and self._file.tell() > self._max_size:
                self._rotate(self._file, self._path)
        except OSError as error:
            self._record_failure(self._path, error, text)

    def _append(self, file: FileIO, text: str) -> None:
        data = memoryview(text.encode("utf-8", "replace"))
        while data:
            data = data[os.write(file.fileno(), data) :]  # a disk that becomes full accepts only the beginning
            self._is_line_incomplete = bool(data)

    def _record_failure(self, path: str, error: OSError, text: str) -> None:
        if self._file is not None:
            self._file.close()  # the next attempt reopens it, since its disk may be available again
            self._file = None
        self._failure_reason = error.strerror or str(error)
        if not self._num_lost:
            with contextlib.suppress(Exception):  # stderr may be on the same disk
                sys.stderr.write(f"WARNING: cannot write the log file {path}: {self._failure_reason}; lines are lost\n")
        self._num_lost += max(1, text.count("\n"))
        self._retry_at = monotonic() + RETRY_INTERVAL

    def reopened(self) -> LogFile:
        """Return another `LogFile` for the same file, for use in a forked process."""
        return LogFile(self._path or "", self._max_size, self._num_backups)

    def _rotate(self, file: FileIO, path: str) -> None:
        file.close()
        self._file = None
        for part_number in range(self._num_backups - 1, 0, -1):
            if os.path.exists(f"{path}.{part_number}"):
                os.replace(f"{path}.{part_number}", f"{path}.{part_number + 1}")
        os.replace(path, f"{path}.1")

    def close(self) -> None:
        """Close the file; anything written later is dropped."""
        if self._file is not None:
            self._file.close()
            self._file = None
        self._path = None


def _open_nonblocking(path: str, flags: int) -> int:
    """Open a file; raise OSError for a pipe without a reader, instead of blocking."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0), 0o666)
