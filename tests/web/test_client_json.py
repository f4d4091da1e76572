"""JSON of clients: of any width, and of a depth that no code fails on."""

from __future__ import annotations

import json

import pytest

from pyros1.web.client_json import MAX_NESTING_DEPTH, loads


@pytest.mark.parametrize(("begin", "end"), [("[", "]"), ('{"a": ', "}"), ('[1, {"a": 2, "b": ', "}]")])
def test_depth(begin: str, end: str) -> None:
    levels = begin.count("[") + begin.count("{")
    whole = begin * (MAX_NESTING_DEPTH // levels) + "1" + end * (MAX_NESTING_DEPTH // levels)
    assert loads(whole) == loads(whole.encode()) == json.loads(whole)
    for count in (MAX_NESTING_DEPTH // levels + 1, 300, 900, 9000, 300_000):
        with pytest.raises(ValueError, match="nested too deeply"):
            loads(begin * count + "1" + end * count)


def test_width_and_other_texts() -> None:
    wide = [[number, {"a": [number]}] for number in range(1000)]
    assert loads(json.dumps(wide)) == wide
    assert loads('"' + "[" * 1000 + '"') == "[" * 1000
    for text in ("", "[", "nonsense", "[" * 1000, b"\xff"):
        with pytest.raises(ValueError):
            loads(text)
