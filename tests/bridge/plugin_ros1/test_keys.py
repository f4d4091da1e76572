"""Keys of zenoh-plugin-ros1, as its source makes them."""

from __future__ import annotations

import pytest

from pyros1.bridge.plugin_ros1.keys import (
    Kind,
    Resource,
    beacon_key,
    beacon_patterns,
    data_key,
    is_source,
    is_usable,
    parse_beacon_key,
)

MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"
CHATTER = Resource(Kind.PUBLISHER, "std_msgs/String", MD5, "*", "/chatter")
BEACON = f"ros1_discovery_info/*/pub/7374645f6d7367732f537472696e67/{MD5}/*/chatter"
ROBOT_BEACON = f"ros1_discovery_info/*/sub/7374645f6d7367732f537472696e67/{MD5}/robot1/deep/er/chatter"


def test_keys_of_messages() -> None:
    assert data_key(CHATTER) == f"7374645f6d7367732f537472696e67/{MD5}/*/chatter"
    assert data_key(CHATTER._replace(namespace="robot1", name="/a/b")).endswith(f"{MD5}/robot1/a/b")
    assert data_key(CHATTER, old_keys=True) == f"7374645f6d7367732f537472696e67/{MD5}/chatter"


def test_keys_of_beacons() -> None:
    robots = Resource(Kind.SUBSCRIBER, "std_msgs/String", MD5, "robot1", "/deep/er/chatter")
    for resource, key in ((CHATTER, BEACON), (robots, ROBOT_BEACON)):
        assert beacon_key(resource) == key and parse_beacon_key(key) == resource
    assert beacon_patterns(["b", "a"]) == ["ros1_discovery_info/*/*/*/*/a/*/**", "ros1_discovery_info/*/*/*/*/b/*/**"]
    assert beacon_patterns(["a", "*"]) == ["ros1_discovery_info/*/*/*/*/*/*/**"]


def test_which_beacons_announce_sources() -> None:
    assert is_source(BEACON) and is_source(BEACON.replace("pub", "srv"))
    assert not is_source(ROBOT_BEACON) and not is_source(BEACON.replace("pub", "cl")) and not is_source("short")


@pytest.mark.parametrize(
    "change",
    [
        ("ros1_discovery_info", "other"),
        ("/pub/", "/other/"),
        ("/*/pub", "/pool/pub"),  # another spelling of the same resource would be counted twice
        ("7374645f6d7367732f537472696e67", "7374645F6D7367732F537472696E67"),
        ("7374645f6d7367732f537472696e67", "2a"),
        ("7374645f6d7367732f537472696e67", "ff"),
        ("7374645f6d7367732f537472696e67", "737"),
        ("7374645f6d7367732f537472696e67", "2e2e2f61"),  # ../a
        (MD5, "*"),
        (MD5, MD5.upper()),
        ("/*/chatter", "/a$*/chatter"),
        ("/*/chatter", "//chatter"),
        ("chatter", "a-b"),
        ("chatter", "a//b"),
        ("chatter", "a" * 300),
        ("/chatter", ""),
    ],
)
def test_keys_that_are_ignored(change: tuple[str, str]) -> None:
    key = BEACON.replace(*change)
    assert key != BEACON and parse_beacon_key(key) is None


def test_what_can_be_announced() -> None:
    assert is_usable(CHATTER)
    assert not is_usable(CHATTER._replace(type="*")) and not is_usable(CHATTER._replace(md5sum="*"))
    assert not is_usable(CHATTER._replace(type="a/" + "b" * 300))
