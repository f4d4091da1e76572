"""Bags that the user of a running server has named in a terminal: the page may open them wherever they lie.

The terminal writes their paths into a file beside the server's note, which only that user can read and write. So what
opens a bag is the user's right to files of this machine, not the token, which others may have.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterable
from pathlib import Path

_MOST_BYTES = 1 << 20
_OTHERS = 0o077
"""Rights of other users."""


class Granted:
    """The list of such bags.

    Args:
        file: the file with one path in a line, as JSON.
    """

    def __init__(self, file: Path) -> None:
        self._file = file

    def add(self, paths: Iterable[str]) -> None:
        """Add bags. Raises OSError if the file cannot be written."""
        self._file.parent.mkdir(parents=True, exist_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0)
        with open(os.open(self._file, flags, 0o600), "w", encoding="ascii") as file:
            file.writelines(f"{json.dumps(os.path.realpath(path))}\n" for path in paths)

    def __contains__(self, path: object) -> bool:
        """Return whether a path without links is in the list."""
        try:
            with open(os.open(self._file, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0)), encoding="ascii") as file:
                facts = os.fstat(file.fileno())
                if hasattr(os, "geteuid") and (facts.st_uid != os.geteuid() or facts.st_mode & _OTHERS):
                    return False
                return json.dumps(str(path)) in file.read(_MOST_BYTES).splitlines()
        except (OSError, ValueError):
            return False

    def clear(self) -> None:
        """Forget all bags."""
        with contextlib.suppress(OSError):
            self._file.unlink()
