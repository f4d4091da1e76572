"""Writes text files completely or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil


def write_atomically(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file. If that fails, for example because the disk is full, the old file remains unchanged.

    Args:
        path: the file; a pipe, a device, or a file in a read-only folder is written directly.
        text: the content, which is written as UTF-8.

    Raises:
        OSError: the file cannot be written; the error's ``filename`` is `path`.
    """
    target = os.path.realpath(path)  # a symbolic link is kept: the file that it points to is written
    try:
        if os.path.exists(target) and not os.path.isfile(target):
            _write(target, text, "w")
        else:
            _replace(target, text)
    except OSError as error:
        error.filename, error.filename2 = os.fspath(path), None
        raise


def _replace(target: str, text: str) -> None:
    temporary_path = f"{target}.{os.getpid()}.part"
    try:
        _write(temporary_path, text, "x")
        if os.path.exists(target):
            shutil.copymode(target, temporary_path)
        os.replace(temporary_path, target)
    except OSError as error:
        with contextlib.suppress(OSError):
            os.unlink(temporary_path)
        if not isinstance(error, PermissionError):
            raise
        _write(target, text, "w")


def _write(path: str, text: str, mode: str) -> None:
    with open(path, mode, encoding="utf-8") as file:
        file.write(text)
