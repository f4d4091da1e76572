"""YAML documents from a stream."""

from __future__ import annotations

import pytest

from pyros1.cli.shared.documents import JsonDocument, read_documents
from pyros1.ground.errors import Error


def test_each_document_comes_when_its_end_was_read() -> None:
    read: list[str] = []

    def lines() -> object:
        for line in ("a: 1\n", "---\n", "---\n", "b: 2\n"):
            read.append(line)
            yield line

    source = read_documents(lines())  # type: ignore[arg-type]  # a generator is an iterable
    assert next(source) == {"a": 1}
    assert read == ["a: 1\n", "---\n"]
    assert list(source) == [{"b": 2}]


def test_a_broken_document_is_an_error() -> None:
    with pytest.raises(Error):
        list(read_documents(["{a"]))


def test_lines_of_json_are_documents() -> None:
    """`topic pub` reads what `topic echo --json` prints."""
    lines = ['{"data": "a"}\n', '{"data": "---"}\n', "{data: yaml}\n", "---\n", "{data: 1,\n", " more: 2}\n"]
    got = list(read_documents(lines))
    assert got == [{"data": "a"}, {"data": "---"}, {"data": "yaml"}, {"data": 1, "more": 2}]
    assert [isinstance(document, JsonDocument) for document in got] == [True, True, False, False]
