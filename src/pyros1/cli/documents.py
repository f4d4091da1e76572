"""YAML documents from a stream that may be endless, such as a pipe."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from pyros1.errors import Error
from pyros1.values import load_yaml

MAX_DOCUMENT = 64 << 20
"""Most characters of one document."""


class DocumentTooLongError(Error):
    """A stream goes on without a separator."""


def documents(lines: Iterable[str], where: str | None = None) -> Iterator[Any]:
    """Yield each document when the ``---`` line behind it, or the end, was read; empty ones are left out.

    Args:
        lines: a text file, or anything that yields lines.
        where: its name, for errors.

    Raises:
        Error: a document is not YAML, or too long.
    """
    part: list[str] = []
    size = 0
    for line in lines:
        if line.rstrip() == "---":
            yield from _document(part, where)
            part, size = [], 0
            continue
        part.append(line)
        size += len(line)
        if size > MAX_DOCUMENT:
            raise DocumentTooLongError(
                f"{where or 'the input'} holds a document of more than {MAX_DOCUMENT} characters"
            )
    yield from _document(part, where)


def _document(part: list[str], where: str | None) -> Iterator[Any]:
    text = "".join(part)
    if text.strip():
        document = load_yaml(text, where)
        if document is not None:
            yield document
