"""Writes text in pieces, so that a large text is never completely in memory."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType

Write = Callable[[str], object]

_SIZE = 1 << 16
"""Number of characters to write at a time."""


class BufferedOutput:
    """Collects small pieces, splits large ones, and writes them. Use it in a ``with`` statement, which writes the rest.

    Args:
        write: writes a text.
        change: changes each text before it is written. It may depend on neighbouring characters in lines, and on
            line ends.
    """

    def __init__(self, write: Write, change: Callable[[str], str] | None = None) -> None:
        self._write = write
        self._change = change
        self._parts: list[str] = []
        self._size = 0

    def add(self, text: str) -> None:
        """Add a text."""
        if len(text) > _SIZE:
            for start in range(0, len(text), _SIZE):
                self.add(text[start : start + _SIZE])
            return
        self._parts.append(text)
        self._size += len(text)
        if self._size >= _SIZE:
            self._flush()

    def _flush(self, *, last: bool = False) -> None:
        text = "".join(self._parts)
        kept_size = "\r" if not last and text.endswith("\r") else ""  # a line end that belongs to it may follow
        self._parts, self._size = [kept_size], len(kept_size)
        text = text[: len(text) - len(kept_size)]
        if text:
            self._write(text if self._change is None else self._change(text))

    def __enter__(self) -> BufferedOutput:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            self._flush(last=True)
