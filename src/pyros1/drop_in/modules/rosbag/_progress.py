"""Shows progress on one line of the terminal."""

from __future__ import annotations

import shutil
import sys
import time


class ProgressMeter:
    """Shows on one line of the terminal how much of a file has been processed.

    Args:
        path: path of the file.
        bytes_total: size of the file.
        refresh_rate: seconds between updates of the line.

    Attributes:
        bytes_read: number of bytes processed.
        elapsed: seconds since the beginning.
    """

    def __init__(self, path: str, bytes_total: int, refresh_rate: float = 1.0) -> None:
        self.path = path
        self.bytes_total = bytes_total
        self.refresh_rate = refresh_rate
        self.bytes_read = 0
        self.elapsed = 0.0
        self.update_elapsed = 0.0
        self.start_time = time.time()
        self._show()

    def step(self, bytes_read: int, force_update: bool = False) -> None:
        """Set the number of bytes processed; with ``force_update``, show it immediately."""
        self.bytes_read = bytes_read
        self.elapsed = time.time() - self.start_time
        if force_update or self.elapsed - self.update_elapsed > self.refresh_rate:
            self._show()
            self.update_elapsed = self.elapsed

    def finish(self) -> None:
        """Show that the whole file has been processed, and end the line."""
        self.step(self.bytes_total, force_update=True)
        print()

    def _show(self) -> None:
        done = self.bytes_read / self.bytes_total if self.bytes_total else 1.0
        if self.bytes_read >= self.bytes_total:
            status = f"100%{_size_text(self.bytes_total):>20} {_format_duration(self.elapsed)}    "
        else:
            eta = _format_duration(self.elapsed * (1 / done - 1)) if done else "--:--"
            status = f"{int(100 * done):3d}% {_size_text(self.bytes_read)} / {_size_text(self.bytes_total)} {eta} ETA"
        width = max(self.terminal_width() - 37, 3)  # columns that the status leaves for the path
        name = self.path if len(self.path) <= width else "..." + (self.path[3 - width :] if width > 3 else "")
        sys.stdout.write(f"\r {name:<{max(width, 7)}} {status}")
        sys.stdout.flush()

    @staticmethod
    def terminal_width() -> int:
        """Return the number of columns of the terminal; 80 if there is none."""
        return shutil.get_terminal_size((80, 24)).columns


def _size_text(count: float) -> str:
    for unit in ("KB", "MB", "GB"):
        count /= 1024
        if count < 1024:
            return f"{count:5.1f} {unit}"
    return f"{count / 1024:5.1f} TB"


def _format_duration(seconds: float) -> str:
    minutes, remaining_seconds = divmod(int(seconds), 60)
    return f"{minutes:02d}:{remaining_seconds:02d}"
