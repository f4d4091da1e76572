"""Output streams that remove control characters from what a command prints.

Names and texts from other programs are cleaned where they are printed, see `pyros1.ground.terminal_text`. This is a
second line of defence. Escape sequences of the command itself, such as colours, pass if the output is a terminal.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, TextIO

from pyros1.ground import terminal_text

_OWN = "(\x1b\\[(?:[0-9;]*m|[0-9;]*H|[0-2]?J|K|\\?(?:25|1049)[hl])|\r)"


_clean = partial(terminal_text.lines, keep_bytes=True)


class CleanStream:
    """A text stream that cleans text and writes it to another stream.

    Args:
        stream: the stream to write to.

    Attributes:
        under: the same stream.
    """

    def __init__(self, stream: TextIO) -> None:
        self.under = stream
        self._passes_controls = stream.isatty()

    def write(self, text: str) -> int:
        """Clean a text and write it."""
        if not text.isprintable():
            if self._passes_controls and ("\x1b" in text or "\r" in text):
                parts = enumerate(re.split(_OWN, text))
                text = "".join(part if number % 2 else _clean(part) for number, part in parts)
            else:
                text = _clean(text)
        return self.under.write(text)

    def writelines(self, texts: Any) -> None:
        """Write several texts."""
        for text in texts:
            self.write(text)

    @property
    def exact(self) -> TextIO:
        """Return the stream for data: `under`, unless it is a terminal."""
        return self.under if not self._passes_controls else self  # type: ignore[return-value]

    def __iter__(self) -> Iterator[str]:
        return iter(self.under)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.under, name)


@contextmanager
def clean_output() -> Iterator[None]:
    """Replace stdout and stderr with clean streams in a ``with`` statement."""
    out, err = sys.stdout, sys.stderr
    streams: tuple[Any, Any] = (CleanStream(out), CleanStream(err))
    sys.stdout, sys.stderr = streams
    try:
        yield
    finally:
        if sys.stdout is streams[0]:
            sys.stdout = out
        if sys.stderr is streams[1]:
            sys.stderr = err


def data_stream() -> TextIO:
    """Return the stream for data, such as CSV, that must not change on the way to a program or a file."""
    stream: TextIO = getattr(sys.stdout, "exact", sys.stdout)
    return stream
