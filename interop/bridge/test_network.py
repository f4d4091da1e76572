"""Three masters on bad networks, with stock's nodes at the ends of the topics.

Feature: `pyros1 bridge` between stock's nodes -- on networks that lose, delay, break and carry little
"""

from __future__ import annotations

import itertools
import signal

import pytest
from harness import Peer, until
from hosts import Host
from sites import WAIT, Message, Sites, parse

TEXT = "std_msgs/String"
STALE = 1.0
"""Seconds that no command may be old: its limit is 0.5 s, and a loaded machine takes some time to print it."""


def small(messages: list[Message]) -> list[Message]:
    """Return the small ones, which are commands."""
    return [message for message in messages if message.kind == "small"]


def assert_in_order(messages: list[Message]) -> None:
    """No message came twice, or after a later one; no command came late."""
    for kind in ("small", "image"):
        numbers = [message.number for message in messages if message.kind == kind]
        assert numbers == sorted({*numbers})
    assert max(message.age for message in small(messages)) < STALE


@pytest.mark.parametrize(("delay", "lost"), [(0.01, 0.0), (0.05, 0.01), (0.15, 0.05)])
def test_both_ways_between_roscpp_and_rospy(sites: Sites, delay: float, lost: float) -> None:
    """Types, latched messages for who comes later, and texts both ways."""
    sites.slow_down(sites.red, sites.base, delay, lost)
    sites.start(sites.base, "--take", "red:**", "--send", "red:/order")
    sites.start(sites.red, "--send", "/odom", "/map", "--take", "/order", core="ours")
    robot = sites.peer(sites.red, "roscpp", "robot")
    station = sites.peer(sites.base, "rospy", "station")
    robot.advertise("/odom", TEXT)
    robot.advertise("/map", TEXT, latch=True)
    held = robot.publish("/map", 7)
    for topic in ("/red/odom", "/red/map"):
        sites.await_topic(sites.base, topic)
        station.subscribe(topic, TEXT)
    assert station.received("/red/map", timeout=WAIT) == held
    come_across(robot, "/odom", station, "/red/odom")
    station.advertise("/red/order", TEXT)
    sites.await_topic(sites.red, "/order")
    robot.subscribe("/order", TEXT)
    come_across(station, "/red/order", robot, "/order")


def come_across(publisher: Peer, topic: str, subscriber: Peer, topic_there: str) -> None:
    """Publish until a message comes; then all that follow must come, in their order.

    Messages that were published before the subscriber's site has asked for the topic are not sent.
    """
    publisher.tell("linked", topic, 1)
    publisher.event("linked", topic, timeout=WAIT)
    first = publisher.publish(topic, 0)
    until(lambda: publisher.publish(topic, 0) and subscriber.unread(f"^got {topic_there}"), "a message comes", WAIT)
    bodies = [publisher.publish(topic, seed) for seed in range(1, 10)]
    while (body := subscriber.received(topic_there, timeout=WAIT)) == first:
        pass
    assert [body, *(subscriber.received(topic_there, timeout=WAIT) for _ in bodies[1:])] == bodies


def cut_off(sites: Sites, host: Host, seconds: float) -> None:
    """Let a host vanish for some time."""
    sites.wires.cut(host)
    host.run(["sleep", str(seconds)])
    sites.wires.mend(host)


def test_an_outage_of_ten_seconds(sites: Sites) -> None:
    """Longer than zenoh keeps a silent connection. Nothing stale comes afterwards, and each site goes on alone."""
    sites.slow_down(sites.red, sites.base, 0.01)
    sites.start(sites.base, "--take", "red:**")
    sites.start(sites.red, "--send", "/small", "/image")
    sites.talk(sites.red)
    listener, own = sites.listen(sites.base, "/red"), sites.listen(sites.red, "")
    for _ in range(2):
        before = max(0, len(listener.lines) - 20)
        own_before = len(own.lines)
        cut_off(sites, sites.red, 11)
        assert len(small(parse(own.lines[own_before:]))) > 300, "red went on alone"
        mended = len(listener.lines)
        until(lambda: len(small(parse(listener.lines[mended:]))) > 100, "commands come again", WAIT)  # noqa: B023
        assert_in_order(parse(listener.lines))
        skipped = small(parse(listener.lines[before:]))
        assert max(after.number - each.number for each, after in itertools.pairwise(skipped)) > 200


def test_a_slow_network_that_is_overloaded(sites: Sites) -> None:
    """1 Mbit/s for 1.6 Mbit/s of images: the newest images come, and commands overtake them."""
    sites.start(sites.base, "--take", "red:**")
    sites.start(sites.red, "--send", "/small", "/image")
    sites.talk(sites.red)
    listener = sites.listen(sites.base, "/red")
    sites.slow_down(sites.red, sites.base, 0.01, rate=125_000)
    start = len(listener.lines)
    until(lambda: sum(each.kind == "image" for each in parse(listener.lines[start:])) > 60, "images come", WAIT)
    messages = parse(listener.lines[start:])[100:]
    assert_in_order(messages)
    numbers = [message.number for message in small(messages)]
    assert len(numbers) > 0.8 * (numbers[-1] - numbers[0]), "nearly all commands came in time"


def test_the_site_in_the_middle_is_killed(sites: Sites) -> None:
    """Red and blue reach each other through base's bridge. It is killed, and comes again; red's comes again, too."""
    sites.start(sites.base, "--take", "*:**")
    sites.start(sites.red, "--send", "/small")
    sites.start(sites.blue, "--take", "red:**", core="ours")
    sites.talk(sites.red, image_rate=0)
    listener = sites.listen(sites.blue, "/red")
    for host, words in ((sites.base, ("--take", "*:**")), (sites.red, ("--send", "/small"))):
        bridge = sites.bridges[host.name]
        bridge.signal(signal.SIGKILL)
        bridge.wait()
        start = len(listener.lines)
        sites.start(host, *words)
        until(lambda: len(small(parse(listener.lines[start:]))) > 100, "commands come again", WAIT)  # noqa: B023
    assert_in_order(parse(listener.lines))


def test_three_sites_that_exchange_everything(sites: Sites) -> None:
    """There are no loops: each message comes once, and nothing is offered by a site it does not belong to."""
    for host in (sites.base, sites.red, sites.blue):
        sites.start(host, "--send", "/**", "--take", "*:**")
    for host, others in ((sites.base, ("red", "blue")), (sites.red, ("base", "blue")), (sites.blue, ("base", "red"))):
        sites.await_present(host, *others)
    robot = sites.peer(sites.red, "rospy", "robot")
    robot.advertise("/odom", TEXT)
    listeners = [sites.peer(host, "roscpp", "listener") for host in (sites.base, sites.blue)]
    for host, listener in zip((sites.base, sites.blue), listeners, strict=True):
        sites.await_topic(host, "/red/odom")
        listener.subscribe("/red/odom", TEXT)
    for host in (sites.base, sites.blue):
        until(lambda: "/red/odom" in sites.status(host) and "subscribed" in sites.status(host), "subscribed", WAIT)  # noqa: B023
    robot.tell("linked", "/odom", 1)
    robot.event("linked", "/odom", timeout=WAIT)
    bodies = [robot.publish("/odom", seed) for seed in range(20)]
    for listener in listeners:
        assert [listener.received("/red/odom", timeout=WAIT) for _ in bodies] == bodies
        assert not listener.unread("^got /red/odom")
    for host in (sites.base, sites.red, sites.blue):
        assert not sites.is_published(host, "/base/red/odom") and not sites.is_published(host, "/blue/red/odom")
