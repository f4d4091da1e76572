"""Two sites' machines whose packets reach each other at once."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from pyros1.bridge.exchange.actions import Action, Send
from pyros1.bridge.exchange.site import Site
from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.protocol.key_expressions import Key, parse_key, site_key
from pyros1.bridge.rules.namespaces import UsedTopics
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Rules
from pyros1.msgs import load_message

STRING = load_message("std_msgs/String")


def topics(*names: str) -> list[LocalTopic]:
    return [LocalTopic(name, "std_msgs/String", STRING._md5sum, "string data\n", False, ("/node",)) for name in names]


class Pair:
    """Two sites.

    Args:
        base, arm: their rules.

    Attributes:
        sites: the machines by name.
        actions: what the base has done, except sending.
        recorded: the packets that have come to the base.
    """

    def __init__(self, base: Rules, arm: Rules) -> None:
        self.sites = {rules.site: Site(rules, number + 5, 0.0) for number, rules in enumerate((base, arm))}
        self.now = 0.0
        self.actions: list[Action] = []
        self.recorded: list[tuple[Key, bytes, bytes]] = []
        for name in self.sites:
            self.use(name)

    def pass_on(self, sender: str, actions: Iterable[Action]) -> None:
        """Let a site's packets reach the other one, and its answers the first, and so on."""
        (receiver,) = self.sites.keys() - {sender}
        for action in actions:
            if isinstance(action, Send):
                key = parse_key(site_key(sender, action.key))
                assert key is not None
                if receiver == "base":
                    self.recorded.append((key, action.head, action.body))
                self.pass_on(receiver, self.sites[receiver].on_packet(key, action.head, action.body, self.now))
            elif sender == "base":
                self.actions.append(action)

    def publish(self, site: str, *names: str) -> None:
        """Let these be the topics of a site's master, without subscribers."""
        self.use(site, *names)
        self.pass_on(site, self.sites[site].set_topics(topics(*names), self.now, self.now))

    def use(self, site: str, *published: str, subscribed: Collection[str] = ()) -> None:
        """Let a site's nodes use these topics, without offering them."""
        used = UsedTopics(frozenset(published), frozenset(subscribed))
        self.pass_on(site, self.sites[site].set_used_topics(used, self.now))

    def wait(self) -> None:
        """Let three seconds pass."""
        for _ in range(30):
            self.now += 0.1
            for name, site in self.sites.items():
                self.pass_on(name, site.tick(self.now))


def rules(text: str, site: str) -> Rules:
    return parse_config(text, "f", site).rules
