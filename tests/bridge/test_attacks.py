"""A site that sends recorded packets again."""

from __future__ import annotations

from random import Random

import pytest

from pyros1.bridge.exchange.actions import Publish
from pyros1.bridge.exchange.outgoing import ReceivedMessage
from pyros1.bridge.exchange.site import Site

from .pair import STRING, Pair, rules, topics


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("delivery", ["reliable", "newest"])
def test_recorded_packets_are_delivered_once(delivery: str, seed: int) -> None:
    """Neither in the same run, in any order, nor after a restart of either site."""
    text = f"send: [{{topic: /goal, delivery: {delivery}, age: 60}}]"
    base, arm = rules("take: [{topic: 'arm:/goal', age: 60}]", "base"), rules(text, "arm")
    pair = Pair(base, arm)
    pair.publish("arm", "/goal")
    pair.wait()
    pair.pass_on("base", pair.sites["base"].set_subscribed(["/arm/goal"], pair.now))
    for number in range(20):
        pair.now += 0.01
        message = ReceivedMessage("/node", STRING._md5sum, False, b"%d" % number)
        pair.pass_on("arm", pair.sites["arm"].on_message("/goal", message, False, pair.now))
    delivered = [action.body for action in pair.actions if isinstance(action, Publish)]
    assert delivered == [b"%d" % number for number in range(20)]
    recorded = [*pair.recorded]
    Random(seed).shuffle(recorded)

    def replay(site: Site) -> list[Publish]:
        found = []
        for packet in recorded:
            pair.now += 0.01
            actions = [*site.on_packet(*packet, pair.now), *site.tick(pair.now)]
            found += [action for action in actions if isinstance(action, Publish)]
        return found

    assert replay(pair.sites["base"]) == []
    pair.actions.clear()
    pair.sites["arm"] = Site(arm, 77, pair.now)  # the arm starts again
    pair.publish("arm", "/goal")
    pair.wait()
    assert replay(pair.sites["base"]) == []
    again = Site(base, 78, pair.now)  # and the base
    again.set_topics(topics(), pair.now, pair.now)
    again.set_subscribed(["/arm/goal"], pair.now)
    assert replay(again) == []
