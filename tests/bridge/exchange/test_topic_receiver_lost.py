"""What becomes of the topics of a site that is lost, and that returns."""

from __future__ import annotations

import pytest

from pyros1.bridge.exchange.actions import (
    Action,
    Advertise,
    Forget,
    Listen,
    Publish,
    RepresentNode,
    Send,
    SetOrigins,
    Withdraw,
)
from pyros1.bridge.exchange.peer import State
from pyros1.bridge.exchange.site import Site
from pyros1.bridge.exchange.streams import MESSAGE_COST
from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol import packets
from pyros1.bridge.protocol.packets import Flag, Kind, Request, Tail

from .test_site import OWN, STRING, Liar, offered, only, rules, wanted

MAP, GOAL = SharedName("red", "/map"), SharedName("red", "/goal")


@pytest.fixture
def red() -> Liar:
    return Liar(Site(rules("take: [{topic: 'red:/odom', age: 9}, 'red:**']"), OWN, 0.0))


def lose(red: Liar) -> list[Action]:
    """Let red be silent until it is lost."""
    red.now += 6.0
    actions = red.take(red.site.tick(red.now))
    assert [each.state for each in red.site.sites()] == [State.LOST]
    return actions + red.take(red.site.set_subscribed([], red.now))


def requested(actions: list[Action]) -> list[list[Request]]:
    """Return the lists of requests among packets."""
    return [
        list(packets.decode_request(action.body).entries)
        for action in only(Send, actions)
        if packets.decode_head(action.head).kind is Kind.REQUEST
    ]


def test_topics_of_a_lost_site_are_withdrawn_and_come_back(red: Liar) -> None:
    wanted(red)
    assert only(Publish, red.message(1))
    actions = lose(red)
    assert [each.local for each in only(Withdraw, actions)] == ["/red/odom"]
    assert [each.on for each in only(Listen, actions)] == [False]
    assert [each.state for each in red.site.received_topics()] == ["site lost"]
    actions = red.heartbeat()
    assert [each.local for each in only(Advertise, actions)] == ["/red/odom"] and not only(Listen, actions)
    assert not red.message(2), "nobody has subscribed again yet"
    actions = red.take(red.site.set_subscribed(["/red/odom"], red.now))
    assert [each.on for each in only(Listen, actions)] == [True]
    assert not only(Publish, red.message(1)) and only(Publish, red.message(3))


def test_reliable_messages_of_an_outage_come_after_it(red: Liar) -> None:
    wanted(red, offered(reliable=True))
    red.begin()
    assert only(Publish, red.message(1))
    lose(red)
    tails = {SharedName("red", "/odom"): Tail(2, 0)}
    assert all(requested(red.heartbeat(tails=tails))), "the request holds"
    red.take(red.site.set_subscribed(["/red/odom"], red.now))
    actions = red.heartbeat(tails=tails)
    assert any(packets.decode_head(each.head).kind is Kind.RESEND_REQUEST for each in only(Send, actions))
    assert only(Publish, red.message(2, received_at=red.now + 5000 - 4.0))


def test_latched_messages_are_published_again(red: Liar) -> None:
    wanted(red, offered(MAP, latched=True))
    assert only(Publish, red.message(1, topic=MAP, flags=Flag.LATCHED))
    lose(red)
    red.heartbeat()
    red.take(red.site.set_subscribed(["/red/map"], red.now))
    assert [each.latched for each in only(Publish, red.message(1, topic=MAP, flags=Flag.LATCHED))] == [True]


def test_what_never_counts_as_latched_is_not_published_again() -> None:
    """A cancellation from before an outage must not end what was begun after it."""
    red = Liar(Site(rules("take: [{topic: 'red:/map', age: 9}]"), OWN, 0.0))
    wanted(red, offered(MAP, latched=True))
    assert [each.latched for each in only(Publish, red.message(1, topic=MAP, flags=Flag.LATCHED))] == [False]
    lose(red)
    red.heartbeat()
    red.take(red.site.set_subscribed(["/red/map"], red.now))
    assert not only(Publish, red.message(1, topic=MAP, flags=Flag.LATCHED))
    assert only(Publish, red.message(2, topic=MAP, flags=Flag.LATCHED))


def test_who_does_not_subscribe_again_wants_nothing_any_more(red: Liar) -> None:
    wanted(red)
    lose(red)
    red.heartbeat()
    before = len(red.actions)
    for _ in range(12):
        red.now += 1.0
        red.heartbeat()
        red.take(red.site.tick(red.now))
    assert requested(red.actions[before:])[-1] == []


@pytest.mark.parametrize("is_latched", [True, False])
def test_who_subscribes_again_goes_on_for_good(red: Liar, is_latched: bool) -> None:
    """The pause ends with that: once, ten seconds later, latched messages came again, and notes of publishers that are
    gone had no effect.
    """
    wanted(red, offered(MAP, latched=is_latched, reliable=not is_latched))
    flags = Flag.LATCHED if is_latched else 0
    red.begin(MAP)
    red.message(1, topic=MAP, flags=flags)
    lose(red)
    red.heartbeat()
    red.take(red.site.set_subscribed(["/red/map"], red.now))
    assert only(Publish, red.message(2, topic=MAP, flags=flags))
    for _ in range(12):
        red.now += 1.0
        red.heartbeat()
        red.take(red.site.tick(red.now))
    assert not only(Publish, red.message(2, topic=MAP, flags=flags))
    if is_latched:
        assert only(Forget, red.message(3, b"", topic=MAP, flags=Flag.LEFT))
    else:
        red.message(4, bytes(100), topic=MAP)
        assert red.site.topic_receiver.buffered["red"].total == MESSAGE_COST + 100, "message 3 was not given up"


