"""Removes control characters from a command's output.

Names and messages from other programs are cleaned where they are printed, see `pyros1.ground.terminal_text`. This is a
second line of defence. The command's own escape sequences, such as colours, are kept if the output is a terminal.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, TextIO

from pyros1.ground import terminal_text

_ALLOWED_SEQUENCES = "(\x1b\\[(?:[0-9;]*m|[0-9;]*H|[0-2]?J|K|\\?(?:25|1049)[hl])|\r)"
"""Matches a carriage return or an escape sequence that commands themselves print on terminals."""


_clean_text = partial(terminal_text.lines, keep_bytes=True)


class CleanStream:
    """A text stream that removes control characters from what is written to it, and passes the rest to another stream.

    Args:
        stream: the stream that receives the cleaned text.

    Attributes:
        underlying: the stream that receives the cleaned text.
    """

    def __init__(self, stream: TextIO) -> None:
        self.underlying = stream
        self._keeps_escape_sequences = stream.isatty()

    def write(self, text: str) -> int:
        """Clean a string and write it. Return the number of characters written."""
        if not text.isprintable():
            if self._keeps_escape_sequences and ("\x1b" in text or "\r" in text):
                parts = enumerate(re.split(_ALLOWED_SEQUENCES, text))
                text = "".join(part if index % 2 else _clean_text(part) for index, part in parts)
            else:
                text = _clean_text(text)
        return self.underlying.write(text)

    def writelines(self, lines: Any) -> None:
        """Clean and write several strings."""
        for line in lines:
            self.write(line)

    @property
    def exact(self) -> TextIO:
        """The stream to write data to: the underlying stream, which does not change the data.

        On a terminal, where control characters in the data could do harm, it is this `CleanStream` instead.
        """
        return self.underlying if not self._keeps_escape_sequences else self  # type: ignore[return-value]

    def __iter__(self) -> Iterator[str]:
        return iter(self.underlying)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.underlying, name)


@contextmanager
def clean_output() -> Iterator[None]:
    """Replace stdout and stderr with `CleanStream` objects for the duration of a ``with`` statement."""
    original_stdout, original_stderr = sys.stdout, sys.stderr
    clean_streams: tuple[Any, Any] = (CleanStream(original_stdout), CleanStream(original_stderr))
    sys.stdout, sys.stderr = clean_streams
    try:
        yield
    finally:
        if sys.stdout is clean_streams[0]:
            sys.stdout = original_stdout
        if sys.stderr is clean_streams[1]:
            sys.stderr = original_stderr


def data_stream() -> TextIO:
    """Return the stream for data, such as CSV. Programs and files receive the data unchanged, a terminal cleaned."""
    stream: TextIO = getattr(sys.stdout, "exact", sys.stdout)
    return stream
