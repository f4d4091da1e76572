"""Packets that arrive in one direction only."""

from __future__ import annotations

from site_of_two import TEXT, WAIT, Site, linked


def test_nothing_comes_from_the_publishers_host(site: Site) -> None:
    """The subscriber says so and tries again: messages come as soon as there is a way back."""
    uri = site.laptop.core("ours")
    far = {kind: site.robot.peer(kind, f"far_{kind}", uri) for kind in ("roscpp", "rospy")}
    near = site.laptop.peer("roscpp", "near", uri)
    for peer in (near, *far.values()):
        peer.advertise("/t", TEXT)
    site.wires.path(site.robot, site.laptop).open = False
    ours = site.laptop.peer("pyros1", "ours", uri)
    ours.subscribe("/t", TEXT)
    linked(near, "/t", 1)
    body = near.publish("/t")
    assert ours.received("/t", timeout=WAIT) == body
    for _ in far:
        ours.wait_line(
            r"no messages of /t from the publisher at http://robot:\d+/ yet: robot:\d+ does not answer", timeout=WAIT
        )
    site.wires.path(site.robot, site.laptop).open = True
    for seed, peer in enumerate(far.values(), 2):
        linked(peer, "/t", 1)
        body = peer.publish("/t", seed)
        assert ours.received("/t", timeout=WAIT) == body


def test_a_link_loses_one_direction(site: Site) -> None:
    """Without acknowledgements nothing is lost for good: what was sent meanwhile arrives, in order."""
    uri = site.laptop.core("ours")
    ours, stock = site.laptop.peer("pyros1", "ours", uri), site.robot.peer("rospy", "stock", uri)
    pairs = ((ours, "/from_ours", stock), (stock, "/from_stock", ours))
    for publisher, topic, subscriber in pairs:
        publisher.advertise(topic, TEXT)
        subscriber.subscribe(topic, TEXT)
        linked(publisher, topic, 1)
    for path in site.wires.both_ways(site.robot, site.laptop):
        path.open = False
        sent = {topic: [publisher.publish(topic, seed) for seed in range(10)] for publisher, topic, _ in pairs}
        path.open = True
        for _, topic, subscriber in pairs:
            assert [subscriber.received(topic, timeout=WAIT) for _ in range(10)] == sent[topic]
