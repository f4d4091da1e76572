"""What a command prints has no control characters but its own, whoever sent what it prints.

Names and texts of others are cleaned where they are printed, see `pyros1.shown`; this is the net below. What a command
itself writes to steer a terminal, colours and the like, passes if it writes to one.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, TextIO

from pyros1 import shown

_OWN = "(\x1b\\[(?:[0-9;]*m|[0-9;]*H|[0-2]?J|K|\\?(?:25|1049)[hl])|\r)"


_clean = partial(shown.lines, keep_bytes=True)


class CleanStream:
    """A text stream that writes to another.

    Args:
        stream: the other.

    Attributes:
        under: the other.
    """

    def __init__(self, stream: TextIO) -> None:
        self.under = stream
        self._steers = stream.isatty()

    def write(self, text: str) -> int:
        """Write a text, cleaned."""
        if not text.isprintable():
            if self._steers and ("\x1b" in text or "\r" in text):
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
        """For data: the other stream, if that is no terminal."""
        return self.under if not self._steers else self  # type: ignore[return-value]

    def __iter__(self) -> Iterator[str]:
        return iter(self.under)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.under, name)


@contextmanager
def clean_output() -> Iterator[None]:
    """Let stdout and stderr be such streams meanwhile."""
    out, err = sys.stdout, sys.stderr
    ours: tuple[Any, Any] = (CleanStream(out), CleanStream(err))
    sys.stdout, sys.stderr = ours
    try:
        yield
    finally:
        if sys.stdout is ours[0]:
            sys.stdout = out
        if sys.stderr is ours[1]:
            sys.stderr = err


def data_stream() -> TextIO:
    """Return the stream for data that must stay exact when it goes to a program or a file, such as CSV."""
    stream: TextIO = getattr(sys.stdout, "exact", sys.stdout)
    return stream
