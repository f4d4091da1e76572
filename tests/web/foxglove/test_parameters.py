"""Parameters in the form of frames."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from pyros1.web.foxglove.parameters import ParameterValues, entries, entry, value_to_set
from pyros1.web.foxglove.requests import FrameError, SetParameter


@pytest.mark.parametrize(
    ("value", "wanted"),
    [
        (3, {"value": 3}),
        (3.0, {"value": 3.0, "type": "float64"}),
        (math.inf, {"value": "inf"}),
        (True, {"value": True}),
        ("x", {"value": "x"}),
        ([1, 2], {"value": [1, 2]}),
        ([1.0, 2.5], {"value": [1.0, 2.5], "type": "float64_array"}),
        ([1.0, math.nan], {"value": [1.0, "nan"]}),
        ([], {"value": []}),
        (b"ABCD", {"value": "QUJDRA==", "type": "byte_array"}),
        ({"a": {"b": b"A"}}, {"value": {"a": {"b": "QQ=="}}}),
        (None, {}),
    ],
)
def test_values_that_are_told(value: Any, wanted: dict[str, Any]) -> None:
    found = entry("/a", value)
    assert found == {"name": "/a", **wanted}
    json.dumps(found, allow_nan=False)


def test_names_of_parameters_and_namespaces() -> None:
    values = ParameterValues({"a": 1, "ns": {"b": 2, "empty": {}, "deep": {"c": 3}}})
    assert [*values.flat] == ["/a", "/ns/b", "/ns/deep/c", "/ns/empty"]
    assert entries(values, ["/ns/deep", "/none", "/a", "/a"]) == [
        {"name": "/ns/deep", "value": {"c": 3}},
        {"name": "/none"},
        {"name": "/a", "value": 1},
    ]
    assert len(entries(values, [])) == 4
    assert values.get("/a/b/c") is None


def test_names_with_slashes_that_go_through_values() -> None:
    values = ParameterValues({"a": {"b/c": 1, "b": 5, "": 6, "b/c/d": {}}})
    assert values.flat == {"/a/": 6, "/a/b": 5, "/a/b/c": 1, "/a/b/c/d": {}}
    assert [each["value"] for each in entries(values, ["/a/b", "/a/b/c", "/a/"])] == [5, 1, 6]


def test_only_what_may_be_seen() -> None:
    values = ParameterValues({"open": {"a": 1}, "secret": {"b": 2}}, lambda name: name.startswith("/open"))
    assert values.flat == {"/open/a": 1}
    assert values.get("/secret") is None
    assert values.get("/secret/b") is None
    assert values.get("/") == {"open": {"a": 1}}


@pytest.mark.parametrize(
    ("value", "kind", "wanted"),
    [
        (3, "", 3),
        (3, "float64", 3.0),
        ([1, 2.5], "float64_array", [1.0, 2.5]),
        ("QUJDRA==", "byte_array", b"ABCD"),
        ({"a": [True]}, "", {"a": [True]}),
    ],
)
def test_values_to_set(value: Any, kind: str, wanted: Any) -> None:
    found = value_to_set(SetParameter("/a", value, kind))
    assert found == wanted
    assert type(found) is type(wanted)


@pytest.mark.parametrize(
    ("value", "kind"),
    [
        ("x", "float64"),
        (True, "float64"),
        (10**400, "float64"),
        ([1, "x"], "float64_array"),
        (3, "float64_array"),
        ("?", "byte_array"),
        (3, "byte_array"),
        (3, "colour"),
    ],
    ids=range(8),
)
def test_values_that_do_not_fit(value: Any, kind: str) -> None:
    with pytest.raises(FrameError):
        value_to_set(SetParameter("/a", value, kind))
