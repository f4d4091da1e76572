"""Keys: what a site writes begins with its name."""

from __future__ import annotations

import pytest

from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.key_expressions import Channel, Key, again_key, parse_key, site_key, to_key, topic_key

TOPIC = SharedName("red", "/camera/image")


@pytest.mark.parametrize(
    ("key", "text", "parsed"),
    [
        ("hello", "pyros1/1/base/hello", Key("base", Channel.HELLO)),
        (to_key("red"), "pyros1/1/base/to/red", Key("base", Channel.TO, "red")),
        (topic_key(TOPIC), "pyros1/1/base/t/red/camera/image", Key("base", Channel.TOPIC, "", TOPIC)),
        (
            again_key("blue", TOPIC),
            "pyros1/1/base/again/blue/red/camera/image",
            Key("base", Channel.AGAIN, "blue", TOPIC),
        ),
    ],
)
def test_keys(key: str, text: str, parsed: Key) -> None:
    assert site_key("base", key) == text and parse_key(text) == parsed


@pytest.mark.parametrize(
    "text",
    [
        *("", "pyros1/1", "pyros1/1/red", "pyros1/2/red/hello", "pyros1/1/red/hello/x", "pyros1/1/red/to"),
        *("pyros1/1/red/to/a/b", "pyros1/1/red/t", "pyros1/1/red/t/red", "pyros1/1/red/t/red//a", "pyros1/1/red/x/a/b"),
        *("pyros1/1/red/again/blue/red", "pyros1/1/red/t/red/a-b", "pyros1/1/red/t/red/" + "a" * 500),
    ],
)
def test_what_is_no_key(text: str) -> None:
    assert parse_key(text) is None
