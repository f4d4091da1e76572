"""YAML documents, or lines of JSON, from a stream that may never end, such as a pipe."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any

from pyros1.ground.errors import Error
from pyros1.values import load_yaml

MAX_DOCUMENT = 64 << 20
"""Maximum number of characters in a document."""


class DocumentTooLongError(Error):
    """A document is too long."""


def documents(lines: Iterable[str], where: str | None = None) -> Iterator[Any]:
    """Yield each document as soon as the ``---`` line after it, or the end, has been read. Skip empty documents.

    A line with a JSON object is a separate document, so the output of ``topic echo --json`` can be read here.

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
        if not part and line.startswith("{"):
            record = _json_line(line)
            if record is not None:
                yield record
                continue
        part.append(line)
        size += len(line)
        if size > MAX_DOCUMENT:
            raise DocumentTooLongError(
                f"{where or 'the input'} contains a document of more than {MAX_DOCUMENT} characters"
            )
    yield from _document(part, where)


class Record(dict[str, Any]):
    """A document from a line of JSON."""


def _json_line(line: str) -> Record | None:
    try:
        value = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return Record(value) if isinstance(value, dict) else None


def _document(part: list[str], where: str | None) -> Iterator[Any]:
    text = "".join(part)
    if text.strip():
        document = load_yaml(text, where)
        if document is not None:
            yield document
