"""What each site may do."""

from __future__ import annotations

import pytest

from pyros1.bridge.names import SharedName, SiteNameError
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Rules
from pyros1.bridge.rules.site_access import SiteAccess, add_names, may_send, may_take, named_sites

FILE = """
site: base
take: ['*:**', /goal]
send: [/map, '*:/cmd_vel', 'red:/goal', '/plan']
sites:
  red: {send: [/odom, /camera/**, base:/goal], take: [/cmd_vel, base:/map], deny_send: [/camera/raw]}
  red-2: {send: [/new]}
  blue:
  hub: {forwards: [far]}
"""


@pytest.fixture
def rules() -> Rules:
    return parse_config(FILE, "f").rules


def name(text: str) -> SharedName:
    return SharedName(*text.split(":"))


@pytest.mark.parametrize(
    ("sender", "topic", "refused"),
    [
        ("red", "red:/odom", False),
        ("red", "red:/camera/image", False),
        ("red", "red:/camera/raw", True),
        ("red", "red:/scan", True),
        ("red", "base:/goal", False),
        ("red", "red:/goal", True),
        ("red", "red:/new", False),  # with its newer keys
        ("blue", "blue:/scan", False),
        ("blue", "base:/goal", False),
        ("far", "far:/scan", False),
    ],
)
def test_what_a_site_may_not_send_is_not_taken(rules: Rules, sender: str, topic: str, refused: bool) -> None:
    assert (rules.incoming(name(topic), sender) == f"{sender} may not send it") == refused


def test_what_a_site_may_not_take_is_not_sent(rules: Rules) -> None:
    def receivers(local: str) -> dict[str, list[str]]:
        others = ["red", "blue", "far"]
        return {str(each.shared): rules.receivers(each, others) for each in rules.outgoing(local, others)}

    assert receivers("/map") == {"base:/map": ["red", "blue", "far"]}
    assert receivers("/plan") == {"base:/plan": ["blue", "far"]}
    assert receivers("/red/cmd_vel") == {"red:/cmd_vel": ["red"]}
    assert receivers("/red/goal") == {"red:/goal": []}


def test_a_topic_of_a_third_site_is_never_taken() -> None:
    everything = SiteAccess("red")
    assert everything.may_take(name("base:/map"), "base") and everything.may_take(name("red:/map"), "base")
    assert not everything.may_take(name("blue:/cmd_vel"), "base")


def test_names(rules: Rules) -> None:
    assert rules.sites == named_sites(rules.access) == ("red", "blue", "hub", "far")
    access = add_names(rules.access, ["red", "red-3", "green", "green"])
    assert [each.keys for each in access] == ["red", "red-2", "blue", "hub", "red-3", "green"]
    assert access[0].is_limited and not access[-1].is_limited  # what is known of red stays
    assert may_send((), "red", name("red:/x")) and may_take((), "red", name("base:/x"), "base")
    with pytest.raises(SiteNameError):
        add_names((), ["red-x"])
