"""Decides which topics and services a zenoh-plugin-ros1 bridge exchanges, and their local names. No I/O.

The patterns are those of `pyros1.bridge.rules`, with namespaces in place of sites. A pattern without a namespace stands
for this bridge's own. Bridges without a namespace exchange with all, as the plugin's do; for them, such a pattern
stands for any namespace that no other pattern names.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from pyros1.bridge.names import SharedName, is_topic_name
from pyros1.bridge.plugin_ros1.keys import ANY, Kind, Resource
from pyros1.bridge.rules.rules import Rule, Rules


class Remote(NamedTuple):
    """A topic or service as other bridges know it, and its rule."""

    namespace: str
    name: str
    rule: Rule


class Local(NamedTuple):
    """The local name of another bridge's topic or service, and its rule."""

    name: str
    rule: Rule


@dataclass(frozen=True)
class PluginRules:
    """The rules of a bridge.

    Attributes:
        topics: the rules for topics to send and take; their site is the bridge's namespace, or ``*``.
        services: the rules for services that others may call here (as `send`), and services to call there (as `take`).
        old_keys: whether the other bridges are older than March 2025.
    """

    topics: Rules
    services: Rules
    old_keys: bool = False

    @property
    def namespace(self) -> str:
        """The bridge's namespace; ``*`` if it has none."""
        return self.topics.site

    def namespaces(self) -> frozenset[str]:
        """Return the namespaces whose beacons matter; ``*`` for all."""
        rules = (*self.topics.send, *self.topics.take, *self.services.send, *self.services.take)
        return frozenset({self.namespace, *(rule.pattern.site for rule in rules if rule.pattern.site)})

    def sent_names(self, local: str, known: Iterable[str] = ()) -> list[Remote]:
        """Return the names under which a topic of this master is sent.

        Args:
            local: its name.
            known: the known namespaces, for patterns that match all.
        """
        return _outgoing(self.topics, local, known)

    def served_names(self, local: str, known: Iterable[str] = ()) -> list[Remote]:
        """Return the names under which a service of this master can be called; arguments as for `sent_names`."""
        return _outgoing(self.services, local, known)

    def incoming(self, resource: Resource) -> Local | str:
        """Return the local name of another bridge's topic or service, or why it is not used."""
        rules = self.services if resource.kind is Kind.SERVICE else self.topics
        names = [SharedName(namespace, resource.name) for namespace in self._matching_namespaces(resource.namespace)]
        if any(denied.matches(name, self.namespace) for denied in rules.deny_take for name in names):
            return "denied by a rule"
        for shared in names:
            rule = rules.incoming(shared, shared.site)
            if isinstance(rule, Rule):
                name = rules.local_name(rule, shared)
                return Local(name, rule) if is_topic_name(name) else f"{name:.80} is not a name in ROS"
        return "no rule takes it"

    def _matching_namespaces(self, namespace: str) -> tuple[str, ...]:
        """Return the namespaces that match another bridge's namespace, the more specific one first."""
        if namespace == ANY:
            return (self.namespace,)
        return (namespace, ANY) if self.namespace == ANY else (namespace,)


def _outgoing(rules: Rules, local: str, known: Iterable[str]) -> list[Remote]:
    others = [each for each in known if each not in (ANY, rules.site)]
    return [Remote(*outgoing.shared, outgoing.rule) for outgoing in rules.outgoing(local, others)]