@pytest.mark.parametrize("is_withdrawn", [True, False])
def test_nothing_is_kept_back_after_a_pause(red: Liar, is_withdrawn: bool) -> None:
    wanted(red, offered(reliable=True))
    red.begin()
    red.message(1)
    red.message(3, bytes(100))
    lose(red)
    red.heartbeat()
    buffered = red.site.topic_receiver.buffered
    assert buffered["red"].total == MESSAGE_COST + 100, "it may still be wanted again"
    if is_withdrawn:
        red.offer()
    else:
        red.now += 10.5
        red.take(red.site.tick(red.now))
    assert buffered["red"].total == 0


def test_a_topic_that_another_site_sends_too_stays(red: Liar) -> None:
    site = Site(rules("{take: ['*:/odom'], prefix: {'*': /robots}}"), OWN, 0.0)
    red, blue = Liar(site), Liar(site, 33, "blue")
    for each in (red, blue):
        each.heartbeat()
        each.heartbeat()
        each.offer(offered(SharedName(each.name, "/odom"), publishers=("/driver",)))
        each.define()
    red.take(site.set_subscribed(["/robots/odom"], 0.5))
    for _ in range(6):
        blue.now += 1.0
        blue.heartbeat()
        actions = red.take(site.tick(blue.now))
        assert not only(Withdraw, actions)
    assert [each.on for each in only(Listen, red.actions) if each.site == "red"] == [True, False]
    assert only(SetOrigins, red.actions)[-1].origins == ("blue:/driver",)
    assert {each.name: each.state for each in site.sites()} == {"red": State.LOST, "blue": State.PRESENT}
    assert only(Publish, blue.message(1, topic=SharedName("blue", "/odom")))


def test_nodes_are_represented_while_their_site_is_present(red: Liar) -> None:
    wanted(red)
    assert only(RepresentNode, red.heartbeat(nodes=["/talker"])) == [RepresentNode("/red/talker", "red", "/talker")]
    assert [each.nodes for each in red.site.sites()] == [["/red/talker"]]
    assert only(RepresentNode, lose(red)) == [RepresentNode("/red/talker", "", "")]
    assert only(RepresentNode, red.heartbeat(nodes=["/talker"])) == [RepresentNode("/red/talker", "red", "/talker")]
    assert only(RepresentNode, red.send(Kind.BYE)) == [RepresentNode("/red/talker", "", "")]


def test_recorded_heartbeats_bring_no_node_back(red: Liar) -> None:
    wanted(red)
    red.heartbeat(nodes=["/talker"], is_separate=True)
    recorded = red.number
    red.heartbeat()
    assert [each.nodes for each in red.site.sites()] == [[]], "the talker has died"
    red.number = recorded - 1  # the next heartbeat gets the recorded number
    assert not only(RepresentNode, red.heartbeat(nodes=["/talker"]))
    red.number = recorded - 1
    assert not only(Listen, red.heartbeat(is_separate=True))


def test_nodes_of_a_site_that_has_started_again_are_others(red: Liar) -> None:
    on, off = RepresentNode("/red/talker", "red", "/talker"), RepresentNode("/red/talker", "", "")
    wanted(red)
    assert only(RepresentNode, red.heartbeat(nodes=["/talker"])) == [on]
    again = Liar(red.site, red.epoch + 1)
    again.now = 1.0
    again.heartbeat(nodes=["/talker"])
    again.take(red.site.tick(again.now))
    again.heartbeat(nodes=["/talker"])
    again.offer(offered())
    again.heartbeat(nodes=["/talker"])
    assert only(RepresentNode, again.actions) == [off, on]


def test_nodes_of_sites_whose_topics_nobody_wants_are_not_represented(red: Liar) -> None:
    red.meet()
    assert not only(RepresentNode, red.heartbeat(nodes=["/talker"]))
    red.offer(offered())
    red.define()
    assert not only(RepresentNode, red.heartbeat(nodes=["/talker"])), "it only offers something"
    red.take(red.site.set_subscribed(["/red/odom"], red.now))
    assert only(RepresentNode, red.heartbeat(nodes=["/talker"])) == [RepresentNode("/red/talker", "red", "/talker")]
    red.take(red.site.set_subscribed([], red.now))
    assert only(RepresentNode, red.heartbeat(nodes=["/talker"])) == [RepresentNode("/red/talker", "", "")]


def test_a_node_that_is_found_or_lost_is_told_of_at_once() -> None:
    red = Liar(Site(rules("{send: [/map]}"), OWN, 0.0))
    topic = LocalTopic("/map", "std_msgs/String", STRING._md5sum, "string data\n", False, ("/left", "/right"))
    red.meet()
    red.site.set_topics([topic], 0.0, 0.0)

    def told(responding: list[str]) -> list[list[str]]:
        actions = only(Send, red.site.set_responding(responding, 0.0))
        return [[*packets.decode_heartbeat(each.body).nodes] for each in actions]

    assert told(["/left"]) == [], "red does not want it"
    red.send(Kind.REQUEST, next(packets.encode_pages(1, [Request(SharedName("base", "/map"), 0.0)])))
    red.take(red.site.tick(2.0))
    assert told(["/left", "/right", "/else"]) == [["/left", "/right"]]
    assert told(["/right", "/left"]) == []
    assert told(["/right"]) == [["/right"]]
