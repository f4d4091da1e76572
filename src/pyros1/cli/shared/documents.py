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
    """A document is longer than `MAX_DOCUMENT_LENGTH`."""


def read_documents(lines: Iterable[str], source_name: str | None = None) -> Iterator[Any]:
    """Yield each non-empty document as soon as the ``---`` line after it or the end of the stream is read.

    A line with a JSON object is a separate document, so that the output of ``topic echo --json`` can be read.

    Args:
        lines: the lines to read, for example a text file.
        source_name: the name of the source, for error messages.

    Raises:
        Error: a document is not valid YAML, or is too long.
    """
    document_lines: list[str] = []
    length = 0
    for line in lines:
        if line.rstrip() == "---":
            yield from _parse_document(document_lines, source_name)
            document_lines, length = [], 0
            continue
        if not document_lines and line.startswith("{"):
            json_document = _parse_json_line(line)
            if json_document is not None:
                yield json_document
                continue
        document_lines.append(line)
        length += len(line)
        if length > MAX_DOCUMENT_LENGTH:
            raise DocumentTooLongError(
                f"{source_name or 'the input'} contains a document of more than {MAX_DOCUMENT_LENGTH} characters"
            )
    yield from _parse_document(document_lines, source_name)


class JsonDocument(dict[str, Any]):
    """A document read from a line of JSON."""


def _parse_json_line(line: str) -> JsonDocument | None:
    try:
        value = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return JsonDocument(value) if isinstance(value, dict) else None


def _parse_document(lines: list[str], source_name: str | None) -> Iterator[Any]:
    text = "".join(lines)
    if text.strip():
        document = load_yaml(text, source_name)
        if document is not None:
            yield document
