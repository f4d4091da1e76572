"""Reads YAML documents or lines of JSON from a stream that may be endless, such as a pipe."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any

from pyros1.ground.errors import Error
from pyros1.values import load_yaml

MAX_DOCUMENT_LENGTH = 64 << 20
"""Maximum number of characters in a document."""


class DocumentTooLongError(Error):
    """A document is too long."""


def read_documents(lines: Iterable[str], source_name: str | None = None) -> Iterator[Any]:
    """Yield each document that is not empty, as soon as the ``---`` line after it or the end of the stream is read.

    A line with a JSON object is a separate document, so that the output of ``topic echo --json`` can be read.

    Args:
        lines: a text file or any other iterable of lines.
        source_name: the name of the source, for error messages.

    Raises:
        Error: a document is not YAML or is too long.
    """
    document_lines: list[str] = []
    size = 0
    for line in lines:
        if line.rstrip() == "---":
            yield from _parse_document(document_lines, source_name)
            document_lines, size = [], 0
            continue
        if not document_lines and line.startswith("{"):
            record = _parse_json_line(line)
            if record is not None:
                yield record
                continue
        document_lines.append(line)
        size += len(line)
        if size > MAX_DOCUMENT_LENGTH:
            raise DocumentTooLongError(
                f"{source_name or 'the input'} contains a document of more than {MAX_DOCUMENT_LENGTH} characters"
            )
    yield from _parse_document(document_lines, source_name)


class Record(dict[str, Any]):
    """A document read from a line of JSON."""


def _parse_json_line(line: str) -> Record | None:
    try:
        value = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return Record(value) if isinstance(value, dict) else None


def _parse_document(lines: list[str], source_name: str | None) -> Iterator[Any]:
    text = "".join(lines)
    if text.strip():
        document = load_yaml(text, source_name)
        if document is not None:
            yield document
