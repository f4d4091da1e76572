"""A site's rules about services and parameters. No I/O.

As with topics, nothing is allowed unless a rule allows it, and denying rules take precedence. A site serves only its
own services, whose local names the setting `here` can change; it calls only other sites' services.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pyros1.bridge.names import Pattern, SharedName, is_topic_name
from pyros1.bridge.rules.rules import Rule, RuleMatch, Rules, remote_name
from pyros1.bridge.rules.site_access import may_serve

PARAMETERS = "/pyros1_bridge/parameters"
"""The name under which sites request each other's parameters, also in the permissions under `sites`; no service with
that name can be served.
"""
DEFAULT_TIMEOUT = 60.0
"""Maximum seconds that a call may take, unless a rule sets another limit."""


def match_served(rules: Rules, local: str) -> RuleMatch | None:
    """Return the name under which other sites may call a service of this site's master; None if they may not.

    Args:
        rules: the site's rules.
        local: the service's name here.
    """
    for rule in rules.services.serve:
        name = remote_name(rule, local, "")
        if name is None or not rule.pattern.matches_name(name) or not is_topic_name(name) or name == PARAMETERS:
            continue
        shared = SharedName(rules.site, name)
        if not any(pattern.matches(shared, rules.site) for pattern in rules.services.deny_serve):
            return RuleMatch(shared, rule)
    return None


def called(rules: Rules, service: SharedName, peer: str) -> Rule | str:
    """Return the rule by which another site's service is provided here, or the reason why it is not.

    Args:
        rules: the site's rules.
        service: the service's name between sites.
        peer: the site that serves it.
    """
    if service.site != peer:
        return f"{peer} serves a service of another site"
    if any(pattern.matches(service, rules.site) for pattern in rules.services.deny_call):
        return "denied by a rule"
    if not may_serve(rules.access, peer, service):
        return f"{peer} may not serve it"
    for rule in rules.services.call:
        if rule.pattern.matches(service, rules.site) and rule.applies_to(peer):
            return rule
    return "no rule calls it"


def may_read(rules: Rules, parameter: str) -> bool:
    """Return whether other sites may read a parameter of this site's master.

    Args:
        rules: the site's rules.
        parameter: its full name, not a namespace's.
    """

    def includes(patterns: Iterable[Pattern]) -> bool:
        return any(pattern.matches_name(name) for name in _with_parents(parameter) for pattern in patterns)

    return includes(rules.services.params) and not includes(rules.services.deny_params)


def _with_parents(name: str) -> Iterator[str]:
    while name:
        yield name
        name = name.rpartition("/")[0]
