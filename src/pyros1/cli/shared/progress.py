"""A progress line for long operations, on terminals only."""

from __future__ import annotations

import os
import sys
import time

_UPDATE_PERIOD = 0.2
"""Minimum time between updates of the line in seconds."""


class Progress:
    """Displays the percentage of bytes processed so far and an estimate of the remaining time.

    Args:
        name: the name of the file.
        total: the total number of bytes.
        quiet: whether to display nothing.
    """

    def __init__(self, name: str, total: int, *, quiet: bool = False) -> None:
        self._name = name
        self._total = max(total, 1)
        self._is_enabled = not quiet and sys.stderr.isatty()
        self._started_at = self._last_update_at = time.monotonic()
        self._is_drawn = False

    def __call__(self, processed_bytes: int) -> None:
        """Set the number of bytes processed so far. The line is only redrawn from time to time."""
        if not self._is_enabled:
            return
        now = time.monotonic()
        if now - self._last_update_at < _UPDATE_PERIOD:
            return
        self._last_update_at = now
        fraction = min(processed_bytes / self._total, 1.0)
        remaining = (now - self._started_at) * (1 / fraction - 1) if fraction > 0 else 0.0
        status_text = (
            f" {100 * fraction:3.0f}% of {self._total / 1e6:.1f} MB, {remaining // 60:.0f}:{remaining % 60:02.0f} left "
        )
        self._draw(status_text)

    def close(self) -> None:
        """Remove the progress line."""
        if self._is_drawn:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _draw(self, status_text: str) -> None:
        try:
            width = os.get_terminal_size(sys.stderr.fileno()).columns or 80
        except OSError:
            width = 80
        name_width = max(width - len(status_text) - 1, 0)
        name = self._name if len(self._name) <= name_width else "..." + self._name[len(self._name) - name_width + 3 :]
        sys.stderr.write(f"\r{name[:name_width]}{status_text}\x1b[K")
        sys.stderr.flush()
        self._is_drawn = True
