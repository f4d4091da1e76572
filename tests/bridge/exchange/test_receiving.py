"""Offers of sites that nobody has named, in a site's machine."""

from __future__ import annotations

from collections.abc import Iterable

from pyros1.bridge.exchange.actions import Action, Advertise, Log, Send, Withdraw
from pyros1.bridge.exchange.sending import LocalTopic
from pyros1.bridge.exchange.site import Site
from pyros1.bridge.protocol.key_expressions import parse_key, site_key
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Rules
from pyros1.msgs import load_message

STRING = load_message("std_msgs/String")


def topics(*names: str) -> list[LocalTopic]:
    return [LocalTopic(name, "std_msgs/String", STRING._md5sum, "string data\n", False, ("/node",)) for name in names]


class Pair:
    """Two sites, and what they do when each has got all packets of the other."""

    def __init__(self, base: Rules, arm: Rules) -> None:
        self.sites = {rules.site: Site(rules, number + 5, 0.0) for number, rules in enumerate((base, arm))}
        self.now = 0.0
        self.actions: list[Action] = []

    def pass_on(self, sender: str, actions: Iterable[Action]) -> None:
        (receiver,) = self.sites.keys() - {sender}
        for action in actions:
            if isinstance(action, Send):
                key = parse_key(site_key(sender, action.key))
                assert key is not None
                self.pass_on(receiver, self.sites[receiver].on_packet(key, action.head, action.body, self.now))
            elif sender == "base":
                self.actions.append(action)

    def publish(self, site: str, *names: str) -> None:
        self.pass_on(site, self.sites[site].set_topics(topics(*names), self.now, self.now))

    def wait(self) -> None:
        for _ in range(30):
            self.now += 0.1
            for name, site in self.sites.items():
                self.pass_on(name, site.tick(self.now))


def rules(text: str, site: str) -> Rules:
    return parse_config(text, "f", site).rules


def test_an_unnamed_site_cannot_publish_among_the_topics_of_this_master() -> None:
    """It has chosen its name so that its topics would be those of this master's arm."""
    pair = Pair(rules("take: ['*:**']", "base"), rules("send: [/goal]", "arm"))
    pair.publish("base", "/arm/state")
    pair.publish("arm", "/goal")
    pair.wait()
    told = "nodes here publish /arm/state: if site arm may publish there too, name it with --sites"
    assert [each.state for each in pair.sites["base"].received()] == [told]
    assert [action for action in pair.actions if isinstance(action, (Log, Advertise))][1:] == [
        Log(f"topics of site arm are not taken: {told}", is_warning=True)
    ]
    pair.publish("base", "/arm/state", "/arm/speed")
    assert len([action for action in pair.actions if isinstance(action, Log) and action.is_warning]) == 1
    pair.publish("base")  # those nodes are gone
    pair.wait()
    assert [action.local for action in pair.actions if isinstance(action, Advertise)] == ["/arm/goal"]
    bridged = topics("/arm/goal")[0]._replace(publishers=())
    pair.pass_on("base", pair.sites["base"].set_topics([bridged], pair.now, pair.now))
    assert not [action for action in pair.actions if isinstance(action, Withdraw)]
    pair.publish("base", "/arm/state", "/else")  # and here again
    assert [action.local for action in pair.actions if isinstance(action, Withdraw)] == ["/arm/goal"]


def test_a_named_site_can() -> None:
    pair = Pair(rules("{take: ['*:**'], sites: [arm]}", "base"), rules("send: [/goal]", "arm"))
    pair.publish("base", "/arm/state")
    pair.publish("arm", "/goal")
    pair.wait()
    assert [action.local for action in pair.actions if isinstance(action, Advertise)] == ["/arm/goal"]
