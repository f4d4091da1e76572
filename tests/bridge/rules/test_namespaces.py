"""Sites that nobody has named, and the namespaces of this master's own nodes."""

from __future__ import annotations

import pytest

from pyros1.bridge.names import SharedName
from pyros1.bridge.rules.namespaces import LocalNamespaces
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Rule

TOPICS = ["/arm/left/state", "/red/cmd_vel", "/armour", "/robots/arm/x"]


@pytest.mark.parametrize(
    ("text", "site", "refused"),
    [
        ("take: ['*:**']", "arm", "nodes here publish /arm/left/state: if site arm may publish there too, name it"),
        ("take: ['*:**']", "red", "nodes here publish /red/cmd_vel: "),
        ("{take: ['*:**'], send: ['*:/cmd_vel']}", "red", ""),  # that is for red
        ("{take: ['*:**'], send: ['*:/goal']}", "red", "nodes here publish /red/cmd_vel: "),
        ("take: ['*:**']", "left", ""),
        ("take: ['*:**']", "armour", ""),
        ("{take: ['*:**'], prefix: {'*': /robots}}", "arm", ""),
        ("{take: ['*:**'], prefix: {'*': /}}", "left", ""),
        ("{take: ['*:**'], prefix: {arm: /arm}}", "arm", ""),
        ("{take: ['*:**'], sites: [arm]}", "arm", ""),
        ("take: ['arm:**']", "arm", ""),
        ("take: [{topic: '*:/x/**', here: /x/**}]", "arm", ""),
    ],
)
def test_sites_that_would_publish_among_local_topics(text: str, site: str, refused: str) -> None:
    rules = parse_config(text, "f", "base").rules
    rule = rules.incoming(SharedName(site, "/x/y"), site)
    assert isinstance(rule, Rule)
    namespaces = LocalNamespaces(rules)
    assert namespaces.problem(site, rule) == ""
    assert namespaces.update(TOPICS) and not namespaces.update(reversed(TOPICS))
    problem = namespaces.problem(site, rule)
    assert problem.startswith(refused) and bool(problem) == bool(refused)
    assert namespaces.update([]) and namespaces.problem(site, rule) == ""
