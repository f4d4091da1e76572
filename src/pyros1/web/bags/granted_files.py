"""Bags that the user of a running server has named in a terminal: the page may open them wherever they are.

The command in the terminal writes their paths into a file next to the server's own (see `pyros1.web.links`), which only
that user can read and write. So access to a bag depends on the user's rights on this machine, not on the token, which
other people may have.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import stat
import tempfile
from collections.abc import Iterable
from pathlib import Path

MAX_BYTES = 1 << 20
"""Maximum size of the list in bytes; beyond that, the oldest paths are dropped."""
_GROUP_OR_OTHERS = 0o077
"""Permission bits of other users."""


class GrantedFiles:
    """The list of such bags.

    Args:
        file: the file, with one path per line, as JSON.
    """

    def __init__(self, file: Path) -> None:
        self._file = file

    def add(self, paths: Iterable[str]) -> None:
        """Add bags. Programs must not do so at the same time.

        Raises:
            OSError: the file cannot be written; or it exists, but cannot be trusted, since it is a link, belongs to
                another user, or other users may read or write it.
        """
        added = dict.fromkeys(json.dumps(os.path.realpath(path)) for path in paths)
        self._file.parent.mkdir(parents=True, exist_ok=True)
        try:
            before = self._lines()
        except FileNotFoundError:
            before = []
        lines = [*(line for line in dict.fromkeys(before) if line not in added), *added]
        room, first = MAX_BYTES, len(lines)
        while first and (room := room - len(lines[first - 1]) - 1) >= 0:
            first -= 1
        if len(lines) - first < len(added):
            raise OSError(errno.EFBIG, "too many bags at once", str(self._file))
        self._replace("".join(f"{line}\n" for line in lines[first:]))

    def __contains__(self, path: object) -> bool:
        """Return whether a path without links is in the list."""
        try:
            return json.dumps(str(path)) in self._lines()
        except (OSError, ValueError):
            return False

    def clear(self) -> None:
        """Remove all bags."""
        with contextlib.suppress(OSError):
            self._file.unlink()

    def _lines(self) -> list[str]:
        """Return the lines of the file. Raises OSError, including when the file cannot be trusted."""
        if self._file.is_symlink():
            raise self._distrust("is a symbolic link")
        flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)  # opening a pipe would block
        with open(os.open(self._file, flags), "rb") as file:
            facts = os.fstat(file.fileno())
            if not stat.S_ISREG(facts.st_mode):
                raise self._distrust("is not a file")
            if hasattr(os, "geteuid"):
                if facts.st_uid != os.geteuid():
                    raise self._distrust("belongs to another user")
                if facts.st_mode & _GROUP_OR_OTHERS:
                    raise self._distrust(f"may be read or written by others (mode {stat.S_IMODE(facts.st_mode):o})")
            text = file.read(MAX_BYTES).decode("ascii", errors="replace")
        return [line for line in text.split("\n")[:-1] if line and line.isascii()]  # the last line may be cut off

    def _distrust(self, reason: str) -> OSError:
        return PermissionError(errno.EPERM, f"the list of bags {reason}: remove it", str(self._file))

    def _replace(self, text: str) -> None:
        """Replace the file atomically, since the server may read it at any time."""
        number, made = tempfile.mkstemp(prefix=f"{self._file.name}.", dir=self._file.parent)  # for this user only
        try:
            with open(number, "w", encoding="ascii") as file:
                file.write(text)
            os.replace(made, self._file)
        except BaseException:
            os.unlink(made)
            raise
