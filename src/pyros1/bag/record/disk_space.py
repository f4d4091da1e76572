"""Prevents a recording from filling the disk (B22)."""

from __future__ import annotations

import os
import time
from collections.abc import Callable

from pyros1.bag.errors import BagError

_CHECK_PERIOD = 1.0
_WARN_PERIOD = 20.0
_WARN_FACTOR = 5


class SpaceGuard:
    """Checks the free space of a disk about once a second.

    Args:
        folder: a folder on the disk.
        minimum: number of bytes that must stay free.
        warn: called with a warning, at most every 20 s, while less than five times the minimum is free.
    """

    def __init__(self, folder: str, minimum: int, warn: Callable[[str], object]) -> None:
        self._folder = folder
        self._minimum = minimum
        self._warn = warn
        self._next_check_at = self._next_warning_at = 0.0

    def check(self) -> None:
        """Check the free space, if the last check was at least a second ago.

        Raises:
            BagError: less than the minimum is free.
        """
        now = time.monotonic()
        if now < self._next_check_at or not hasattr(os, "statvfs"):
            return
        self._next_check_at = now + _CHECK_PERIOD
        try:
            disk = os.statvfs(self._folder)
        except OSError:
            return  # the write will report the error
        free, minimum = disk.f_bavail * disk.f_frsize, self._minimum
        if free < minimum:
            raise BagError(
                self._folder,
                f"less than {_gibibytes_text(minimum)} of space is free on the disk: free some, or see --min-space",
            )
        if free < _WARN_FACTOR * minimum and now >= self._next_warning_at:
            self._next_warning_at = now + _WARN_PERIOD
            self._warn(f"Less than {_gibibytes_text(_WARN_FACTOR * minimum)} of space free on the disk.")


def _gibibytes_text(size: int) -> str:
    return f"{size / (1 << 30):.3g} GiB"
