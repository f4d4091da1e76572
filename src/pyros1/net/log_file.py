"""A log file that grows to a limit, and its older parts."""

from __future__ import annotations

import os
import sys
from typing import TextIO


class LogFile:
    """Opened, with its folder, at the first line. To be used by one thread at a time.

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
        """Append a text. Trouble, such as a full disk, is told once on stderr; nothing more is written then."""
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
            sys.stderr.write(f"WARNING: cannot write the log file {path}: {error.strerror}; going on without it\n")

    def again(self) -> LogFile:
        """Return another one that goes on with the same file, for a forked process."""
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
