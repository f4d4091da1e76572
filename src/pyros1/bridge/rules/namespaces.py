"""Checks whether a site without its own rule would publish into this master's namespaces. No I/O.

The topics of site red appear below ``/red``. With a rule for all sites (``*:**``), a site chooses its name, and so
where it publishes here: one named ``arm`` could command the arm whose driver subscribes to ``/arm/goal``.
"""

from __future__ import annotations

from collections.abc import Collection

from pyros1.bridge.rules.rules import Rule, Rules


class LocalNamespaces:
    """The namespaces in which nodes of this master publish.

    Args:
        rules: the site's rules.
    """

    def __init__(self, rules: Rules) -> None:
        self._rules = rules
        self._topics: frozenset[str] = frozenset()
        self._below: dict[str, list[str]] = {}  # namespace -> topics

    def update(self, topics: Collection[str]) -> bool:
        """Record which topics the nodes of this master, except bridges, publish; return whether they have changed."""
        new = frozenset(topics)
        if new == self._topics:
            return False
        self._topics = new
        self._below.clear()
        for topic in sorted(new):
            namespace = topic
            while namespace := namespace.rpartition("/")[0]:
                self._below.setdefault(namespace, []).append(topic)
        return True

    def problem(self, site: str, rule: Rule) -> str:
        """Return why another site's topic is refused although a rule accepts it; empty if it is not refused.

        Args:
            site: the other site.
            rule: the rule.
        """
        rules = self._rules
        if site in rules.sites or {site, "*"} & rules.prefixes.keys() or rule.here or rule.pattern.site != "*":
            return ""  # the rules name the site, or say where its topics appear
        for topic in self._below.get(rules.prefix(site), ()):
            if all(outgoing.shared.site != site for outgoing in rules.outgoing(topic, [site])):
                return f"nodes here publish {topic}: if site {site} may publish there too, name it with --sites"
        return ""
