"""Calls of other sites' services: what is provided here, and how each call ends."""

from __future__ import annotations

import pytest

from pyros1.bridge.exchange.actions import Action, Provide, Return, Send, StopProviding
from pyros1.bridge.exchange.peer import Peer
from pyros1.bridge.exchange.services import calls as calls_module
from pyros1.bridge.exchange.services.calls import MAX_SERVICES, Calls
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.calls import MAX_CALL_SIZE, MAX_SLOTS, CallHead, Status
from pyros1.bridge.protocol.packets import Kind
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.rules.services import PARAMETERS

from .call_parts import ADD, MD5, OWN, THEIR, kinds, offered, packets, present, rules


def provide(local: str) -> Provide:
    return Provide(local, "a/B", MD5, "a/BRequest", "a/BResponse")


def make(text: str = "call: ['*:**']", *sites: str) -> Calls:
    peers = {name: present(name) for name in sites or ("red",)}
    return Calls(rules(text), OWN, peers)


@pytest.fixture
def calls() -> Calls:
    """Calls of red's service /add, which is provided."""
    found = make()
    found.set_taken({})
    found.set_offers("red", [offered()])
    return found


def reply(number: int = 1, status: Status = Status.OK, slot: int = 0) -> CallHead:
    return CallHead(Kind.REPLY, THEIR, OWN, slot, number, status)


def ended(actions: list[Action]) -> list[Return]:
    return [action for action in actions if isinstance(action, Return)]


def test_nothing_is_provided_before_it_is_known_what_there_is() -> None:
    calls = make()
    assert calls.set_offers("red", [offered()]) == []
    assert calls.set_taken({}) == [provide("/red/add")]
    assert calls.set_taken({}) == [] and calls.set_offers("red", [offered()]) == []
    assert calls.set_offers("red", []) == [StopProviding("/red/add")]


def test_what_a_site_may_not_serve_is_not_provided() -> None:
    calls = make("call: ['*:**']\nsites: {red: {serve: [/add]}}")
    calls.set_taken({})
    assert calls.set_offers("red", [offered(), offered("/other"), offered(PARAMETERS)]) == [provide("/red/add")]
    assert {str(each.offered.service): each.state for each in calls.services()} == {
        "red:/add": "",
        "red:/other": "red may not serve it",
    }
    (refused,) = ended(calls.ask_parameters(1, "red", b"?", 9.0, 0.0))
    assert b"`sites` here does not allow red:/pyros1_bridge/parameters" in refused.body
    calls = make(f"sites: {{red: {{serve: ['{PARAMETERS}']}}}}")
    calls.set_offers("red", [offered(PARAMETERS)])
    assert isinstance(calls.ask_parameters(1, "red", b"?", 9.0, 0.0)[0], Send)


def test_another_type_is_provided_anew(calls: Calls) -> None:
    changed = offered(md5sum="b" * 32)
    assert calls.set_offers("red", [changed]) == [
        StopProviding("/red/add"),
        Provide("/red/add", "a/B", "b" * 32, "a/BRequest", "a/BResponse"),
    ]


def test_a_name_that_a_node_here_has_is_left_to_it(calls: Calls) -> None:
    assert calls.set_taken({"/red/add": "/robot"}) == [StopProviding("/red/add")]
    assert calls.services()[0].state == "/robot already provides /red/add here"
    assert ended(calls.call(1, "/red/add", b"", 0.0)) == [
        Return(1, Status.REFUSED, b"service /red/add no longer exists")
    ]
    assert calls.set_taken({}) == [provide("/red/add")]


def test_a_name_of_several_sites() -> None:
    calls = make("call: [{service: '*:/add', here: /add}]", "blue", "red")
    calls.set_taken({})
    assert calls.set_offers("red", [offered()]) == [provide("/add")]
    assert calls.set_offers("blue", [offered(site="blue")]) == [], "the first one stays"
    assert [(each.peer, each.state) for each in calls.services()] == [
        ("red", ""),
        ("blue", "/add is already red:/add here"),
    ]
    assert calls.set_offers("red", []) == [StopProviding("/add"), provide("/add")]
    (packet,) = calls.call(1, "/add", b"x", 0.0)
    assert isinstance(packet, Send) and packet.key == "call/blue/blue/add"


