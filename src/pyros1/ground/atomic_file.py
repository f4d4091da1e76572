"""Text files that are written as a whole or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil


def write_atomically(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file. If that fails, as on a full disk, the old one stays as it was.

    Args:
        path: the file; a pipe or a device is written directly, and so is a file in a folder that cannot be changed.
        text: written as UTF-8.

    Raises:
        OSError: it cannot be written; it names the file.
    """
    target = os.path.realpath(path)  # of a link, write the target
    try:
        if os.path.exists(target) and not os.path.isfile(target):
            _write(target, text, "w")
        else:
            _replace(target, text)
    except OSError as error:
        error.filename, error.filename2 = os.fspath(path), None
        raise


def _replace(target: str, text: str) -> None:
    part = f"{target}.{os.getpid()}.part"
    try:
        _write(part, text, "x")
        if os.path.exists(target):
            shutil.copymode(target, part)
        os.replace(part, target)
    except OSError as error:
        with contextlib.suppress(OSError):
            os.unlink(part)
        if not isinstance(error, PermissionError):
            raise
        _write(target, text, "w")


def _write(path: str, text: str, mode: str) -> None:
    with open(path, mode, encoding="utf-8") as file:
        file.write(text)
