"""A log file that is rotated when it reaches a size."""

from __future__ import annotations

import os
import sys
from typing import TextIO


class LogFile:
    """A log file, created with its folder at the first line. For one thread at a time.

    Args:
        path: the file; nothing is written if it is empty. Older parts are called ``<path>.1``, ``<path>.2`` and so on.
        most: bytes of one part.
        parts: older parts to keep.
    """

    def __init__(self, path: str, most: int, parts: int) -> None:
        self._path = path or None
        self._most = most
        self._parts = parts
        self._file: TextIO | None = None

    def write(self, text: str) -> None:
        """Append a text. An error, such as a full disk, is reported once on stderr; then nothing more is written."""
        if self._path is None:
            return
        try:
            if self._file is None:
                os.makedirs(os.path.dirname(self._path) or ".", exist_ok=True)
                self._file = open(self._path, "a", encoding="utf-8", errors="replace")  # noqa: SIM115 - stays open
            self._file.write(text)
            self._file.flush()
            if self._file.seekable() and self._file.tell() > self._most:
                self._rotate(self._file, self._path)
        except OSError as error:
            path, self._path = self._path, None
            sys.stderr.write(f"WARNING: cannot write the log file {path}: {error.strerror}; continuing without it\n")

    def again(self) -> LogFile:
        """Return another object for the same file, for a forked process."""
        return LogFile(self._path or "", self._most, self._parts)

    def _rotate(self, file: TextIO, path: str) -> None:
        file.close()
        self._file = None
        for number in range(self._parts - 1, 0, -1):
            if os.path.exists(f"{path}.{number}"):
                os.replace(f"{path}.{number}", f"{path}.{number + 1}")
        os.replace(path, f"{path}.1")

    def close(self) -> None:
        """Close the file; what is written later is lost."""
        if self._file is not None:
            self._file.close()
            self._file = None
        self._path = None
