"""The setting `sites`: a list of names, or what each may do."""

from __future__ import annotations

import pytest

from pyros1.bridge.rules.file_reader import RulesError
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.site_access import SiteAccess


def read(sites: str) -> tuple[SiteAccess, ...]:
    return parse_config(f"site: base\nsites:\n{sites}\n", "f.yaml").rules.access


def texts(access: SiteAccess) -> tuple[list[str] | None, ...]:
    parts = (access.send, access.take, access.serve, access.call)
    parts += (access.deny_send, access.deny_take, access.deny_serve, access.deny_call)
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
    assert texts(red) == (["/odom", "base:/goal"], [], [], [], ["/odom/raw"], [], [], [])  # it may take nothing
    assert texts(blue) == texts(hub) == (None, None, None, None, [], [], [], [])
    assert texts(green) == (None, None, None, None, [], ["base:/secret"], [], [])
    assert hub.forwards == ("far", "farther") and not hub.is_limited and green.is_limited


def test_services() -> None:
    """Feature: where sites connect, rules say which services each of them may offer and call"""
    red, blue, green = read(
        "  red-2: {serve: [/add, 'red:/spawn'], deny_serve: /spawn/all}\n  blue: {call: ['base:**', '*:/add']}\n"
        "  green: {deny_call: 'base:/secret'}"
    )
    assert texts(red) == ([], [], ["/add", "red:/spawn"], [], [], [], ["/spawn/all"], [])  # and no topics
    assert texts(blue) == ([], [], [], ["base:**", "*:/add"], [], [], [], [])
    assert texts(green) == (None, None, None, None, [], [], [], ["base:/secret"])
    assert red.is_limited and blue.is_limited and green.is_limited
    (deaf,) = read("  deaf: {deny_serve: '/**'}")
    assert deaf.is_limited and deaf.serve is None


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
        ("  red:\n    send: ['!/odom']", "f.yaml:4: write what a site may not send under deny_send, without !"),
        ("  red:\n    take: ['/odom@5']", "f.yaml:4: '/odom@5' has a rate, which only the rules of the sites"),
        ("  red:\n    serve: [/add]\n    serves: []", "f.yaml:5: there is no setting 'serves' (did you mean 'serve'?)"),
        ("  red:\n    serve: [add]", "f.yaml:4: 'add' is not a pattern of services"),
        ("  red:\n    serve: [/add@5]", "f.yaml:4: '/add@5' is not a pattern of services"),
        ("  red:\n    serve: ['base:/add']", "f.yaml:4: 'base:/add' is another site's, but red can serve only its own"),
        ("  red:\n    serve:\n    - /add\n    - '*:/add'", "f.yaml:6: '*:/add' is another site's"),
        ("  red:\n    deny_serve: ['base:/add']", "f.yaml:4: 'base:/add' is another site's"),
        ("  red:\n    call: [/add]", "f.yaml:4: '/add' is red's own service; write whose services it may call: base:/"),
        ("  red-2:\n    call: ['red:/add']", "f.yaml:4: 'red:/add' is red's own service"),
        ("  red:\n    deny_call: [/add]", "f.yaml:4: '/add' is red's own service"),
        ("  red:\n    call: ['!base:/add']", "f.yaml:4: write what a site may not call under deny_call, without !"),
        ("  red:\n    serve: [5]", "f.yaml:4: expected a string"),
        ("  red:\n    forwards: [far-2]", "f.yaml:4: 'far-2' cannot be a site's name"),
        ("  red:\n    forwards: 5", "f.yaml:4: expected a string"),
    ],
)
def test_mistakes(sites: str, complaint: str) -> None:
    with pytest.raises(RulesError) as caught:
        read(sites)
    assert str(caught.value).startswith(complaint)
