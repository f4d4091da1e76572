"""A line that shows the progress of long work, on terminals only."""

from __future__ import annotations

import os
import sys
import time

_PERIOD = 0.2


class Progress:
    """Shows the fraction of bytes that are processed, and an estimate of the remaining time.

    Args:
        name: the name to show.
        total: total number of bytes.
        quiet: show nothing.
    """

    def __init__(self, name: str, total: int, *, quiet: bool = False) -> None:
        self._name = name
        self._total = max(total, 1)
        self._is_shown = not quiet and sys.stderr.isatty()
        self._begin = self._last = time.monotonic()
        self._drawn = False

    def __call__(self, done: int) -> None:
        """Show how many bytes are done."""
        if not self._is_shown:
            return
        now = time.monotonic()
        if now - self._last < _PERIOD:
            return
        self._last = now
        share = min(done / self._total, 1.0)
        remaining = (now - self._begin) * (1 / share - 1) if share > 0 else 0.0
        tail = f" {100 * share:3.0f}% of {self._total / 1e6:.1f} MB, {remaining // 60:.0f}:{remaining % 60:02.0f} left "
        self._draw(tail)

    def close(self) -> None:
        """Remove the line."""
        if self._drawn:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _draw(self, tail: str) -> None:
        try:
            width = os.get_terminal_size(sys.stderr.fileno()).columns or 80
        except OSError:
            width = 80
        room = max(width - len(tail) - 1, 0)
        name = self._name if len(self._name) <= room else "..." + self._name[len(self._name) - room + 3 :]
        sys.stderr.write(f"\r{name[:room]}{tail}\x1b[K")
        sys.stderr.flush()
        self._drawn = True
