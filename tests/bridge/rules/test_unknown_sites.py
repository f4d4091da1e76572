"""Warnings of misspelt sites."""

from __future__ import annotations

import pytest

from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.unknown_sites import unknown_sites

RULES = """
site: base
sites: [red, green]
{}
"""


@pytest.mark.parametrize(
    "text",
    [
        "send: ['grn:/cmd_vel']",
        "send: [{topic: /odom, sites: [red, grn]}]",
        "take: ['grn:**']",
        "deny_send: ['grn:/a']",
        "deny_take: ['grn:/a']",
        "serve: [{service: /add, sites: [grn]}]",
        "call: ['grn:**']",
        "deny_call: ['grn:/a']",
        "prefix: {grn: /}",
    ],
)
def test_a_misspelt_site(text: str) -> None:
    rules = parse_config(RULES.format(text), "f.yaml").rules
    assert unknown_sites(rules) == [
        "rules name site grn, but `sites` does not (did you mean 'green'?): nothing is exchanged with it"
    ]
    assert unknown_sites(parse_config(f"site: base\n{text}", "f.yaml").rules) == []


def test_sites_that_are_known() -> None:
    text = "send: [/odom, 'red:/cmd_vel', 'base:/map', '*:/goal']\ntake: ['*:**']\nprefix: {'*': /robots, red: /}"
    assert unknown_sites(parse_config(RULES.format(text), "f.yaml").rules) == []
