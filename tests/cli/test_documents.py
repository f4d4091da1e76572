"""YAML documents from a stream."""

from __future__ import annotations

import pytest

from pyros1.cli.documents import documents
from pyros1.errors import Error


def test_each_document_comes_when_its_end_was_read() -> None:
    read: list[str] = []

    def lines() -> object:
        for line in ("a: 1\n", "---\n", "---\n", "b: 2\n"):
            read.append(line)
            yield line

    source = documents(lines())  # type: ignore[arg-type]  # a generator is an iterable
    assert next(source) == {"a": 1}
    assert read == ["a: 1\n", "---\n"]
    assert list(source) == [{"b": 2}]


def test_a_broken_document_is_an_error() -> None:
    with pytest.raises(Error):
        list(documents(["{a"]))
