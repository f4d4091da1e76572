"""File names of recordings. Does no I/O."""

from __future__ import annotations

import time
from dataclasses import dataclass


@dataclass(frozen=True)
class FileNames:
    """The file names of a recording (B17).

    Attributes:
        prefix: the beginning of the names; may contain a folder, and the suffix ``.bag``.
        has_date: whether the date is appended.
        has_number: whether a number is appended, starting at 0.
    """

    prefix: str = ""
    has_date: bool = True
    has_number: bool = False

    def name(self, file_number: int, start_time: float) -> str:
        """Return a file's name.

        Args:
            file_number: number of the file.
            start_time: time at which the file begins, in seconds since the epoch.
        """
        parts = [self.prefix.removesuffix(".bag")] if self.prefix else []
        if self.has_date:
            parts.append(time.strftime("%Y-%m-%d-%H-%M-%S", time.localtime(start_time)))
        if self.has_number:
            parts.append(str(file_number))
        return "_".join(parts) + ".bag"