@pytest.mark.parametrize(
    ("text", "service", "reason"),
    [
        ("call: ['red:/other']", offered(), "no rule calls it"),
        ("call: ['red:**']\ndeny_call: ['red:/add']", offered(), "denied by a rule"),
        ("call: ['*:**']", offered(site="blue"), "red serves a service of another site"),
        ("call: ['*:**']\nprefix: {red: /" + "a" * 252 + "}", offered(), "its name here would be too long"),
    ],
)
def test_services_that_are_not_provided(text: str, service: object, reason: str) -> None:
    calls = make(text)
    calls.set_taken({})
    assert calls.set_offers("red", [service]) == []  # type: ignore[list-item]
    assert [(each.local, each.state) for each in calls.services()] == [("", reason)]


def test_a_site_that_serves_too_much(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calls_module, "MAX_REFUSED", 3)
    calls = make()
    calls.set_taken({})
    assert len(calls.set_offers("red", [offered(f"/s{number}") for number in range(MAX_SERVICES + 5)])) == MAX_SERVICES
    assert len(calls.services()) == MAX_SERVICES + 3


def test_a_call_and_its_reply(calls: Calls) -> None:
    (packet,) = sent = calls.call(7, "/red/add", b"request", 1.0)
    assert isinstance(packet, Send) and (packet.key, packet.priority) == ("call/red/red/add", Priority.HIGH)
    assert packets(sent) == [(CallHead(Kind.CALL, OWN, THEIR, 0, 1, Status.OK, 1.0, 60.0), b"request")]
    actions = calls.on_reply("red", ADD, reply(), b"response", 1.5)
    assert kinds(actions) == [Kind.REPLY_SEEN] and ended(actions) == [Return(7, Status.OK, b"response")]
    assert calls.tick(2.0) == []
    again = calls.on_reply("red", ADD, reply(), b"response", 2.0)
    assert kinds(again) == [Kind.REPLY_SEEN] and not ended(again), "a reply that comes twice counts once"


def test_a_reply_must_fit_the_call(calls: Calls) -> None:
    calls.call(7, "/red/add", b"", 0.0)
    for service, head in (
        (ADD, reply(number=2)),
        (ADD, reply(slot=1)),
        (SharedName("red", "/other"), reply()),
    ):
        assert not ended(calls.on_reply("red", service, head, b"", 0.1))
    assert ended(calls.on_reply("red", ADD, reply(), b"", 0.1))


def test_errors(calls: Calls) -> None:
    calls.call(1, "/red/add", b"", 0.0)
    assert ended(calls.on_reply("red", ADD, reply(1, Status.FAILED), b"broken", 0.1)) == [
        Return(1, Status.FAILED, b"broken")
    ]
    calls.call(2, "/red/add", b"", 0.0)
    assert ended(calls.on_reply("red", ADD, reply(2, Status.REFUSED), b"too many", 0.1)) == [
        Return(2, Status.REFUSED, b"red:/add: too many")
    ]
    counts = calls.services()[0].counts
    assert (counts.calls, counts.errors, counts.last_error) == (2, 2, "red:/add: too many")
    calls.call(3, "/red/add", b"", 0.0)
    (large,) = ended(calls.on_reply("red", ADD, reply(3), bytes(MAX_CALL_SIZE + 1), 0.1))
    assert (large.status, large.body) == (Status.REFUSED, b"the response is larger than 16 MB")


def test_a_call_is_repeated_until_it_is_seen(calls: Calls) -> None:
    calls.call(1, "/red/add", b"x", 0.0)
    assert calls.tick(0.9) == []
    assert kinds(calls.tick(1.01)) == [Kind.CALL]
    assert calls.tick(2.9) == [], "later and later"
    ((head, body),) = packets(calls.tick(3.1))
    assert (head.number, head.sent_at, round(head.left, 3), body) == (1, 3.1, 56.9, b"x")
    calls.on_seen("red", head._replace(number=2))
    assert kinds(calls.tick(8.0)) == [Kind.CALL]
    calls.on_seen("red", head)
    assert calls.tick(30.0) == []
    assert ended(calls.tick(60.0)) == [
        Return(1, Status.REFUSED, b"red:/add has not answered in time; the call may have been carried out, or not")
    ]
    assert calls.tick(61.0) == []


