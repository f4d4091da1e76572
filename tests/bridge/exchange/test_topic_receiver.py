"""Offers of sites that nobody has named, in a site's machine."""

from __future__ import annotations

from pyros1.bridge.exchange.actions import Advertise, Log, Withdraw
from pyros1.bridge.exchange.site import Site

from ..pair import Pair, rules


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
    pair.use("base", subscribed=["/arm/goal"])  # a node here listens to the site's topic
    assert not [action for action in pair.actions if isinstance(action, Withdraw)]
    pair.publish("base", "/arm/state", "/else")  # and here again
    assert [action.local for action in pair.actions if isinstance(action, Withdraw)] == ["/arm/goal"]


def test_an_unnamed_site_cannot_publish_what_nodes_here_subscribed_to_before() -> None:
    pair = Pair(rules("take: ['*:**']", "base"), rules("send: [/goal]", "arm"))
    pair.use("base", subscribed=["/arm/goal"])
    pair.publish("arm", "/goal")
    pair.wait()
    told = "nodes here subscribe to /arm/goal: if site arm may publish there too, name it with --sites"
    assert [each.state for each in pair.sites["base"].received_topics()] == [told]
    assert not [action for action in pair.actions if isinstance(action, Advertise)]


def test_nothing_of_an_unnamed_site_is_taken_before_the_nodes_here_are_known() -> None:
    pair = Pair(rules("take: ['*:**']", "base"), rules("send: [/goal]", "arm"))
    pair.sites["base"] = Site(rules("take: ['*:**']", "base"), 77, 0.0)
    pair.publish("arm", "/goal")
    pair.wait()
    assert [each.state for each in pair.sites["base"].received_topics()] == [
        "the topics of the nodes here are not known yet"
    ]
    assert not [action for action in pair.actions if isinstance(action, Advertise) or "not taken" in str(action)]
    pair.use("base")
    pair.wait()
    assert [action.local for action in pair.actions if isinstance(action, Advertise)] == ["/arm/goal"]


def test_a_named_site_can() -> None:
    pair = Pair(rules("{take: ['*:**'], sites: [arm]}", "base"), rules("send: [/goal]", "arm"))
    pair.publish("base", "/arm/state")
    pair.publish("arm", "/goal")
    pair.wait()
    assert [action.local for action in pair.actions if isinstance(action, Advertise)] == ["/arm/goal"]
