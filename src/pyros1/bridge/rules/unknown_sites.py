"""Warns about sites that rules name but `sites` does not, since a misspelt name would go unnoticed."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from pyros1.bridge.rules.rules import Rules
from pyros1.ground.suggest import did_you_mean


def unknown_sites(rules: Rules) -> list[str]:
    """Return a warning for each site that rules name although `sites` does not; none if the site talks to all.

    Args:
        rules: the site's rules.
    """
    if not rules.sites:
        return []
    known = (rules.site, *rules.sites)
    unknown = dict.fromkeys(name for name in _named_sites(rules) if name not in ("", "*", *known))
    return [
        f"rules name site {name}, but `sites` does not{did_you_mean(name, known)}: nothing is exchanged with it"
        for name in unknown
    ]


def _named_sites(rules: Rules) -> Iterator[str]:
    services = rules.services
    for rule in chain(rules.send, rules.take, services.serve, services.call):
        yield from (rule.pattern.site, *rule.sites)
    for pattern in chain(rules.deny_send, rules.deny_take, services.deny_serve, services.deny_call):
        yield pattern.site
    yield from rules.prefixes
