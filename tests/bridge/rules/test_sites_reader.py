"""The setting `sites`: a list of names, or what each may do."""

from __future__ import annotations

import pytest

from pyros1.bridge.rules.file_reader import RulesError
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.site_access import SiteAccess


def read(sites: str) -> tuple[SiteAccess, ...]:
    return parse_config(f"site: base\nsites:\n{sites}\n", "f.yaml").rules.access


def texts(access: SiteAccess) -> tuple[list[str] | None, ...]:
    parts = (access.send, access.take, access.deny_send, access.deny_take)
    return tuple(None if part is None else [pattern.text for pattern in part] for part in parts)


def test_a_list_of_names() -> None:
    assert read("- red\n- red-2\n- red") == (SiteAccess("red"), SiteAccess("red-2"))
    assert parse_config("site: base\nsites: red", "f").rules.access == (SiteAccess("red"),)


def test_a_mapping() -> None:
    """Feature: where sites connect, rules say what each of them may send and take, by the name in its certificate"""
    red, blue, green, hub = read(
        "  red: {send: [/odom, 'base:/goal'], deny_send: /odom/raw}\n  blue:\n  green: {deny_take: ['base:/secret']}\n"
        "  hub: {forwards: [far, farther]}"
    )
    assert texts(red) == (["/odom", "base:/goal"], [], ["/odom/raw"], [])  # it may take nothing
    assert texts(blue) == texts(hub) == (None, None, [], [])
    assert texts(green) == (None, None, [], ["base:/secret"])
    assert hub.forwards == ("far", "farther") and not hub.is_limited and green.is_limited


@pytest.mark.parametrize(
    ("sites", "complaint"),
    [
        ("  []", "f.yaml:2: name at least one site"),
        ("  {}", "f.yaml:2: name at least one site"),
        ("- r-d", "f.yaml:3: 'r-d' cannot be a site's name"),
        ("- red-1-2", "f.yaml:3: 'red-1-2' cannot be a site's name"),
        ("- red: {}", "f.yaml:3: expected a string"),
        ("  r-d:", "f.yaml:3: 'r-d' cannot be a site's name"),
        ("  5:", "f.yaml:2: expected a string"),
        ("  red: [/odom]", "f.yaml:3: expected a mapping"),
        ("  red:\n    sent: []", "f.yaml:4: there is no setting 'sent' (did you mean 'send'?)"),
        ("  red:\n    send: [odom]", "f.yaml:4: 'odom' is not a pattern"),
        ("  red:\n    send: ['!/odom']", "f.yaml:4: write topics that a site may not send or take under deny_send"),
        ("  red:\n    take: ['/odom@5']", "f.yaml:4: '/odom@5' has a rate, which only the rules of the sites"),
        ("  red:\n    forwards: [far-2]", "f.yaml:4: 'far-2' cannot be a site's name"),
        ("  red:\n    forwards: 5", "f.yaml:4: expected a string"),
    ],
)
def test_mistakes(sites: str, complaint: str) -> None:
    with pytest.raises(RulesError) as caught:
        read(sites)
    assert str(caught.value).startswith(complaint)
