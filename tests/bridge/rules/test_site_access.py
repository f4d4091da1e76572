"""What each site may do."""

from __future__ import annotations

import pytest

from pyros1.bridge.names import Pattern, SharedName, SiteNameError
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Rules
from pyros1.bridge.rules.services import PARAMETERS
from pyros1.bridge.rules.site_access import (
    SiteAccess,
    add_names,
    may_call,
    may_send,
    may_serve,
    may_take,
    named_sites,
)

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


SERVICES = """
site: base
sites:
  red: {serve: [/add, /arm/**], deny_serve: [/arm/off], call: [base:/plan, '*:/ping']}
  red-2: {call: [base:/new]}
  dumb: {send: [/odom], take: [/cmd_vel]}
  blue: {deny_serve: [/off], deny_call: [base:/off]}
  full: {serve: ['/**'], call: ['*:**']}
  green:
"""


@pytest.fixture
def access() -> tuple[SiteAccess, ...]:
    return parse_config(SERVICES, "f").rules.access


@pytest.mark.parametrize(
    ("service", "allowed"),
    [
        ("red:/add", True),
        ("red:/arm/on", True),
        ("red:/arm/off", False),
        ("red:/other", False),
        (f"red:{PARAMETERS}", False),
        ("dumb:/add", False),
        (f"dumb:{PARAMETERS}", False),
        ("blue:/add", True),
        ("blue:/off", False),
        (f"blue:{PARAMETERS}", True),
        (f"full:{PARAMETERS}", True),
        ("green:/add", True),
        ("unnamed:/add", True),  # whether it is talked to is another question
    ],
)
def test_which_services_a_site_may_serve(access: tuple[SiteAccess, ...], service: str, allowed: bool) -> None:
    assert may_serve(access, name(service).site, name(service)) is allowed


@pytest.mark.parametrize(
    ("caller", "service", "allowed"),
    [
        ("red", "base:/plan", True),
        ("red", "base:/ping", True),
        ("red", "blue:/ping", True),
        ("red", "blue:/plan", False),
        ("red", "base:/new", True),  # with its newer keys
        ("red", f"base:{PARAMETERS}", False),
        ("dumb", "base:/plan", False),
        ("dumb", f"base:{PARAMETERS}", False),
        ("blue", "base:/plan", True),
        ("blue", "base:/off", False),
        ("full", f"base:{PARAMETERS}", True),
        ("green", f"base:{PARAMETERS}", True),
        ("unnamed", "base:/plan", True),
    ],
)
def test_which_services_a_site_may_call(
    access: tuple[SiteAccess, ...], caller: str, service: str, allowed: bool
) -> None:
    assert may_call(access, caller, name(service)) is allowed


def test_sites_serve_their_own_services_and_call_those_of_others() -> None:
    everything = SiteAccess("red")
    assert everything.may_serve(name("red:/add")) and not everything.may_serve(name("base:/add"))
    assert everything.may_call(name("base:/add")) and not everything.may_call(name("red:/add"))


@pytest.mark.parametrize("verb", ["send", "take", "serve", "call"])
def test_who_is_limited_is_limited_in_everything(verb: str) -> None:
    with pytest.raises(ValueError, match="red is limited in some of send, take, serve and call, but not in all"):
        SiteAccess("red", **{verb: (Pattern("*:/x"),)})


def test_names(rules: Rules) -> None:
    assert rules.sites == named_sites(rules.access) == ("red", "blue", "hub", "far")
    access = add_names(rules.access, ["red", "red-3", "green", "green"])
    assert [each.keys for each in access] == ["red", "red-2", "blue", "hub", "red-3", "green"]
    assert access[0].is_limited and not access[-1].is_limited  # what is known of red stays
    assert may_send((), "red", name("red:/x")) and may_take((), "red", name("base:/x"), "base")
    with pytest.raises(SiteNameError):
        add_names((), ["red-x"])
