"""Checks whether a site without its own rule would publish into this master's namespaces. No I/O.

The topics of site red appear below ``/red``. With a rule for all sites (``*:**``), a site chooses its name, and so
where it publishes here: one named ``arm`` could command the arm whose driver subscribes to ``/arm/goal``.

A subscription alone does not tell whether a node expects topics of this master or of another site. It is taken to be
for another site if one that is not refused had the namespace when the subscription began, and stays so, since the site
may go and return. All other subscriptions are taken to be for topics of this master.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from pyros1.bridge.rules.rules import Rule, Rules


class UsedTopics(NamedTuple):
    """The topics that nodes of this master, except bridges, use, whether or not rules allow them to be sent.

    Attributes:
        published: those that they publish.
        subscribed: those that they subscribe to.
    """

    published: frozenset[str]
    subscribed: frozenset[str]


class LocalNamespaces:
    """The namespaces of the topics that nodes of this master use.

    Args:
        rules: the site's rules.

    Attributes:
        is_known: whether `update` was called: until then, sites that choose their names are refused.
    """

    def __init__(self, rules: Rules) -> None:
        self.is_known = False
        self._rules = rules
        self._used = UsedTopics(frozenset(), frozenset())
        self._expected: frozenset[str] = frozenset()  # the subscribed topics that are expected from this master
        self._below: dict[str, list[str]] = {}  # namespace -> topics that belong to this master

    def update(self, used: UsedTopics, sites: Iterable[str]) -> list[str]:
        """Record which topics nodes of this master use.

        Args:
            used: the topics.
            sites: the known other sites.

        Returns:
            The sites for which `problem` may now return something else.
        """
        if self.is_known and used == self._used:
            return []
        before = {site: self._conflict(site) for site in sites}
        taken = {self._rules.prefix(site) for site, conflict in before.items() if not conflict}
        new = (topic for topic in used.subscribed - self._used.subscribed if taken.isdisjoint(_namespaces(topic)))
        self._expected = (self._expected & used.subscribed).union(new)
        self._used, self.is_known = used, True
        self._below.clear()
        for topic in sorted(used.published | self._expected):
            for namespace in _namespaces(topic):
                self._below.setdefault(namespace, []).append(topic)
        return [site for site, conflict in before.items() if self._conflict(site) != conflict]

    def problem(self, site: str, rule: Rule) -> str:
        """Return why another site's topic is refused although a rule accepts it; empty if it is not refused.

        Args:
            site: the other site.
            rule: the rule.
        """
        if rule.here or rule.pattern.site != "*":
            return ""  # it names the site, or says where the topic appears
        return self._conflict(site)

    def _conflict(self, site: str) -> str:
        rules = self._rules
        if site in rules.sites or {site, "*"} & rules.prefixes.keys():
            return ""  # the rules name the site, or say where its topics appear
        if not self.is_known:
            return "the topics of the nodes here are not known yet"
        for topic in self._below.get(rules.prefix(site), ()):
            if all(outgoing.shared.site != site for outgoing in rules.outgoing(topic, [site])):
                verb = "publish" if topic in self._used.published else "subscribe to"
                return f"nodes here {verb} {topic}: if site {site} may publish there too, name it with --sites"
        return ""


def _namespaces(topic: str) -> Iterator[str]:
    """Yield the namespaces that contain a topic, except the root."""
    while topic := topic.rpartition("/")[0]:
        yield topic
