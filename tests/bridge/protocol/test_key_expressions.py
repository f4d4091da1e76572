"""Keys: what a site writes begins with its name."""

from __future__ import annotations

from random import Random

import pytest

from pyros1.bridge.names import Pattern, SharedName
from pyros1.bridge.protocol.key_expressions import (
    Channel,
    Key,
    direct_topic_key,
    parse_key,
    path_key,
    peer_key,
    site_key,
    topic_key,
)

TOPIC = SharedName("red", "/camera/image")


@pytest.mark.parametrize(
    ("key", "text", "parsed"),
    [
        ("hello", "pyros1/1/base/hello", Key("base", Channel.HELLO)),
        (peer_key("red"), "pyros1/1/base/to/red", Key("base", Channel.TO, "red")),
        (topic_key(TOPIC), "pyros1/1/base/t/red/camera/image", Key("base", Channel.TOPIC, "", TOPIC)),
        (
            direct_topic_key("blue", TOPIC),
            "pyros1/1/base/again/blue/red/camera/image",
            Key("base", Channel.DIRECT, "blue", TOPIC),
        ),
    ],
)
def test_keys(key: str, text: str, parsed: Key) -> None:
    assert site_key("base", key) == text and parse_key(text) == parsed


@pytest.mark.parametrize(
    "text",
    [
        *("pyros1/1/*/hello", "pyros1/1/**/to/base", "pyros1/1/a b/hello", "pyros1/1/r\u00e9d/hello"),
        *("pyros1/1/red/t/*/odom", "pyros1/1/red/again/base/**/odom", f"pyros1/1/{'r' * 41}/hello"),
        *("", "pyros1/1", "pyros1/1/red", "pyros1/2/red/hello", "pyros1/1/red/hello/x", "pyros1/1/red/to"),
        *("pyros1/1/red/to/a/b", "pyros1/1/red/t", "pyros1/1/red/t/red", "pyros1/1/red/t/red//a", "pyros1/1/red/x/a/b"),
        *("pyros1/1/red/again/blue/red", "pyros1/1/red/t/red/a-b", "pyros1/1/red/t/red/" + "a" * 500),
    ],
)
def test_what_is_no_key(text: str) -> None:
    assert parse_key(text) is None


@pytest.mark.parametrize(
    ("path", "key"),
    [
        ("/odom", "/odom"),
        ("/camera/**", "/camera/**"),
        ("/cam*/image", "/cam$*/image"),
        ("/*/*_raw", "/*/$*_raw"),
        ("/**/**/a", "/**/a"),
        ("/**/*/a", "/*/**/a"),
    ],
)
def test_patterns_of_topics(path: str, key: str) -> None:
    assert path_key(path) == key


def test_zenoh_matches_what_patterns_match() -> None:
    zenoh = pytest.importorskip("zenoh")
    random = Random(1)
    matches = 0
    for _ in range(2000):
        parts = random.choices(["*", "**", "a", "b", "a*", "*b", "a*b", "*a*"], k=random.randint(1, 4))
        pattern = Pattern("/" + "/".join(parts))
        name = "/" + "/".join(random.choices(["a", "b", "ab", "aab"], k=random.randint(1, 4)))
        expression = zenoh.KeyExpr(f"t/red{path_key(pattern.path)}")
        assert expression.includes(zenoh.KeyExpr(f"t/red{name}")) == pattern.matches_name(name), (pattern, name)
        matches += pattern.matches_name(name)
    assert matches > 100
