"""Determines the sizes of folders, and which of their files are in use."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from time import monotonic


def folder_size(path: Path, *, on_disk: bool = False, deadline: float | None = None) -> int:
    """Return the size in bytes of a file or folder. Symbolic links are not followed.

    Files with several hard links are counted once.

    Args:
        path: the file or folder.
        on_disk: whether to count disk usage instead of file sizes.
        deadline: the time on the monotonic clock in seconds at which to stop counting; None for no limit.
    """
    counted_inodes: set[tuple[int, int]] = set()
    total = 0
    for path_name in _walk(path):
        if deadline is not None and monotonic() > deadline:
            break
        try:
            status = os.lstat(path_name)
        except OSError:
            continue  # the file was removed
        if status.st_nlink > 1:
            if (status.st_dev, status.st_ino) in counted_inodes:
                continue
            counted_inodes.add((status.st_dev, status.st_ino))
        total += status.st_blocks * 512 if on_disk else status.st_size
    return total


def _walk(path: Path) -> Iterator[str]:
    yield str(path)
    if path.is_symlink():
        return
    for base, folders, files in os.walk(path):
        for name in (*folders, *files):
            yield os.path.join(base, name)


def format_size(size: int) -> str:
    """Return a size with a suitable unit, such as ``1.2 GB``.

    Args:
        size: the size in bytes.
    """
    scaled_size, unit = float(size), "B"
    for larger_unit in ("kB", "MB", "GB", "TB"):
        if scaled_size < 999.5:
            break
        scaled_size, unit = scaled_size / 1000, larger_unit
    return f"{scaled_size:.1f} {unit}" if unit != "B" and scaled_size < 9.95 else f"{scaled_size:.0f} {unit}"


def format_size_like_du(size: int) -> str:
    """Return a size in the format of ``du -h``, such as ``272K``: rounded up, with one decimal place below 10.

    Args:
        size: the size in bytes.
    """
    if size < 1024:
        return str(size)
    power = 0
    scale = 1
    while size > 1023 * scale and power < 5:  # 1023.5K is shown as 1.0M, not as 1024K
        power += 1
        scale *= 1024
    tenths = -(-size * 10 // scale)
    text = f"{tenths // 10}.{tenths % 10}" if tenths < 100 else str(-(-size // scale))
    return text + " KMGTP"[power]


def files_in_use(folder: Path) -> list[Path]:
    """Return the files below a folder that running programs have open; empty if the system does not report them.

    Args:
        folder: the folder. Links in its path are resolved, since the system reports the real paths of open files.
    """
    used_files: set[Path] = set()
    real_prefix = str(folder.resolve()) + os.sep
    for descriptors in Path("/proc").glob("[0-9]*/fd"):
        try:
            names = os.listdir(descriptors)
        except OSError:
            continue  # another user's process, or one that has exited
        for name in names:
            try:
                target = os.readlink(descriptors / name)
            except OSError:
                continue
            if target.startswith(real_prefix) and os.path.exists(target):
                used_files.add(folder / target[len(real_prefix) :])
    return sorted(used_files)
