"""Sites that nobody has named, and the namespaces of this master's own nodes."""

from __future__ import annotations

from collections.abc import Collection

import pytest

from pyros1.bridge.names import SharedName
from pyros1.bridge.rules.namespaces import LocalNamespaces, UsedTopics
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Rule

ALL = "take: ['*:**']"
TOPICS = ["/arm/left/state", "/red/cmd_vel", "/armour", "/robots/arm/x"]


def used(*published: str, subscribed: Collection[str] = ()) -> UsedTopics:
    return UsedTopics(frozenset(published), frozenset(subscribed))


def find_problem(namespaces: LocalNamespaces, text: str, site: str) -> str:
    """Return why a topic of a site is refused."""
    rule = parse_config(text, "f", "base").rules.incoming(SharedName(site, "/x/y"), site)
    assert isinstance(rule, Rule)
    return namespaces.problem(site, rule)


def make(text: str) -> LocalNamespaces:
    return LocalNamespaces(parse_config(text, "f", "base").rules)


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
    for published, subscribed, verb in ((TOPICS, [], "publish"), ([], TOPICS, "subscribe to")):
        namespaces = make(text)
        unknown = find_problem(namespaces, text, site)
        assert unknown in ("", "the topics of the nodes here are not known yet")
        namespaces.update(used(*published, subscribed=subscribed), [site])
        problem = find_problem(namespaces, text, site)
        assert problem.startswith(refused.replace("publish", verb, 1)) and bool(problem) == bool(refused)
        namespaces.update(used(), [site])
        assert find_problem(namespaces, text, site) == ""


def test_only_sites_whose_problem_changes_are_looked_at_again() -> None:
    namespaces = make(ALL)
    sites = ["arm", "red"]
    assert namespaces.update(used("/odom"), sites) == sites, "they were refused until now"
    assert namespaces.update(used("/odom", "/arm/state"), sites) == ["arm"]
    assert namespaces.update(used("/odom", "/arm/state", "/map"), sites) == []
    assert namespaces.update(used("/odom", "/map", subscribed=["/arm/state"]), sites) == ["arm"]


def test_subscriptions_to_topics_of_a_site_that_is_there() -> None:
    """They are not held against it, even while it is away, and whether or not it has such topics."""
    namespaces = make(ALL)
    namespaces.update(used(), [])
    namespaces.update(used(subscribed=["/red/odom"]), ["red"])
    namespaces.update(used(subscribed=["/red/odom", "/red/map"]), ["red"])
    assert find_problem(namespaces, ALL, "red") == ""
    namespaces.update(used(subscribed=["/red/map"]), [])
    assert find_problem(namespaces, ALL, "red") == ""
    namespaces.update(used("/red/state", subscribed=["/red/map"]), ["red"])
    assert "publish /red/state" in find_problem(namespaces, ALL, "red"), "but what is published here is"


def test_subscriptions_that_were_there_first() -> None:
    namespaces = make(ALL)
    namespaces.update(used(subscribed=["/arm/goal"]), ["arm"])  # it has come before the nodes here were known
    assert "subscribe to /arm/goal" in find_problem(namespaces, ALL, "arm")
    namespaces.update(used(subscribed=["/arm/goal", "/arm/speed"]), ["arm"])
    namespaces.update(used(subscribed=["/arm/speed"]), ["arm"])
    assert "subscribe to /arm/speed" in find_problem(namespaces, ALL, "arm"), "a site that is refused has no namespace"
