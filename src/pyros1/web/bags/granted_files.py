"""Bags that the user of a running server has named in a terminal: pages may open them wherever they are stored.

The command in the terminal writes their paths into a file next to the file with the server's link (see
`pyros1.web.links`). Only that user can read and write this list. Access to a bag thus depends on the user's rights on
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

MAX_BYTES = 1 << 20
"""Maximum size of the list in bytes; beyond that, the oldest paths are dropped."""
_GROUP_OR_OTHERS = 0o077
"""Permission bits of the file's group and of all other users."""


class GrantedFiles:
    """The list of bags that pages may open wherever they are stored.

    Args:
        file: path of the file that contains the list, with one path per line, as JSON.
    """

    def __init__(self, file: Path) -> None:
        self._file = file

    def add(self, paths: Iterable[str]) -> None:
        """Add bags to the list. Only one program may do so at a time.

        Raises:
            OSError: the file cannot be written; or it exists, but cannot be trusted, since it is a link, belongs to
                another user, or other users may read or write it.
        """
        new_lines = dict.fromkeys(json.dumps(os.path.realpath(path)) for path in paths)
        self._file.parent.mkdir(parents=True, exist_ok=True)
        try:
            existing = self._read_lines()
        except FileNotFoundError:
            existing = []
        lines = [*(line for line in dict.fromkeys(existing) if line not in new_lines), *new_lines]
        bytes_left, first = MAX_BYTES, len(lines)
        while first and (bytes_left := bytes_left - len(lines[first - 1]) - 1) >= 0:
            first -= 1
        if len(lines) - first < len(new_lines):
            raise OSError(errno.EFBIG, "too many bags at once", str(self._file))
        self._replace_file("".join(f"{line}\n" for line in lines[first:]))

    def __contains__(self, path: object) -> bool:
        """Return whether a path is in the list; symbolic links in it must have been resolved."""
        try:
            return json.dumps(str(path)) in self._read_lines()
        except (OSError, ValueError):
            return False

    def clear(self) -> None:
        """Remove all bags from the list."""
        with contextlib.suppress(OSError):
            self._file.unlink()

    def _read_lines(self) -> list[str]:
        """Return the lines of the file. Raises OSError, including when the file cannot be trusted."""
        if self._file.is_symlink():
            raise self._permission_error("is a symbolic link")
        flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)  # opening a pipe would block
        with open(os.open(self._file, flags), "rb") as file:
            file_status = os.fstat(file.fileno())
            if not stat.S_ISREG(file_status.st_mode):
                raise self._permission_error("is not a file")
            if hasattr(os, "geteuid"):
                if file_status.st_uid != os.geteuid():
                    raise self._permission_error("belongs to another user")
                if file_status.st_mode & _GROUP_OR_OTHERS:
                    raise self._permission_error(
                        f"can be read or written by other users (mode {stat.S_IMODE(file_status.st_mode):o})"
                    )
            text = file.read(MAX_BYTES).decode("ascii", errors="replace")
        return [line for line in text.split("\n")[:-1] if line and line.isascii()]  # the last line may be cut off

    def _permission_error(self, reason: str) -> OSError:
        return PermissionError(errno.EPERM, f"the list of bags {reason}: remove it", str(self._file))

    def _replace_file(self, text: str) -> None:
        """Replace the file atomically, since the server may read it at any time."""
        descriptor, temporary = tempfile.mkstemp(
            prefix=f"{self._file.name}.", dir=self._file.parent
        )  # accessible to this user only
        try:
            with open(descriptor, "w", encoding="ascii") as file:
                file.write(text)
            os.replace(temporary, self._file)
        except BaseException:
            os.unlink(temporary)
            raise
