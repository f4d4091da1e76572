"""Offers of sites that nobody has named, in a site's machine."""

from __future__ import annotations

from pyros1.bridge.exchange.actions import Advertise, Log, Withdraw

from ..pair import Pair, rules, topics


def test_an_unnamed_site_cannot_publish_among_the_topics_of_this_master() -> None:
    """It has chosen its name so that its topics would be those of this master's arm."""
    pair = Pair(rules("take: ['*:**']", "base"), rules("send: [/goal]", "arm"))
    pair.publish("base", "/arm/state")
    pair.publish("arm", "/goal")
    pair.wait()
    told = "nodes here publish /arm/state: if site arm may publish there too, name it with --sites"
    assert [each.state for each in pair.sites["base"].received_topics()] == [told]
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
