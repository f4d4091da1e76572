"""names: grammar, resolution and remapping (N01-N05, N08, N12-N17)."""

from __future__ import annotations

import pytest

from pyros1.ground import names
from pyros1.ground.errors import InvalidNameError


@pytest.mark.parametrize("name", ["a", "/a", "~a", "a/b", "/", "A_1", "", "~"])
def test_n01_legal_names(name: str) -> None:
    assert names.is_legal_name(name)


@pytest.mark.parametrize("name", ["1a", "a//b", "a-b", "a b", "/a:b", "ä", "a\n"])
def test_n01_illegal_names(name: str) -> None:
    assert not names.is_legal_name(name)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("a", "/ns/a"),
        ("/a", "/a"),
        ("~a", "/ns/me/a"),
        ("", "/ns/"),
        ("a/b/", "/ns/a/b"),
        ("~", "/ns/me"),
        ("~/a", "/ns/me/a"),
    ],
)
def test_n03_resolve(name: str, expected: str) -> None:
    assert names.resolve_name(name, "/ns/me") == expected


def test_n04_remapping_is_exact_and_single() -> None:
    mapping = {"/ns/a": "/b", "/b": "/c"}
    assert names.resolve_name("a", "/ns/me", mapping) == "/b"
    assert names.resolve_name("a/x", "/ns/me", mapping) == "/ns/a/x"


def test_illegal_name_says_what_is_allowed() -> None:
    with pytest.raises(InvalidNameError, match="'my-topic' is not a legal ROS name"):
        names.resolve_name("my-topic", "/me")


@pytest.mark.parametrize(("name", "expected"), [("/a/b", "/a/"), ("/a", "/"), ("/a/b/", "/a/"), ("/", "/"), ("a", "/")])
def test_namespace(name: str, expected: str) -> None:
    assert names.namespace(name) == expected


@pytest.mark.parametrize(
    ("ns", "name", "expected"),
    [
        ("/a", "b", "/a/b"),
        ("/a/", "b", "/a/b"),
        ("/a", "/b", "/b"),
        ("/a", "~b", "~b"),
        ("~", "b", "~b"),
        ("", "b", "b"),
    ],
)
def test_ns_join(ns: str, name: str, expected: str) -> None:
    assert names.ns_join(ns, name) == expected


def test_n12_to_n17_arguments_are_sorted() -> None:
    arguments = names.parse_arguments(["x", "a:=b", "_rate:=0", "__name:=other", "/p:=~q", "--flag", "k:=v:=w", "3:=4"])
    assert arguments.remappings == {"a": "b", "/p": "~q"}
    assert arguments.parameters == {"rate": "0"}
    assert arguments.special == {"__name": "other"}
    assert arguments.rest == ["x", "--flag", "3:=4"]
    assert arguments.malformed == ["k:=v:=w"]
    assert arguments.resolved_remappings("/ns/me") == {"/ns/a": "/ns/b", "/p": "/ns/me/q"}


def test_n09_anonymous_name() -> None:
    assert names.anonymous_name("talker", 12, 345) == "talker_12_345"
