"""Parameters as a page shows them."""

from __future__ import annotations

import datetime
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.values import load_yaml
from pyros1.web.models.params import MAX_PARAMETERS, Changes, editable_yaml, flatten, summarize


def everything(_: str) -> bool:
    return True


def test_trees_become_names() -> None:
    assert dict(flatten({"a": {"b": 1, "c": {"d": [2]}}, "e": {}})) == {"/a/b": 1, "/a/c/d": [2], "/e": {}}
    assert list(flatten({})) == []


@pytest.mark.parametrize(
    ("value", "kind", "text"),
    [
        (True, "bool", "true"),
        (3, "int", "3"),
        (1.5, "double", "1.5"),
        (float("nan"), "double", ".nan"),
        (float("-inf"), "double", "-.inf"),
        ("a\nb", "text", "a\nb"),
        ("", "text", ""),
        ([1, [2, "x"]], "list", "[1, [2, x]]"),
        ({}, "dict", "{}"),
        (None, "null", "null"),
        (datetime.date(2026, 1, 2), "other", "2026-01-02"),
    ],
)
def test_values_are_shown(value: Any, kind: str, text: str) -> None:
    assert summarize(value) == (kind, text, False)


def test_long_values_are_cut() -> None:
    assert summarize("x" * 10_000) == ("text", "x" * 300, True)
    kind, text, more = summarize(list(range(10_000)))
    assert kind == "list" and len(text) <= 300 and more


def test_only_changes_are_told() -> None:
    changes = Changes()
    assert changes.update({"a": 1, "b": {"c": 2}}, everything) == {
        "all": True,
        "set": {"/a": ("int", "1", False), "/b/c": ("int", "2", False)},
        "gone": [],
        "more": 0,
    }
    assert changes.update({"a": 1, "b": {"c": 2}}, everything) is None
    found = changes.update({"a": 5, "d": ""}, everything)
    assert found is not None and not found["all"]
    assert list(found["set"]) == ["/a", "/d"] and found["gone"] == ["/b/c"]


def test_values_that_are_equal_but_of_another_kind_are_changes() -> None:
    changes = Changes()
    for value, kind in ((1, "int"), (1.0, "double"), (True, "bool")):
        found = changes.update({"a": value}, everything)
        assert found is not None and found["set"]["/a"].kind == kind


def test_what_may_not_be_seen_is_not_told() -> None:
    found = Changes().update({"a": 1, "b": 2}, lambda name: name == "/a")
    assert found is not None and list(found["set"]) == ["/a"]


def test_too_many_are_counted() -> None:
    found = Changes().update({f"p{number}": number for number in range(MAX_PARAMETERS + 7)}, everything)
    assert found is not None and len(found["set"]) == MAX_PARAMETERS and found["more"] == 7


@pytest.mark.parametrize("value", [1, 1.0, "a: b", "true", "", [1, 2], {"a": {"b": [[1], [2]]}}, "two\nlines\n", None])
def test_text_for_editing_is_the_value(value: Any) -> None:
    assert load_yaml(editable_yaml(value)) == value


@given(st.text(alphabet="ab :#'-|\n\t "))
def test_any_text_can_be_edited(value: str) -> None:
    assert load_yaml(editable_yaml(value)) == value


def test_text_of_several_lines_is_edited_as_it_is() -> None:
    assert editable_yaml("<a>\n  <b/>\n</a>\n") == "|\n  <a>\n    <b/>\n  </a>\n"
