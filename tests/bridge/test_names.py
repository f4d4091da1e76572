"""Names among sites, and patterns."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.bridge.names import Pattern, SharedName, SiteNameError, check_site_name, is_topic_name, parse_shared_name


@pytest.mark.parametrize("name", ["red", "r", "Robot_7", "a" * 40])
def test_names_of_sites(name: str) -> None:
    assert check_site_name(name) == name


@pytest.mark.parametrize("name", ["", "7red", "red-1", "red/blue", "a" * 41, "*", "red\n", "rød"])
def test_what_cannot_be_a_site(name: str) -> None:
    with pytest.raises(SiteNameError, match="cannot be a site's name"):
        check_site_name(name)


def test_names_of_topics() -> None:
    assert is_topic_name("/a/b_c9")
    for name in ("", "/", "a", "/a/", "//a", "/a-b", "/a b", "/" + "a" * 255, "~a"):
        assert not is_topic_name(name), name


def test_shared_names() -> None:
    assert parse_shared_name("red:/odom") == SharedName("red", "/odom")
    assert str(SharedName("red", "/odom")) == "red:/odom"
    for text in ("", "red", "/odom", ":/odom", "red:odom", "red:/a:/b", "*:/odom"):
        with pytest.raises(SiteNameError, match="is not a site and a topic"):
            parse_shared_name(text)


@pytest.mark.parametrize(
    ("pattern", "matching", "other"),
    [
        ("/odom", ["red:/odom"], ["red:/odom2", "red:/a/odom", "blue:/odom"]),
        ("/camera/**", ["red:/camera", "red:/camera/a", "red:/camera/a/b"], ["red:/camera2", "red:/a/camera/b"]),
        ("/*/odom", ["red:/a/odom"], ["red:/odom", "red:/a/b/odom"]),
        ("/**/image", ["red:/image", "red:/a/b/image"], ["red:/a/image2", "red:/image/a"]),
        ("/cam*/im*ge", ["red:/cam/image", "red:/camera/imge"], ["red:/came/ra/image"]),
        ("blue:/odom", ["blue:/odom"], ["red:/odom", "green:/odom"]),
        ("blue:**", ["blue:/odom", "blue:/a/b"], ["red:/odom"]),
        ("*:/odom", ["blue:/odom", "green:/odom"], ["red:/odom", "blue:/a"]),
        ("red:/odom", ["red:/odom"], ["blue:/odom"]),
    ],
)
def test_patterns(pattern: str, matching: list[str], other: list[str]) -> None:
    parsed = Pattern(pattern)
    assert [parsed.matches(parse_shared_name(name), "red") for name in matching + other] == [True] * len(matching) + [
        False
    ] * len(other)


@pytest.mark.parametrize(
    "text",
    ["", "odom", "/", "/a//b", "/a/", "red:", ":/odom", "a b:/c", "/***", "/a**", "/a-b", "7:/a", "/" + "a" * 255],
)
def test_what_is_no_pattern(text: str) -> None:
    with pytest.raises(SiteNameError):
        Pattern(text)


def test_patterns_cannot_take_long() -> None:
    assert not Pattern("/**/a" * 40 + "/b").matches_name("/a" * 120)
    assert not Pattern("/" + "a*" * 100 + "b").matches_name("/" + "a" * 250)


@given(st.text("ab*/", min_size=1, max_size=10), st.text("ab/", min_size=1, max_size=10))
def test_patterns_match_as_regular_expressions_do(pattern: str, name: str) -> None:
    try:
        parsed = Pattern(f"/{pattern}")
    except SiteNameError:
        return
    expression = "".join(
        "(?:/[^/]+)*" if part == "**" else "/" + part.replace("*", "[^/]*") for part in pattern.split("/")
    )
    if is_topic_name(f"/{name}"):
        assert parsed.matches_name(f"/{name}") == bool(re.fullmatch(expression, f"/{name}"))


def test_parts_of_patterns() -> None:
    assert Pattern("/odom").is_literal and not Pattern("/odom/*").is_literal
    assert [Pattern(text).subtree for text in ("/a/**", "red:**", "/a", "/a/*", "/*/**")] == [
        "/a",
        "",
        None,
        None,
        None,
    ]
