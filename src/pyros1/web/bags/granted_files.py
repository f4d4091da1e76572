"""Bags that the user who runs the server has named in a terminal: pages may open them wherever they are stored.

The command in the terminal writes the bags' paths into a file next to the file with the server's link (see
`pyros1.web.links`). Only that user can read or write this file. Access to a bag thus depends on the user's rights on
this machine, not on the token, which other people may have.
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

MAX_LIST_SIZE = 1 << 20
"""Maximum size of the list in bytes; beyond that, the oldest paths are dropped."""
_GROUP_OR_OTHERS = 0o077
"""Permission bits of the file's group and of all other users."""


class GrantedFiles:
    """The list of bags that pages may open wherever they are stored, kept in a file.

    Args:
        file: path of the file, which contains one path per line as a JSON string.
    """

    def __init__(self, file: Path) -> None:
        self._file = file

    def add(self, paths: Iterable[str]) -> None:
        """Add bags to the list. Only one program at a time may call this.

        Raises:
            OSError: the file cannot be written, or too many bags are added at once; or the file exists, but cannot be
                trusted: it is a symbolic link, belongs to another user, or other users may read or write it.
        """
        new_lines = dict.fromkeys(json.dumps(os.path.realpath(path)) for path in paths)
        self._file.parent.mkdir(parents=True, exist_ok=True)
        try:
            existing = self._read_lines()
        except FileNotFoundError:
            existing = []
        lines = [*(line for line in dict.fromkeys(existing) if line not in new_lines), *new_lines]
        bytes_left, first = MAX_LIST_SIZE, len(lines)
        while first and (bytes_left := bytes_left - len(lines[first - 1]) - 1) >= 0:
            first -= 1
        if len(lines) - first < len(new_lines):
            raise OSError(errno.EFBIG, "too many bags at once", str(self._file))
        self._replace_file("".join(f"{line}\n" for line in lines[first:]))

    def __contains__(self, path: object) -> bool:
        """Return whether the list contains a path. The symbolic links in the path must have been resolved."""
        try:
            return json.dumps(str(path)) in self._read_lines()
        except (OSError, ValueError):
            return False

    def clear(self) -> None:
        """Remove all bags from the list."""
        with contextlib.suppress(OSError):
            self._file.unlink()

    def _read_lines(self) -> list[str]:
        """Return the file's lines. Raises OSError if the file cannot be read, or cannot be trusted."""
        if self._file.is_symlink():
            raise self._permission_error("is a symbolic link")
        # With O_NONBLOCK, opening a pipe does not block.
        flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
        with open(os.open(self._file, flags), "rb") as file:
            file_status = os.fstat(file.fileno())
            if not stat.S_ISREG(file_status.st_mode):
                raise self._permission_error("is not a regular file")
            if hasattr(os, "geteuid"):
                if file_status.st_uid != os.geteuid():
                    raise self._permission_error("belongs to another user")
                if file_status.st_mode & _GROUP_OR_OTHERS:
                    raise self._permission_error(
                        f"can be read or written by other users (mode {stat.S_IMODE(file_status.st_mode):o})"
                    )
            text = file.read(MAX_LIST_SIZE).decode("ascii", errors="replace")
        return [line for line in text.split("\n")[:-1] if line and line.isascii()]  # the last line may be cut off

    def _permission_error(self, reason: str) -> OSError:
        return PermissionError(errno.EPERM, f"the list of bags {reason}: remove this file", str(self._file))

    def _replace_file(self, text: str) -> None:
        """Replace the file's contents atomically, since the server may read it at any time."""
        # The temporary file is accessible to this user only.
        descriptor, temporary = tempfile.mkstemp(prefix=f"{self._file.name}.", dir=self._file.parent)
        try:
            with open(descriptor, "w", encoding="ascii") as file:
                file.write(text)
            os.replace(temporary, self._file)
        except BaseException:
            os.unlink(temporary)
            raise
