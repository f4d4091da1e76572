"""Writes strings in chunks, so that a large output is never held in memory as a whole."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType

WriteFunction = Callable[[str], object]

_CHUNK_SIZE = 1 << 16
"""Number of characters to write at a time."""


class BufferedOutput:
    """Collects small strings, splits large ones, and writes the result in chunks. Use it in a ``with`` statement.

    Args:
        write: the function that writes each chunk.
        transform: called with each chunk; returns the text to write. If None, chunks are written unchanged. A chunk may
            end within a line, but not between a carriage return and a line feed.
    """

    def __init__(self, write: WriteFunction, transform: Callable[[str], str] | None = None) -> None:
        self._write = write
        self._transform = transform
        self._parts: list[str] = []
        self._size = 0

    def add(self, text: str) -> None:
        """Add a string to the output. Chunks are written as soon as they are full."""
        if len(text) > _CHUNK_SIZE:
            for start in range(0, len(text), _CHUNK_SIZE):
                self.add(text[start : start + _CHUNK_SIZE])
            return
        self._parts.append(text)
        self._size += len(text)
        if self._size >= _CHUNK_SIZE:
            self._flush()

    def _flush(self, *, is_last: bool = False) -> None:
        text = "".join(self._parts)
        carried_over = "\r" if not is_last and text.endswith("\r") else ""  # "\n" may follow
        self._parts, self._size = [carried_over], len(carried_over)
        text = text[: len(text) - len(carried_over)]
        if text:
            self._write(text if self._transform is None else self._transform(text))

    def __enter__(self) -> BufferedOutput:
        return self

    def __exit__(
        self, error_type: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if error_type is None:
            self._flush(is_last=True)