def test_the_time_of_a_rule() -> None:
    calls = make("call: [{service: 'red:/add', timeout: 2}]")
    calls.set_taken({})
    calls.set_offers("red", [offered()])
    calls.call(1, "/red/add", b"", 0.0)
    assert not ended(calls.tick(1.9)) and ended(calls.tick(2.0))


def test_a_site_that_is_lost() -> None:
    peers: dict[str, Peer] = {"red": present("red")}
    calls = Calls(rules("call: ['red:**']"), OWN, peers)
    calls.set_taken({})
    calls.set_offers("red", [offered()])
    calls.call(1, "/red/add", b"", 0.0)
    (failed,) = calls.fail_all("red", "site red does not respond")
    assert failed == Return(1, Status.REFUSED, b"site red does not respond; the call may have been carried out, or not")
    assert calls.fail_all("red", "again") == [] and calls.tick(100.0) == []
    assert peers["red"].tick(100.0)
    assert calls.call(2, "/red/add", b"", 100.0) == [Return(2, Status.REFUSED, b"site red does not respond")]


def test_limits(calls: Calls, monkeypatch: pytest.MonkeyPatch) -> None:
    (large,) = calls.call(1, "/red/add", bytes(MAX_CALL_SIZE + 1), 0.0)
    assert large == Return(1, Status.REFUSED, b"the request is larger than 16 MB")
    counts = calls.services()[0].counts
    assert (counts.calls, counts.errors, counts.last_error) == (1, 1, "the request is larger than 16 MB")
    slots = [packets(calls.call(number, "/red/add", b"", 0.0))[0][0].slot for number in range(MAX_SLOTS)]
    assert sorted(slots) == [*range(MAX_SLOTS)]
    (refused,) = calls.call(99, "/red/add", b"", 0.0)
    assert refused == Return(99, Status.REFUSED, b"more than 32 calls at once to site red")
    calls.on_reply("red", ADD, reply(6, slot=5), b"", 0.1)
    ((head, _),) = packets(calls.call(99, "/red/add", b"", 0.2))
    assert head.slot == 5 and head.number > MAX_SLOTS, "a slot is used again, with a higher number"
    calls.on_reply("red", ADD, reply(7, slot=6), b"", 0.1)
    monkeypatch.setattr(calls_module, "MAX_WAITING_BYTES", 10)
    ((head, _),) = packets(calls.call(100, "/red/add", bytes(10), 0.2))
    assert ended(calls.call(101, "/red/add", b"x", 0.2))[0].body.startswith(b"more than 32 calls")
    calls.on_reply("red", ADD, reply(8, slot=7), b"", 0.1)
    assert ended(calls.call(101, "/red/add", b"x", 0.2))[0].body == b"too many large requests at once"
    calls.on_seen("red", head)
    assert packets(calls.call(101, "/red/add", b"x", 0.2)), "a request that was seen is kept no longer"


def test_large_requests_go_at_the_pace_of_the_network(calls: Calls) -> None:
    (packet,) = calls.call(1, "/red/add", bytes(20_000), 0.0)
    assert isinstance(packet, Send) and packet.priority is Priority.NORMAL
    (again,) = calls.tick(1.1)
    assert isinstance(again, Send) and again.replaces == packet.replaces, "one that waits is not queued twice"


def test_parameters(calls: Calls) -> None:
    assert ended(calls.ask_parameters(1, "blue", b"?", 9.0, 0.0))[0].body == b"there is no site blue; there are: red"
    assert (
        b"does not let this site read its parameters" in ended(calls.ask_parameters(1, "red", b"?", 9.0, 0.0))[0].body
    )
    assert calls.set_offers("red", [offered(), offered(PARAMETERS)]) == [], "it is not provided here"
    (packet,) = calls.ask_parameters(1, "red", b"?", 9.0, 0.0)
    assert isinstance(packet, Send) and packet.key == f"call/red/red{PARAMETERS}" and packet.body == b"?"
    calls.set_offers("red", [offered()])
    assert ended(calls.ask_parameters(2, "red", b"?", 9.0, 0.0))
