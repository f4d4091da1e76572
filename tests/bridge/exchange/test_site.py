"""A site's machine alone: against others that lie, flood and repeat, and in situations that schedules seldom bring."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest

from pyros1.bridge.exchange import topic_receiver
from pyros1.bridge.exchange.actions import (
    Action,
    Advertise,
    Forget,
    Listen,
    Log,
    ProbeReply,
    Publish,
    Send,
    SetOrigins,
    Source,
    Subscribe,
    Withdraw,
)
from pyros1.bridge.exchange.outgoing import DropReason, ReceivedMessage
from pyros1.bridge.exchange.peer import FORGET_DELAY, HEARD_DELAY, State
from pyros1.bridge.exchange.site import MAX_SITES, Site
from pyros1.bridge.exchange.slow_sites import FIRST_TIME, OVERLAP
from pyros1.bridge.exchange.streams import MESSAGE_COST, NewestStream
from pyros1.bridge.exchange.topic_receiver import MAX_TOPICS, TopicReceiver
from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol import packets
from pyros1.bridge.protocol.key_expressions import Channel, Key, parse_key, site_key
from pyros1.bridge.protocol.packets import Definition, Flag, Kind, MessageHead, OfferedTopic, Request
from pyros1.bridge.rules.namespaces import UsedTopics
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import NEWEST_AGE, Priority, Rules
from pyros1.bridge.transport.memory_link import MemoryNetwork
from pyros1.msgs import load_message

STRING: Any = load_message("std_msgs/String")
TWIST: Any = load_message("geometry_msgs/Twist")
GOAL: Any = load_message("actionlib/TestActionGoal")
OWN, THEIR = 11, 22
ODOM = SharedName("red", "/odom")


def rules(text: str, site: str = "base") -> Rules:
    return parse_config(text, "f", site).rules


class Liar:
    """A site, as its packets look to another one. It follows the protocol as far as a test lets it."""

    def __init__(self, site: Site, epoch: int = THEIR, name: str = "red") -> None:
        self.site, self.name = site, name
        self.epoch = epoch
        self.now = 0.0
        self.actions: list[Action] = []
        self.number = 0
        self.version = 0

    def take(self, actions: list[Action]) -> list[Action]:
        self.actions += actions
        return actions

    def send(self, kind: Kind, body: bytes = b"", to_epoch: int = OWN, channel: Channel = Channel.TO) -> list[Action]:
        key = Key(self.name, channel, "base" if channel is Channel.TO else "")
        return self.take(self.site.on_packet(key, packets.encode_head(kind, self.epoch, to_epoch), body, self.now))

    def heartbeat(self, **changes: Any) -> list[Action]:
        """Answer the last heartbeat that came."""
        heartbeats = [
            packets.decode_heartbeat(action.body)
            for action in self.actions
            if isinstance(action, Send)
            and action.key == f"to/{self.name}"
            and packets.decode_head(action.head).kind is Kind.HEARTBEAT
        ]
        self.number += 1
        echo = heartbeats[-1].number if heartbeats else 0
        heartbeat = packets.Heartbeat(self.number, self.now + 5000, echo, 0.0, self.version, 1, 99, 99, {})
        return self.send(Kind.HEARTBEAT, packets.encode_heartbeat(heartbeat._replace(**changes)))

    def meet(self) -> None:
        self.heartbeat()
        self.heartbeat()
        assert {each.name: each.state for each in self.site.sites()}[self.name] is State.PRESENT

    def offer(self, *offers: OfferedTopic) -> list[Action]:
        self.version += 1
        return [action for body in packets.encode_pages(self.version, offers) for action in self.send(Kind.OFFER, body)]

    def define(
        self, type_name: str = "std_msgs/String", md5sum: str = STRING._md5sum, text: str = "string data\n"
    ) -> Any:
        return self.send(Kind.DEFINITION, packets.encode_definition(Definition(type_name, md5sum, text)))

    def begin(self, topic: SharedName = ODOM, before: int = 0) -> list[Action]:
        """Tell with which message a topic begins for the other site."""
        return self.heartbeat(tails={topic: packets.Tail(before, before)})

    def message(self, number: int, body: bytes = b"x", topic: SharedName = ODOM, **changes: Any) -> list[Action]:
        head = MessageHead(self.epoch, 0, number, 1, self.now + 5000, 0, STRING._md5sum)
        key = Key(self.name, Channel.TOPIC, "", topic)
        return self.take(
            self.site.on_packet(key, packets.encode_message_head(head._replace(**changes)), body, self.now)
        )


def offered(topic: SharedName = ODOM, **changes: Any) -> OfferedTopic:
    return OfferedTopic(topic, "std_msgs/String", STRING._md5sum, False, False)._replace(**changes)


def only(kind: type, actions: list[Action]) -> list[Any]:
    return [action for action in actions if isinstance(action, kind)]


@pytest.fixture
def liar() -> Liar:
    return Liar(Site(rules("{take: ['red:**', /cmd_vel], send: [/map]}"), OWN, 0.0))


def all_taken() -> Site:
    """Return a site that takes everything, and whose nodes use no topics."""
    site = Site(rules("take: ['*:**']"), OWN, 0.0)
    site.set_used_topics(UsedTopics(frozenset(), frozenset()), 0.0)
    return site


def wanted(liar: Liar, *offers: OfferedTopic) -> None:
    """Let the liar offer topics that nodes at the base want."""
    liar.meet()
    liar.offer(*(offers or (offered(),)))
    liar.define()
    liar.take(liar.site.set_subscribed(["/red/odom", "/red/map", "/cmd_vel"], liar.now))
    liar.now += 0.5
    liar.heartbeat()


def test_a_topic_of_another_site_in_time(liar: Liar) -> None:
    wanted(liar)
    assert only(Advertise, liar.actions) == [
        Advertise("/red/odom", "std_msgs/String", STRING._md5sum, "string data\n", False)
    ]
    assert only(Listen, liar.actions) == [Listen("red", "t/red/odom", True)]
    (publish,) = only(Publish, liar.message(1))
    assert publish[:4] == ("/red/odom", Source("red", ODOM, 1), b"x", False)


def test_latched_messages_of_two_topics_with_one_name_here() -> None:
    """Publishers are numbered in each topic, so both are number 1."""
    site = Site(rules("take: [{topic: 'red:/a/**', here: '/x/**'}, {topic: 'red:/b/**', here: '/x/**'}]"), OWN, 0.0)
    liar = Liar(site)
    liar.meet()
    first, second = SharedName("red", "/a/map"), SharedName("red", "/b/map")
    liar.offer(offered(first, latched=True), offered(second, latched=True))
    liar.define()
    liar.take(site.set_subscribed(["/x/map"], 0.0))
    for topic in (first, second):
        assert only(Publish, liar.message(1, topic=topic, flags=Flag.LATCHED)) == [
            Publish("/x/map", Source("red", topic, 1), b"x", True)
        ]
    assert only(Forget, liar.message(2, b"", first, flags=Flag.LEFT)) == [Forget("/x/map", Source("red", first, 1))]
    assert only(Forget, liar.offer(offered(first, latched=True))) == [Forget("/x/map", Source("red", second, 1))]


def test_other_publishers_of_a_topic_change_nothing_else(liar: Liar) -> None:
    wanted(liar, offered(publishers=("/driver",)))
    assert only(Advertise, liar.actions)[-1].origins == ("red:/driver",)
    liar.message(1)
    actions = liar.offer(offered(publishers=("/driver", "/driver2")))
    assert [action for action in actions if not isinstance(action, Send)] == [
        SetOrigins("/red/odom", ("red:/driver", "red:/driver2"))
    ]
    assert only(Publish, liar.message(1)) == [] and len(only(Publish, liar.message(2))) == 1


def test_not_all_publishers_of_a_topic_are_named() -> None:
    liar = Liar(Site(rules("{take: [{topic: 'red:/odom', here: /x}, {topic: 'red:/map', here: /x}]}"), OWN, 0.0))
    names = tuple(f"/driver{number}" for number in range(8))
    wanted(liar, offered(publishers=names), offered(SharedName("red", "/map"), publishers=names))
    assert only(Advertise, liar.actions)[-1].origins == tuple(sorted(2 * [f"red:{name}" for name in names])[:8])


def test_messages_of_a_site_that_has_not_answered_do_not_count(liar: Liar) -> None:
    liar.send(Kind.HELLO, to_epoch=0, channel=Channel.HELLO)
    liar.offer(offered())
    liar.message(1)
    assert not only(Advertise, liar.actions) and not only(Publish, liar.actions)
    assert {*liar.site.ignored} == {
        "red: packets from a run that is not current",
        "red: messages from a run that is not current",
    }


def test_topics_of_third_sites_are_refused(liar: Liar) -> None:
    wanted(liar, offered(SharedName("blue", "/odom")), offered(SharedName("base", "/odom")), offered())
    states = {str(received.topic): received.state for received in liar.site.received_topics()}
    assert states == {
        "blue:/odom": "red offers a topic of another site",
        "base:/odom": "no rule takes it",
        "red:/odom": "subscribed",
    }


def test_messages_that_nobody_asked_for_are_dropped(liar: Liar) -> None:
    wanted(liar)
    for topic in (SharedName("red", "/secret"), SharedName("base", "/cmd_vel"), SharedName("blue", "/odom")):
        assert liar.message(1, topic=topic) == []


def test_messages_of_another_type_under_a_known_name(liar: Liar) -> None:
    wanted(liar)
    assert liar.message(1, md5sum="0" * 32) == []
    assert liar.site.received_topics()[0].flow.drops == {DropReason.TYPE: 1}


def test_a_definition_that_lies(liar: Liar) -> None:
    liar.meet()
    liar.offer(offered())
    liar.define(text="string lie\n")
    assert [action.definition for action in only(Advertise, liar.actions)] == [""]


def test_a_site_that_does_not_answer_withholds_no_definitions_of_others() -> None:
    site = all_taken()
    silent, red = Liar(site, name="a_silent_one"), Liar(site)
    for liar in (silent, red):
        liar.meet()
        liar.offer(offered(SharedName(liar.name, "/odom")))
    asked = [
        action.key
        for action in [*silent.actions, *red.actions, *site.tick(0.1)]
        if isinstance(action, Send) and packets.decode_head(action.head).kind is Kind.ASK
    ]
    assert sorted(asked) == ["to/a_silent_one", "to/red"]
    assert {each.local for each in only(Advertise, red.define())} == {"/red/odom", "/a_silent_one/odom"}


def test_a_site_that_comes_later_has_the_definition_that_an_earlier_one_has_not() -> None:
    site = all_taken()
    liar, red = Liar(site, name="liar"), Liar(site)
    liar.meet()
    liar.offer(offered(SharedName("liar", "/odom")))
    assert [each.definition for each in only(Advertise, liar.define(text="junk"))] == [""]
    red.meet()
    red.offer(offered())
    assert [each.definition for each in only(Advertise, red.define())] == ["string data\n"] * 2


def test_a_definition_of_a_type_that_is_not_offered_is_not_kept(liar: Liar) -> None:
    """Otherwise a site could use up the space for those of others, with an md5 sum that was asked for once."""
    wanted(liar)
    other = offered(SharedName("red", "/map"), type="far_msgs/Other")
    assert liar.define("far_msgs/Other") == []
    assert only(Advertise, liar.offer(offered(), other)) == []
    assert [each.local for each in only(Advertise, liar.define("far_msgs/Other"))] == ["/red/map"]


def test_publishers_that_are_gone_do_not_count() -> None:
    liar = Liar(Site(rules("take: [{topic: 'red:/odom', rate: 10}]"), OWN, 0.0))
    wanted(liar)
    for number in range(1, 1001):
        assert len(only(Publish, liar.message(number, publisher=number))) == 1
    assert only(Publish, liar.message(1001, publisher=1001)) == []
    assert liar.site.received_topics()[0].flow.drops == {DropReason.PUBLISHERS: 1}
    liar.now += 1
    assert len(only(Publish, liar.message(1002, publisher=1002))) == 1


def test_messages_that_are_too_large_and_too_many(liar: Liar) -> None:
    site = Site(rules("take: [{topic: 'red:/odom', size: 10, rate: 2}]"), OWN, 0.0)
    liar = Liar(site)
    wanted(liar)
    assert liar.message(1, bytes(11)) == []
    published = 0
    for number in range(2, 1000):
        liar.now += 0.001
        published += len(only(Publish, liar.message(number)))
    assert 2 <= published <= 4
    assert {*site.received_topics()[0].flow.drops} == {DropReason.SIZE, DropReason.RATE}


def test_old_messages_are_dropped(liar: Liar) -> None:
    wanted(liar)
    liar.now += 20
    liar.heartbeat()
    liar.take(liar.site.tick(liar.now))
    liar.heartbeat()
    assert liar.message(1, received_at=liar.now + 5000 - 3.0) == [] and only(Publish, liar.message(2))
    assert liar.message(2) == [] and liar.message(1) == []
    assert liar.site.received_topics()[0].flow.drops == {DropReason.OLD: 1}


def test_messages_expire_when_they_reach_their_maximum_age(liar: Liar) -> None:
    """They may have to wait for the master before they are published."""
    wanted(liar, offered(), offered(SharedName("red", "/map"), latched=True))
    liar.now += 1.0
    liar.heartbeat()
    (publish,) = only(Publish, liar.message(1, received_at=liar.now + 5000 - 0.5))
    assert publish.expires == pytest.approx(liar.now + NEWEST_AGE - 0.5, abs=0.01)
    latched = liar.message(1, topic=SharedName("red", "/map"), flags=Flag.LATCHED)
    assert [each.expires for each in only(Publish, latched)] == [None]


def test_latched_messages_may_be_old_but_others_of_their_topic_not(liar: Liar) -> None:
    wanted(liar, offered(latched=True))
    old = liar.now + 5000 - 100
    assert len(only(Publish, liar.message(1, received_at=old, flags=Flag.LATCHED))) == 1
    assert only(Publish, liar.message(2, received_at=old)) == []
    assert len(only(Publish, liar.message(3))) == 1


def test_a_latched_message_is_forgotten_if_the_next_one_is_too_large_here() -> None:
    """Later subscribers must not get an old map as the current one."""
    liar = Liar(Site(rules("take: [{topic: 'red:/odom', size: 10}]"), OWN, 0.0))
    wanted(liar, offered(latched=True))
    source = Source("red", ODOM, 1)
    assert only(Publish, liar.message(1, bytes(10), flags=Flag.LATCHED))
    assert liar.message(2, bytes(11), flags=Flag.LATCHED) == [Forget("/red/odom", source)]
    assert [each.source for each in only(Publish, liar.message(3, bytes(9), flags=Flag.LATCHED))] == [source]
    assert liar.message(4, flags=Flag.LEFT) == [Forget("/red/odom", source)]


@pytest.mark.parametrize(
    ("cls", "settings"),
    [(TWIST, ""), (GOAL, ""), (load_message("actionlib_msgs/GoalID"), ""), (STRING, ", age: 9")],
    ids=["command", "goal", "cancel", "age in the rule"],
)
def test_commands_are_never_latched(cls: Any, settings: str) -> None:
    """Who commands by hand latches (`rostopic pub`). After an outage, that must not be carried out again."""
    liar = Liar(Site(rules(f"take: [{{topic: /cmd, here: /cmd{settings}}}]"), OWN, 0.0))
    command = offered(SharedName("base", "/cmd"), type=cls._type, md5sum=cls._md5sum, latched=True, reliable=True)
    liar.meet()
    liar.offer(command)
    assert [each.latched for each in only(Advertise, liar.define(cls._type, cls._md5sum, cls._full_text))] == [False]
    liar.take(liar.site.set_subscribed(["/cmd"], liar.now))
    liar.now += 0.5
    liar.heartbeat()
    message: Any = {"topic": command.topic, "md5sum": cls._md5sum, "flags": Flag.LATCHED}
    assert [each.latched for each in only(Publish, liar.message(1, **message))] == [False]
    assert only(Publish, liar.message(2, received_at=liar.now + 5000 - 31, **message)) == []
    assert not only(Publish, liar.message(3, b"", **message | {"flags": Flag.LEFT}))
    assert only(Publish, liar.message(5, **message)), "the other site would not send message 4 again"


def test_commands_are_not_offered_as_latched() -> None:
    site = Site(rules("{send: [red:/cmd_vel, red:/goal, red:/cancel, /map, {topic: /plan, age: 9}]}"), OWN, 0.0)
    liar = Liar(site)
    cancel: Any = load_message("actionlib_msgs/GoalID")
    types = {"/red/cmd_vel": TWIST, "/red/goal": GOAL, "/red/cancel": cancel, "/map": STRING, "/plan": STRING}
    topics = [
        LocalTopic(name, cls._type, cls._md5sum, cls._full_text, True, ("/publisher",)) for name, cls in types.items()
    ]
    liar.take(site.set_topics(topics, liar.now, liar.now))
    liar.meet()
    liar.take(site.tick(liar.now))
    offers = [
        entry
        for action in only(Send, liar.actions)
        if packets.decode_head(action.head).kind is Kind.OFFER
        for entry in packets.decode_offer(action.body).entries
    ]
    assert {each.topic.name for each in offers} == {"/cmd_vel", "/goal", "/cancel", "/map", "/plan"}
    assert {each.topic.name for each in offers if each.latched} == {"/map"}


def test_what_was_sent_before_it_was_wanted_is_dropped(liar: Liar) -> None:
    wanted(liar)
    assert liar.message(1, received_at=5000 - 0.2) == []
    assert liar.site.received_topics()[0].flow.drops == {DropReason.EARLY: 1}


def test_recorded_packets_of_an_earlier_run(liar: Liar) -> None:
    wanted(liar)
    later = Liar(liar.site, epoch=33)
    later.now, later.actions = liar.now, liar.actions
    later.heartbeat()
    later.heartbeat()
    assert only(Log, later.actions)[-1].text == "site red is present"
    for replayed in (liar.message(5), liar.offer(offered()), liar.heartbeat()):
        assert not only(Publish, replayed) and not only(Advertise, replayed)
    assert liar.site.sites()[0].state is State.PRESENT


@pytest.mark.parametrize("number", [2, 3])
def test_bridges_with_one_name_are_reported_once(liar: Liar, number: int) -> None:
    """They take turns all the time."""
    liars = [liar, *(Liar(liar.site, epoch=33 + more) for more in range(number - 1))]
    logs = []
    for turn in range(5 * number):
        each = liars[turn % number]
        each.actions.clear()
        each.now = turn + 1.0
        each.heartbeat()
        each.heartbeat()
        logs += only(Log, [*each.actions, *liar.site.tick(each.now)])
    assert sum(log.text == "site red is present" for log in logs) == number
    assert sum("two bridges are named red" in log.text for log in logs) == 1
    assert len(logs) == number + 1
    assert [each.is_shared for each in liar.site.sites()] == [True]
    for passed in range(1, 61):
        each.now += 1.0
        each.heartbeat()
        each.actions = liar.site.tick(each.now)
        assert liar.site.sites()[0].is_shared == (passed < 60), "only one of them is left"


def test_requests_for_what_is_not_offered(liar: Liar) -> None:
    site = liar.site
    liar.meet()
    topics = [LocalTopic(name, "std_msgs/String", STRING._md5sum, "", False, ("/n",)) for name in ("/map", "/secret")]
    liar.take(site.set_topics(topics, 0.0, 0.0))
    requests = [Request(SharedName("base", name), 0.0) for name in ("/map", "/secret", "/none")]
    for body in packets.encode_pages(1, requests):
        liar.send(Kind.REQUEST, body)
    assert only(Subscribe, liar.actions) == [Subscribe("/map", True)]
    received = ReceivedMessage("/n", STRING._md5sum, False, b"x")
    assert site.on_message("/secret", received, False, 0.0) == []
    assert [action.key for action in only(Send, site.on_message("/map", received, False, 0.0))] == ["t/base/map"]
    liar.send(Kind.BYE)
    assert only(Subscribe, liar.actions)[-1] == Subscribe("/map", False)


def request(liar: Liar, *names: SharedName) -> list[Send]:
    liar.version += 1
    entries = [Request(name, 0.0) for name in names]
    return only(
        Send, [a for page in packets.encode_pages(liar.version, entries) for a in liar.send(Kind.REQUEST, page)]
    )


def test_what_is_for_some_sites_only_is_sent_to_each_of_them() -> None:
    """Where others could subscribe to it, they could read it.

    Feature: topics that are only for some sites are kept from others with keys
    """
    text = "send: [{topic: /secret, sites: [red, blue]}, /public, 'red:/cmd']"
    site = Site(rules(text), OWN, 0.0)
    liars = [Liar(site, name="red"), Liar(site, epoch=33, name="blue"), Liar(site, name="green")]
    names = [SharedName("base", "/secret"), SharedName("base", "/public"), SharedName("red", "/cmd")]
    for liar in liars:
        liar.meet()
    topics = [
        LocalTopic(name, "std_msgs/String", STRING._md5sum, "", False, ("/n",))
        for name in ("/secret", "/public", "/red/cmd")
    ]
    site.set_topics(topics, 0.0, 0.0)
    for liar in liars:
        request(liar, *names)

    def keys(local: str) -> dict[str, int]:
        sent = only(Send, site.on_message(local, ReceivedMessage("/n", STRING._md5sum, False, b"x"), False, 0.0))
        assert all(each.replaces == 1 and each.may_drop and each.expires for each in sent)
        return {each.key: packets.decode_message_head(each.head).to_epoch for each in sent}

    assert keys("/secret") == {"again/red/base/secret": THEIR, "again/blue/base/secret": 33}
    assert keys("/public") == {"t/base/public": 0}
    assert keys("/red/cmd") == {"again/red/red/cmd": THEIR}
    assert {probe.site for probe in site.probes("", 1, Priority.LOW)} == {"red", "blue", "green"}
    request(liars[2], names[0])
    assert {probe.site for probe in site.probes("", 1, Priority.LOW)} == {"red", "blue"}


def separate_flags(site: Site, now: float) -> dict[str, bool]:
    """Return what the next heartbeats say of the sites for which they are."""
    sent = only(Send, site.tick(now))
    heartbeats = [each for each in sent if packets.decode_head(each.head).kind is Kind.HEARTBEAT]
    return {each.key: packets.decode_heartbeat(each.body).is_separate for each in heartbeats}


def test_a_slow_site_gets_packets_of_its_own() -> None:
    site = Site(rules("{send: [/public], loss: 60}"), OWN, 0.0)
    liars = [Liar(site, name="red"), Liar(site, epoch=33, name="blue")]
    for liar in liars:
        liar.meet()
    site.set_topics([LocalTopic("/public", "std_msgs/String", STRING._md5sum, "", False, ("/n",))], 0.0, 0.0)
    for liar in liars:
        request(liar, SharedName("base", "/public"))

    def keys() -> list[str]:
        received = ReceivedMessage("/n", STRING._md5sum, False, b"x")
        return sorted(each.key for each in only(Send, site.on_message("/public", received, False, 0.0)))

    assert site.on_slow("stranger", 0.0) == [] and keys() == ["t/base/public"]
    (heartbeat,) = only(Send, site.on_slow("blue", 0.0))
    assert heartbeat.key == "to/blue" and packets.decode_heartbeat(heartbeat.body).is_separate
    assert site.on_slow("blue", 0.0) == [], "that is known"
    assert keys() == ["again/blue/base/public", "t/base/public"]
    assert [each[0] for each in site.probes("", 1, Priority.LOW)] == ["red"]
    assert {each.name: each.is_slow for each in site.sites()} == {"red": False, "blue": True}
    assert separate_flags(site, FIRST_TIME - 0.1) == {"to/red": False, "to/blue": True}
    assert separate_flags(site, FIRST_TIME + 0.1) == {"to/blue": False}, "at once"
    assert keys() == ["again/blue/base/public", "t/base/public"], "until it listens to what is for all"
    site.tick(FIRST_TIME + OVERLAP)
    assert keys() == ["t/base/public"]


def test_a_site_that_sends_packets_for_this_one_alone(liar: Liar) -> None:
    """Then it does not listen to those for all."""
    liar.meet()
    names = [SharedName("red", name) for name in ("/a", "/b", "/c")]
    liar.offer(*map(offered, names))
    liar.define()

    def listened(is_separate: bool) -> list[Listen]:
        before = len(liar.actions)
        liar.heartbeat(is_separate=is_separate)
        return only(Listen, liar.actions[before:])

    liar.take(liar.site.set_subscribed(["/red/a", "/red/b"], liar.now))
    assert listened(False) == []
    assert listened(True) == [Listen("red", "t/red/a", False), Listen("red", "t/red/b", False)]
    assert listened(True) == []
    assert not only(Listen, liar.site.set_subscribed(["/red/a", "/red/b", "/red/c"], liar.now)), "it comes anyhow"
    assert [each.key for each in listened(False)] == ["t/red/a", "t/red/b", "t/red/c"]


def test_a_site_that_keeps_changing_how_it_sends(liar: Liar) -> None:
    wanted(liar)
    before = len(liar.actions)
    for number in range(100):
        liar.heartbeat(is_separate=number % 2 == 0)
    changes = [action.on for action in only(Listen, liar.actions[before:])]
    assert changes == [False, True, False]
    liar.now += 1.0
    liar.heartbeat(is_separate=False)
    assert only(Listen, liar.actions)[-1].on, "in the end, it gets what the site sends"


def test_definitions_of_what_is_not_offered(liar: Liar) -> None:
    liar.meet()
    topic = LocalTopic("/secret", "std_msgs/String", STRING._md5sum, "string data\n", False, ("/n",))
    liar.take(liar.site.set_topics([topic], 0.0, 0.0))
    assert liar.send(Kind.ASK, packets.encode_ask([STRING._md5sum])) == []


@pytest.mark.slow
def test_a_flood_of_topics(liar: Liar) -> None:
    liar.meet()
    liar.offer(*(offered(SharedName("red", f"/t{number}")) for number in range(MAX_TOPICS + 10)))
    liar.define()
    assert len(only(Advertise, liar.actions)) == MAX_TOPICS
    refused = [
        received for received in liar.site.received_topics() if received.state == "the site offers too many topics"
    ]
    assert len(refused) == 10


def test_lists_that_change_in_floods(liar: Liar) -> None:
    """Feature: a site that changes its lists in floods delays nothing of third ones"""
    liar.meet()
    applied = 0
    for number in range(300):
        liar.now += 0.01
        name = SharedName("red", f"/t{number}")
        applied += bool(only(Advertise, liar.offer(offered(name)) + liar.define()))
        applied += bool(only(Advertise, liar.take(liar.site.tick(liar.now))))
    assert applied in (5, 6)
    liar.now += 1.0
    advertised = only(Advertise, liar.take(liar.site.tick(liar.now)))
    assert [each.local for each in advertised] == ["/red/t299"], "the newest one counts"


@pytest.mark.slow
def test_topics_that_change_without_end_do_not_fill_the_memory(liar: Liar) -> None:
    liar.meet()
    for number in range(30):
        liar.now += 1.1
        liar.offer(*(offered(SharedName("red", f"/t{number}_{index}")) for index in range(200)))
    streams = liar.site.topic_receiver.streams
    assert 200 < len(streams) <= 2 * MAX_TOPICS
    for number in range(30):
        liar.now += 1.1
        liar.offer(
            offered(SharedName("red", "/t0_0")),
            *(offered(SharedName("red", f"/u{number}_{index}")) for index in range(200)),
        )
    assert len(streams) <= 201 + MAX_TOPICS and ("red", SharedName("red", "/t0_0")) in streams


@pytest.mark.parametrize("leaves", [True, False])
def test_lists_and_limits_of_a_site_that_starts_again(liar: Liar, leaves: bool) -> None:
    liar.meet()
    for _ in range(5):
        liar.offer()
        liar.offer(offered())
    if leaves:
        liar.send(Kind.BYE)
    later = Liar(liar.site, epoch=33)
    later.now = liar.now + 0.5
    later.meet()
    later.now += 1.0
    later.take(liar.site.tick(later.now))
    assert liar.site.received_topics() == [], "lists of the earlier run do not count"
    for _ in range(5):
        later.offer()
        later.offer(offered())
    assert liar.site.received_topics() == [], "not yet"
    later.now += 1.0
    later.take(liar.site.tick(later.now))
    assert len(liar.site.received_topics()) == 1


def test_nothing_is_kept_back_of_topics_that_are_not_wanted_any_more(liar: Liar) -> None:
    wanted(liar, offered(reliable=True))
    liar.begin()
    liar.message(1)
    liar.message(3, bytes(100))
    buffered = liar.site.topic_receiver.buffered
    assert buffered["red"].total == MESSAGE_COST + 100
    liar.take(liar.site.set_subscribed([], liar.now))
    assert buffered["red"].total == 0
    wanted(liar, offered(reliable=True))
    liar.begin(before=4)
    liar.message(5)
    liar.message(7, bytes(100))
    assert buffered["red"].total == MESSAGE_COST + 100 and liar.site.received_topics()[0].flow.messages == 2
    liar.now += 2
    liar.offer(offered())
    assert buffered["red"].total == 0 and liar.site.received_topics()[0].flow.messages == 2
    liar.send(Kind.BYE)
    assert buffered == {}


def test_a_flood_of_probes(liar: Liar) -> None:
    liar.meet()
    answers = []
    for number in range(5000):
        liar.now += 0.0002
        answers += only(Send, liar.send(Kind.PROBE, packets.encode_probe(number + 1)))
    assert 500 <= len(answers) <= 601
    assert {answer.key for answer in answers} == {"to/red"}


def test_a_site_is_told_at_once_where_a_requested_topic_begins() -> None:
    """A later heartbeat may overtake the first message, and would then count it."""
    liar = Liar(Site(rules("send: [{topic: /map, delivery: reliable}]"), OWN, 0.0))
    liar.meet()
    topic = LocalTopic("/map", "std_msgs/String", STRING._md5sum, "string data\n", False, ("/n",))
    liar.take(liar.site.set_topics([topic], 0.0, 0.0))
    blue, name = Liar(liar.site, 33, "blue"), SharedName("base", "/map")
    blue.meet()
    request(blue, name)
    message = ReceivedMessage("/n", STRING._md5sum, False, b"x")
    for _ in range(3):
        liar.site.on_message("/map", message, False, 0.0)

    def tails(asking: Liar) -> list[packets.Tail]:
        """Return the ends of topics in the last heartbeat to a site."""
        sent = [action for action in only(Send, asking.actions) if action.key == f"to/{asking.name}"]
        bodies = [each.body for each in sent if packets.decode_head(each.head).kind is Kind.HEARTBEAT]
        return [*packets.decode_heartbeat(bodies[-1]).tails.values()]

    request(liar, name)
    assert tails(liar) == [packets.Tail(3, 3)]
    liar.site.on_message("/map", message, False, 0.0)
    request(liar, name, SharedName("base", "/other"))
    assert tails(liar) == [packets.Tail(4, 3)], "it has been requested all the time"
    request(liar)
    assert tails(liar) == []
    liar.now += 2.0
    request(liar, name)
    assert tails(liar) == [packets.Tail(4, 4)]


def test_a_flood_of_questions() -> None:
    liar = Liar(Site(rules("send: [{topic: /map, delivery: reliable}]"), OWN, 0.0))
    liar.meet()
    topic = LocalTopic("/map", "std_msgs/String", STRING._md5sum, "string data\n", False, ("/n",))
    liar.take(liar.site.set_topics([topic], 0.0, 0.0))
    name = SharedName("base", "/map")
    for body in packets.encode_pages(1, [Request(name, 0.0)]):
        liar.send(Kind.REQUEST, body)
    for _ in range(100):
        liar.site.on_message("/map", ReceivedMessage("/n", STRING._md5sum, False, b"x"), False, 0.0)
    answers = 0
    for _ in range(1000):
        liar.now += 0.0005
        answers += len(
            liar.send(Kind.RESEND_REQUEST, packets.encode_resend_request(packets.ResendRequest(name, 0, 100)))
        )
        answers += len(liar.send(Kind.ASK, packets.encode_ask([STRING._md5sum] * 100)))
    assert 100 <= answers <= 6 * 101 + 6


def test_a_flood_of_questions_for_large_messages() -> None:
    """Feature: a site that asks for messages again in floods gets a limited number of bytes per second"""
    names = [f"/map{number}" for number in range(10)]
    liar = Liar(Site(rules("send: [{topic: '/**', delivery: reliable}]"), OWN, 0.0))
    liar.meet()
    topics = [LocalTopic(name, "std_msgs/String", STRING._md5sum, "string data\n", False, ("/n",)) for name in names]
    liar.take(liar.site.set_topics(topics, 0.0, 0.0))
    request(liar, *(SharedName("base", name) for name in names))
    for name in names:
        for _ in range(8):
            received = ReceivedMessage("/n", STRING._md5sum, False, bytes(1_000_000))
            liar.site.on_message(name, received, False, 0.0)

    def ask_for(seconds: float) -> int:
        size = 0
        for _ in range(int(seconds * 10)):
            liar.now += 0.1
            for name in names:
                body = packets.encode_resend_request(packets.ResendRequest(SharedName("base", name), 0, 100))
                size += sum(len(each.body) for each in only(Send, liar.send(Kind.RESEND_REQUEST, body)))
        return size

    assert 32e6 < ask_for(1.0) < 60e6
    assert 70e6 < ask_for(10.0) < 100e6


def test_a_heartbeat_costs_no_look_at_all_topics(liar: Liar, monkeypatch: pytest.MonkeyPatch) -> None:
    looked = []
    original = NewestStream.tick
    monkeypatch.setattr(NewestStream, "tick", lambda self, now: looked.append(self) or original(self, now))
    liar.meet()
    names = [SharedName("red", f"/t{number}") for number in range(50)]
    liar.offer(*map(offered, names))
    liar.define()
    liar.take(liar.site.set_subscribed([f"/red{name.name}" for name in names], 0.0))
    before = len(looked)
    for _ in range(100):
        liar.now += 0.001
        liar.heartbeat()
    assert len(looked) == before


def test_probes_are_answered_at_once(liar: Liar) -> None:
    assert liar.send(Kind.PROBE, packets.encode_probe(7)) == []
    liar.meet()
    (answer,) = only(Send, liar.send(Kind.PROBE, packets.encode_probe(7)))
    assert packets.decode_head(answer.head) == (Kind.PROBE_REPLY, OWN, THEIR) and packets.decode_probe(answer.body) == 7
    assert (answer.key, answer.priority) == ("to/red", Priority.URGENT)
    assert liar.send(Kind.PROBE_REPLY, packets.encode_probe(8)) == [ProbeReply("red", 8)]


def test_probes_go_to_sites_that_want_something(liar: Liar) -> None:
    liar.meet()
    assert liar.site.probes("", 1, Priority.LOW) == []
    topic = LocalTopic("/map", "std_msgs/String", STRING._md5sum, "", False, ("/n",))
    liar.take(liar.site.set_topics([topic], 0.0, 0.0))
    for body in packets.encode_pages(1, [Request(SharedName("base", "/map"), 0.0)]):
        liar.send(Kind.REQUEST, body)
    ((name, round_trip, probe),) = liar.site.probes("", 1, Priority.LOW)
    assert name == "red" and probe.key == "to/red" and probe.priority is Priority.LOW and round_trip == 0.0
    assert packets.decode_head(probe.head).kind is Kind.PROBE
    ((name, _, probe),) = liar.site.probes("red", 2, Priority.LOW)
    assert name == "red" and packets.decode_probe(probe.body) == 2
    assert liar.site.probes("stranger", 3, Priority.LOW) == []


def test_a_flood_of_sites() -> None:
    site = all_taken()
    for number in range(MAX_SITES + 50):
        key = Key(f"site{number}", Channel.HELLO)
        actions = site.on_packet(key, packets.encode_head(Kind.HELLO, 5), b"", 0.0)
        assert len(actions) <= 1
    assert len(site.sites()) == MAX_SITES and site.ignored == {"too many sites": 50}
    site.tick(HEARD_DELAY + 1)
    assert site.sites() == []  # so there is room for others soon


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """When a site has looked at all topics of others."""
    found: list[float] = []

    def apply(self: TopicReceiver, now: float) -> list[Action]:
        found.append(now)
        return original(self, now)

    original = TopicReceiver.apply
    monkeypatch.setattr(TopicReceiver, "apply", apply)
    return found


def test_lists_of_many_sites_are_looked_at_together(looks: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(topic_receiver, "UPDATE_RATE", 50)
    monkeypatch.setattr(topic_receiver, "UPDATE_BURST", 50)
    site = all_taken()
    liars = [Liar(site, THEIR, f"site{number}") for number in range(5)]
    for each in liars:
        each.actions = liars[0].actions  # heartbeats for one come after packets of others
        each.meet()
    looks.clear()
    for second in range(1, 11):
        for each in liars:
            each.now = float(second)
            each.heartbeat()
            each.offer(*(offered(SharedName(each.name, f"/t{number}_{second}")) for number in range(20)))
        for tick in range(1, 10):
            liars[0].take(site.tick(second + tick / 10))
    assert len(looks) <= 15  # and not 50
    site.tick(13.0)
    assert {topic.topic.name for topic in site.received_topics()} == {f"/t{number}_10" for number in range(20)}


@pytest.fixture
def fleet(looks: list[float]) -> list[Liar]:
    """Five sites that offer a topic each to a site, whose nodes subscribe to all of them."""
    site = all_taken()
    liars = [Liar(site, THEIR, f"site{number}") for number in range(5)]
    for each in liars:
        each.actions = liars[0].actions  # heartbeats for one come after packets of others
        each.meet()
        each.offer(offered(SharedName(each.name, "/odom")))
        each.define()
    liars[0].take(site.set_subscribed([f"/{each.name}/odom" for each in liars], 0.0))
    looks.clear()
    return liars


def topic_states(site: Site) -> list[str]:
    return [topic.state for topic in site.received_topics()]


def requested_of(name: str, actions: list[Action]) -> list[str]:
    """The topics that the last page of requests to a site asks for."""
    pages = [
        each.body
        for each in only(Send, actions)
        if each.key == f"to/{name}" and packets.decode_head(each.head).kind is Kind.REQUEST
    ]
    return [key for key, _ in packets.decode_page(pages[-1], 2, tuple).entries]


def test_topics_of_many_sites_are_looked_at_once_after_a_change_here(fleet: list[Liar], looks: list[float]) -> None:
    site = fleet[0].site
    actions = site.set_used_topics(UsedTopics(frozenset(["/site3/state"]), frozenset()), 0.0)
    assert [each.local for each in only(Withdraw, actions)] == ["/site3/odom"] and len(looks) == 1
    assert sorted(topic_states(site))[1:] == ["subscribed"] * 4
    assert requested_of("site3", actions) == []
    actions = site.set_used_topics(UsedTopics(frozenset(), frozenset()), 1.0)
    assert [each.local for each in only(Advertise, actions)] == ["/site3/odom"]
    assert requested_of("site3", actions) == ["site3:/odom"]
    assert len(looks) == 2


def test_topics_of_many_lost_sites_are_looked_at_once(fleet: list[Liar], looks: list[float]) -> None:
    site = fleet[0].site
    actions = site.tick(30.0)
    assert len(only(Withdraw, actions)) == len(only(Listen, actions)) == 5 and len(looks) == 1
    assert topic_states(site) == ["site lost"] * 5
    site.tick(30.0 + FORGET_DELAY)
    assert site.sites() == [] and topic_states(site) == [] and len(looks) == 2


def test_topics_of_many_sites_that_return_are_looked_at_together(
    fleet: list[Liar], looks: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    site = fleet[0].site
    fleet[0].take(site.tick(30.0))
    fleet[0].take(site.tick(31.0))
    looks.clear()
    actions: list[Action] = []
    monkeypatch.setattr(site.topic_receiver, "may_update", lambda now: now >= 31.1)  # the network is back for all
    for each in fleet:
        each.now = 31.0
        actions += each.heartbeat()
    assert {each.state for each in site.sites()} == {State.PRESENT} and not looks
    actions += site.tick(31.1)
    assert len(only(Advertise, actions)) == 5 and len(looks) == 1


@pytest.mark.slow
def test_definitions_in_floods_are_looked_at_together(looks: list[float]) -> None:
    liar = Liar(Site(rules("take: ['red:**']"), OWN, 0.0))
    liar.meet()
    md5sums = [f"{number:032x}" for number in range(1000)]
    liar.offer(*(offered(SharedName("red", f"/t{number}"), md5sum=each) for number, each in enumerate(md5sums)))
    looks.clear()
    for tick in range(20):
        liar.now = tick / 10
        liar.take(liar.site.tick(liar.now))
        for md5sum in md5sums[100 * tick : 100 * tick + 100]:
            liar.define(md5sum=md5sum)
    assert len(looks) <= 120  # and not 1000
    assert not any(topic.state for topic in liar.site.received_topics() if topic.state != "no subscribers here")
    assert len(only(Advertise, liar.actions)) == 1000


def test_long_definitions_in_floods_are_not_read() -> None:
    liar = Liar(Site(rules("take: ['red:**']"), OWN, 0.0))
    liar.meet()
    md5sums = [f"{number:032x}" for number in range(100)]
    liar.offer(*(offered(SharedName("red", f"/t{number}"), md5sum=each) for number, each in enumerate(md5sums)))
    text = "# a comment\n" * 20_000
    for md5sum in md5sums:
        liar.define(md5sum=md5sum, text=text)
    unread = liar.site.ignored["red: too many definitions"]
    assert unread > 80
    known = len(only(Advertise, liar.actions))
    assert known == 100 - unread
    liar.now = 60.0  # what was not read is asked for again
    liar.heartbeat()
    liar.heartbeat()
    liar.define(md5sum=md5sums[-1])
    assert len(only(Advertise, liar.actions)) == known + 1


def test_a_site_is_known_once_it_has_shown_that_it_is_there(liar: Liar) -> None:
    liar.send(Kind.HELLO, to_epoch=0, channel=Channel.HELLO)
    assert liar.site.known_sites() == frozenset()
    liar.meet()
    assert liar.site.known_sites() == {"red"}
    liar.now = FORGET_DELAY / 2
    liar.site.tick(liar.now)
    assert liar.site.sites()[0].state is State.LOST and liar.site.known_sites() == {"red"}
    liar.now += FORGET_DELAY
    liar.site.tick(liar.now)
    assert liar.site.known_sites() == frozenset()


def test_hellos_do_not_make_a_site_send_without_end(liar: Liar) -> None:
    sent = 0
    for number in range(1000):
        liar.epoch = number + 1
        liar.now += 0.001
        sent += len(liar.send(Kind.HELLO, to_epoch=0, channel=Channel.HELLO))
    assert sent <= 12


def test_packets_for_others_and_from_strangers() -> None:
    site = Site(rules("{sites: [blue], take: ['*:**']}"), OWN, 0.0)
    head = packets.encode_head(Kind.HELLO, 5)
    assert site.on_packet(Key("red", Channel.HELLO), head, b"", 0.0) == []
    assert site.on_packet(Key("blue", Channel.TO, "red"), head, b"", 0.0) == []
    assert site.sites() == []


def test_another_site_with_this_name_is_told_of(liar: Liar) -> None:
    head = packets.encode_head(Kind.HELLO, 5)
    key = Key("base", Channel.HELLO)
    assert [action.text for action in only(Log, liar.site.on_packet(key, head, b"", 0.0))] == [
        "another bridge is also named base: each site needs its own name"
    ]
    assert liar.site.on_packet(key, head, b"", 0.0) == []


def test_invalid_packets_are_counted(liar: Liar) -> None:
    liar.meet()
    kinds = [
        Kind.HEARTBEAT,
        Kind.OFFER,
        Kind.REQUEST,
        Kind.ASK,
        Kind.DEFINITION,
        Kind.RESEND_REQUEST,
        Kind.LATCHED_LIST,
        Kind.RESEND_REFUSAL,
    ]
    for kind in kinds:
        assert liar.send(kind, b"[]" if kind is not Kind.ASK else b"{}") == []
    assert sum(liar.site.ignored.values()) == len(kinds)
    assert liar.site.on_packet(Key("red", Channel.TO, "base"), b"", b"", 0.0) == []
    assert liar.site.on_packet(Key("red", Channel.TOPIC, "", ODOM), b"", b"", 0.0) == []
    assert liar.send(Kind.HEARTBEAT, channel=Channel.HELLO) == []


def test_random_packets_do_no_harm(liar: Liar) -> None:
    wanted(liar)
    random = Random(1)
    good = [
        packets.encode_heartbeat(packets.Heartbeat(9, 1.0, 1, 0.0, 1, 1, 1, 1, {ODOM: packets.Tail(2**60, 2**59)})),
        packets.encode_latched_list(packets.LatchedList(ODOM, 2**60, {1: 5})),
        packets.encode_resend_refusal(packets.ResendRefusal(ODOM, 2**62)),
        packets.encode_resend_request(packets.ResendRequest(ODOM, 0, 2**62)),
        *packets.encode_pages(2**61, [offered(latched=True)]),
        *packets.encode_pages(2**61, [Request(ODOM, 1e9)]),
    ]
    for _ in range(3000):
        liar.now += random.random() / 10
        body = random.choice(good)
        if random.random() < 0.3:
            position = random.randrange(len(body))
            body = body[:position] + random.randbytes(1) + body[position + 1 :]
        liar.send(random.choice([*Kind]), body, random.choice([OWN, 0, 5]))
        liar.take(liar.site.tick(liar.now))
        liar.message(random.randrange(1, 2**62), b"x", flags=random.randrange(256), publisher=random.randrange(2**32))
    assert len(liar.site.ignored) < 20


def test_two_topics_with_one_name_here() -> None:
    text = "take: [{topic: 'red:/odom', here: /odom}, {topic: 'red:/text', here: /odom}]"
    liar = Liar(Site(rules(text), OWN, 0.0))
    liar.meet()
    other: Any = load_message("std_msgs/Int64")
    liar.offer(offered(), offered(SharedName("red", "/text"), type="std_msgs/Int64", md5sum=other._md5sum))
    liar.define()
    liar.define("std_msgs/Int64", other._md5sum, "int64 data\n")
    liar.site.set_subscribed(["/odom"], 0.0)
    states = {str(received.topic): received.state for received in liar.site.received_topics()}
    assert states["red:/odom"] == "subscribed" and states["red:/text"].startswith("/odom is already a std_msgs/String")
    liar.offer(offered(SharedName("red", "/text"), type="std_msgs/Int64", md5sum=other._md5sum))
    assert only(Withdraw, liar.actions) and only(Advertise, liar.actions)[-1].type == "std_msgs/Int64"


def test_a_topic_that_becomes_latched_while_it_is_wanted(liar: Liar) -> None:
    wanted(liar)
    liar.actions.clear()
    liar.offer(offered(latched=True))
    kinds = [type(action) for action in liar.actions if isinstance(action, (Listen, Advertise, Withdraw))]
    assert kinds == [Advertise], "its subscribers here stay connected"
    liar.now += 0.6
    asked = [packets.decode_head(action.head).kind for action in only(Send, liar.take(liar.site.tick(liar.now)))]
    assert Kind.RESEND_REQUEST in asked


def test_a_latched_message_that_came_before_its_topic_was_offered_as_latched(liar: Liar) -> None:
    wanted(liar)
    assert [each.latched for each in only(Publish, liar.message(1, flags=Flag.LATCHED))] == [False]
    liar.offer(offered(latched=True))
    again = only(Publish, liar.message(1, flags=Flag.LATCHED))
    assert [(each.body, each.latched) for each in again] == [(b"x", True)]
    assert only(Publish, liar.message(1)) == [] and len(only(Publish, liar.message(2))) == 1
    liar.now += 1
    actions = liar.offer(offered())
    assert only(Forget, actions) == [Forget("/red/odom", Source("red", ODOM, 1))] and not only(Withdraw, actions)
    assert [each.latched for each in only(Publish, liar.message(3, flags=Flag.LATCHED))] == [False]


@pytest.mark.parametrize("becomes_latched", [True, False])
def test_a_second_name_of_a_latched_topic_gets_what_the_first_one_holds(becomes_latched: bool) -> None:
    site = Site(rules("send: [{topic: '*:/map', here: /map}]"), OWN, 0.0)
    red, blue = Liar(site), Liar(site, name="blue")
    red.meet()
    blue.meet()

    def set_topic(is_latched: bool) -> None:
        topic = LocalTopic("/map", "std_msgs/String", STRING._md5sum, "", is_latched, ("/n",))
        red.take(site.set_topics([topic], 0.0, 0.0))

    set_topic(not becomes_latched)
    for liar in (red, blue):
        for body in packets.encode_pages(1, [Request(SharedName(liar.name, "/map"), 0.0)]):
            sent = only(Send, liar.send(Kind.REQUEST, body))
        if liar is red:
            site.on_message("/map", ReceivedMessage("/n", STRING._md5sum, True, b"the map"), False, 0.0)
            set_topic(True)
    assert only(Subscribe, red.actions) == [Subscribe("/map", True)] and not only(Subscribe, blue.actions)
    assert [(each.key, each.body) for each in sent][:1] == [("again/blue/blue/map", b"the map")]
    assert packets.decode_message_head(sent[0].head).flags == Flag.LATCHED
    red.now += 1
    again = only(
        Send,
        red.send(
            Kind.RESEND_REQUEST, packets.encode_resend_request(packets.ResendRequest(SharedName("red", "/map"), 0, 9))
        ),
    )
    assert [(each.key, each.body) for each in again][:1] == [("again/red/red/map", b"the map")]


def test_packets_of_this_machine_have_valid_keys(liar: Liar) -> None:
    wanted(liar)
    for action in only(Send, liar.actions):
        assert parse_key(site_key("base", action.key)) is not None
    assert MemoryNetwork(Random(1)).now == 0.0


def test_another_run_of_a_site_that_sent_packets_for_this_one_alone(liar: Liar) -> None:
    wanted(liar)
    liar.heartbeat(is_separate=True)
    liar.epoch, liar.number = THEIR + 1, 0
    liar.meet()
    before = len(liar.actions)
    liar.offer(offered())
    liar.define()
    liar.take(liar.site.set_subscribed(["/red/odom"], liar.now))
    assert only(Listen, liar.actions[before:])[-1] == Listen("red", "t/red/odom", True), "it sends them for all"
