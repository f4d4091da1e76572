"""Writes text in pieces: a large one is never in memory as a whole."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType

Write = Callable[[str], object]

_SIZE = 1 << 16
"""Characters that are written at a time."""


class Pieces:
    """Gathers small pieces, cuts large ones, and writes them: in a ``with`` statement, whose end writes the rest.

    Args:
        write: takes a text.
        change: what is done with each before it is written, which may depend on characters that stand together in
            lines, and on line ends.
    """

    def __init__(self, write: Write, change: Callable[[str], str] | None = None) -> None:
        self._write = write
        self._change = change
        self._parts: list[str] = []
        self._size = 0

    def add(self, text: str) -> None:
        """Take a text."""
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
        keep = "\r" if not last and text.endswith("\r") else ""  # a line end may follow, and belong to it
        self._parts, self._size = [keep], len(keep)
        text = text[: len(text) - len(keep)]
        if text:
            self._write(text if self._change is None else self._change(text))

    def __enter__(self) -> Pieces:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            self._flush(last=True)
