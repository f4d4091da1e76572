"""A host that vanishes: nothing comes from it, and nobody is told. Links end in a bounded time, and come again.

Feature: network faults: hosts that disappear, peers that stop halfway, slow links, lost packets, unresponsive name
    servers -- each compared with stock: the time until it is noticed, and what is lost:
    [interop/faults.md](interop/faults.md)
"""

from __future__ import annotations

import signal

from harness import Peer, until
from site_of_two import IMAGE, TEXT, WAIT, Site, hasty, linked

STOCK = ("roscpp", "rospy")


def publish_and_hear(publisher: Peer, topic: str, *subscribers: Peer, seed: int) -> None:
    body = publisher.publish(topic, seed)
    for each in subscribers:
        assert each.received(topic, timeout=WAIT) == body


def publish_until_heard(publisher: Peer, topic: str, subscriber: Peer) -> None:
    """A stock publisher takes a moment to know a subscriber that knows it already."""

    def heard() -> bool:
        publisher.publish(topic)
        return bool(subscriber.unread(f"^got {topic} "))

    until(heard, f"{subscriber.label} hears {topic}", WAIT)


def test_topics(site: Site) -> None:
    """Links to the robot end, whether messages wait there or not; the others go on, and come again with the robot."""
    uri = site.laptop.core("ours")
    ours, near = hasty(site.laptop, "ours", uri), site.laptop.peer("roscpp", "near", uri)
    far = {kind: site.robot.peer(kind, f"far_{kind}", uri) for kind in STOCK}
    ours.advertise("/out", TEXT)
    ours.advertise("/images", IMAGE, queue_size=0)  # publishing waits for the subscribers
    far["roscpp"].subscribe("/images", IMAGE)
    for topic, peer in (("/near", near), *((f"/{kind}", peer) for kind, peer in far.items())):
        peer.advertise(topic, TEXT)
        ours.subscribe(topic, TEXT)
        peer.subscribe("/out", TEXT)
        linked(peer, topic, 1)
        publish_and_hear(peer, topic, ours, seed=1)
    linked(ours, "/out", 3)
    linked(ours, "/images", 1)
    publish_and_hear(ours, "/out", near, *far.values(), seed=1)

    site.wires.cut(site.robot)
    publish_and_hear(ours, "/out", near, seed=2)  # this one stays under way to the robot
    ours.ask("burst", "/images", 6_000_000, 3, event="burst /images", timeout=WAIT)
    linked(ours, "/images", 0)
    linked(ours, "/out", 1)
    for kind in STOCK:
        linked(ours, f"/{kind}", 0)
    publish_and_hear(ours, "/out", near, seed=3)
    publish_and_hear(near, "/near", ours, seed=3)

    site.wires.mend(site.robot)
    for kind, peer in far.items():
        linked(ours, f"/{kind}", 1)
        publish_until_heard(peer, f"/{kind}", ours)


def test_a_short_absence_loses_nothing(site: Site) -> None:
    """The system sends again what did not arrive, so no message is lost in either direction."""
    uri = site.laptop.core("ours")
    ours = site.laptop.peer("pyros1", "ours", uri)
    far = {kind: site.robot.peer(kind, f"far_{kind}", uri) for kind in STOCK}
    ours.advertise("/from_ours", TEXT)
    for kind, peer in far.items():
        peer.subscribe("/from_ours", TEXT)
        peer.advertise(f"/from_{kind}", TEXT)
        ours.subscribe(f"/from_{kind}", TEXT)
        linked(ours, f"/from_{kind}", 1)
        linked(peer, f"/from_{kind}", 1)
    linked(ours, "/from_ours", 2)
    site.wires.cut(site.robot)
    sent = {topic: [] for topic in ("/from_ours", *(f"/from_{kind}" for kind in STOCK))}
    for seed in range(20):
        for topic, peer in (("/from_ours", ours), *((f"/from_{kind}", peer) for kind, peer in far.items())):
            sent[topic].append(peer.publish(topic, seed))
    site.wires.mend(site.robot)
    for kind, peer in far.items():
        assert [peer.received("/from_ours", timeout=WAIT) for _ in range(20)] == sent["/from_ours"]
        topic = f"/from_{kind}"
        assert [ours.received(topic, timeout=WAIT) for _ in range(20)] == sent[topic]


def test_a_service_call_under_way(site: Site) -> None:
    """Our client gets an error, whether its request has arrived or not; stock's clients wait on."""
    uri = site.laptop.core("ours")
    server = site.robot.peer("rospy", "server", uri)
    server.serve("/hang", "std_srvs/SetBool", "hang")
    server.serve("/quick", "std_srvs/SetBool")
    waiting, kept = hasty(site.laptop, "waiting", uri), hasty(site.laptop, "kept", uri)
    waiting.tell("call", "/hang", "std_srvs/SetBool", 1, 0)
    server.event("served", "/hang", timeout=WAIT)
    kept.call("/quick", "std_srvs/SetBool", 1, persistent=True)
    site.wires.cut(site.robot)
    kept.tell("call", "/quick", "std_srvs/SetBool", 1, 1)
    assert "no longer answers" in waiting.event("failed", "/hang", timeout=WAIT)
    assert "no longer answers" in kept.event("failed", "/quick", timeout=WAIT)
    site.wires.mend(site.robot)
    kept.call("/quick", "std_srvs/SetBool", 1, persistent=True)


def test_a_host_that_was_switched_off_and_on(site: Site) -> None:
    """Half-open connections: the robot's nodes are gone without a word, and its system does not know their links."""
    uri = site.laptop.core("ours")
    ours = hasty(site.laptop, "ours", uri)
    old = {kind: site.robot.peer(kind, f"far_{kind}", uri) for kind in STOCK}
    for kind, peer in old.items():
        peer.advertise(f"/{kind}", TEXT)
        ours.subscribe(f"/{kind}", TEXT)
        linked(ours, f"/{kind}", 1)
    site.wires.cut(site.robot)
    for peer in old.values():
        peer.signal(signal.SIGKILL)
        peer.wait()
    site.wires.mend(site.robot)
    for kind in STOCK:
        linked(ours, f"/{kind}", 0)
        new = site.robot.peer(kind, f"far_{kind}", uri)
        new.advertise(f"/{kind}", TEXT)
        linked(ours, f"/{kind}", 1)
        publish_until_heard(new, f"/{kind}", ours)


def test_the_masters_host(site: Site) -> None:
    """Topics go on, calls of the master fail in a bounded time, and work again when it is back; a node can end."""
    uri = site.robot.core("stock")
    ours, other, leaving = (site.laptop.peer("pyros1", name, uri) for name in ("ours", "other", "leaving"))
    near = site.laptop.peer("roscpp", "near", uri)
    near.advertise("/t", TEXT)
    for each in (ours, leaving):
        each.subscribe("/t", TEXT)
        linked(each, "/t", 1)
    linked(near, "/t", 2)
    ours.ask("setparam", "/p", "int", event="set /p")
    site.wires.cut(site.robot)
    ours.tell("getparam", "/p")
    other.tell("call", "/s", "std_srvs/SetBool", 1, 0)
    publish_and_hear(near, "/t", ours, leaving, seed=1)
    assert leaving.quit() == 0
    assert "MasterUnreachableError" in ours.wait_line("^error getparam.*", timeout=WAIT)[0]
    assert "ServiceError" in other.event("failed", "/s", timeout=WAIT)
    site.wires.mend(site.robot)
    assert ours.ask("getparam", "/p", timeout=WAIT) == "42"
