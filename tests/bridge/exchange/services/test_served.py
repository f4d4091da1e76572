"""Calls of other sites: each is carried out at most once, and its reply repeated until it is seen."""

from __future__ import annotations

import pytest

from pyros1.bridge.exchange.actions import Action, CallService, Send
from pyros1.bridge.exchange.peer import Peer
from pyros1.bridge.exchange.services import served as served_module
from pyros1.bridge.exchange.services.served import MAX_RUNNING, LocalService, ServedServices
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.calls import MAX_CALL_SIZE, MAX_SLOTS, CallId, Status
from pyros1.bridge.protocol.packets import Kind
from pyros1.bridge.rules.services import PARAMETERS

from .call_parts import ADD, MD5, OWN, THEIR, call_head, kinds, packets, present, rules

LOCAL = LocalService("/add", "a/B", MD5, "a/BRequest", "a/BResponse", "/node")


def make(text: str = "serve: [/add]", *sites: str, peers: dict[str, Peer] | None = None) -> ServedServices:
    served = ServedServices(rules(text, "red"), OWN, peers or {name: present(name) for name in sites or ("base",)})
    served.set_services([LOCAL, LOCAL._replace(name="/other")])
    return served


@pytest.fixture
def served() -> ServedServices:
    """The services of red, which serves /add to base."""
    return make()


def running(actions: list[Action]) -> list[CallService]:
    return [action for action in actions if isinstance(action, CallService)]


def replies(actions: list[Action]) -> list[tuple[Status, bytes]]:
    return [(head.status, body) for head, body in packets(actions) if head.kind is Kind.REPLY]


def test_what_is_offered() -> None:
    served = make("serve: [{service: /add, sites: [base]}, /far/**]\nparams: [/x]", "base", "blue")
    assert [each.service.name for each in served.offers("base")] == [PARAMETERS, "/add"]
    assert [each.service.name for each in served.offers("blue")] == [PARAMETERS]
    served.set_services([LOCAL._replace(name=PARAMETERS), LOCAL._replace(name="/far/a"), LOCAL._replace(name="/bad//")])
    assert [each.service.name for each in served.offers("base")] == [PARAMETERS, "/far/a"]
    assert make("sites: [base]\nserve: [/add]").offers("blue") == []


def test_a_site_that_may_not_call_is_offered_nothing_and_refused() -> None:
    text = "serve: ['/**']\nparams: [/x]\nsites: {base: {call: ['red:/add']}, blue: {send: ['/**']}, green: }"
    served = make(text, "base", "blue", "green")
    offers = {site: [each.service.name for each in served.offers(site)] for site in ("base", "blue", "green")}
    assert offers == {"base": ["/add"], "blue": [], "green": [PARAMETERS, "/add", "/other"]}
    assert running(served.on_call("base", ADD, call_head(), b"", 0.0))
    refused = [("base", "/other"), ("base", PARAMETERS), ("blue", "/add"), ("blue", PARAMETERS)]
    for slot, (peer, name) in enumerate(refused, 1):
        actions = served.on_call(peer, SharedName("red", name), call_head(slot), b"", 0.0)
        assert not running(actions) and [status for status, _ in replies(actions)] == [Status.REFUSED]
    assert running(served.on_call("green", SharedName("red", PARAMETERS), call_head(), b"", 0.0))


def test_a_call_and_its_reply(served: ServedServices) -> None:
    actions = served.on_call("base", ADD, call_head(left=50.0), b"request", 1.0)
    call = CallId("base", THEIR, 0, 1)
    (made,) = running(actions)
    assert kinds(actions) == [] and made[:3] == (call, "/add", b"request")
    assert 48.9 < made.timeout <= 49.0
    assert kinds(served.on_call("base", ADD, call_head(), b"request", 2.0)) == [Kind.CALL_SEEN]
    assert not running(served.on_call("base", ADD, call_head(), b"request", 2.0)), "at most once"
    assert kinds(served.on_call("base", ADD, call_head(1), bytes(20_000), 2.0)) == [Kind.CALL_SEEN]
    (reply,) = result = served.on_result(call, Status.OK, b"response", 3.0)
    assert replies(result) == [(Status.OK, b"response")]
    assert isinstance(reply, Send) and reply.key == "call/base/red/add"
    again = served.on_call("base", ADD, call_head(), b"request", 4.0)
    assert replies(again) == [(Status.OK, b"response")] and not running(again)
    assert served.on_call("base", ADD, call_head(), b"request", 4.1) == [], "not in floods"
    assert served.on_result(call, Status.OK, b"twice", 4.2) == []


def test_a_reply_is_repeated_until_it_is_seen(served: ServedServices) -> None:
    served.on_call("base", ADD, call_head(), b"", 0.0)
    served.on_result(CallId("base", THEIR, 0, 1), Status.FAILED, b"broken", 0.0)
    assert served.tick(0.9) == []
    assert replies(served.tick(1.1)) == [(Status.FAILED, b"broken")]
    assert served.tick(3.0) == [] and replies(served.tick(3.2)) == [(Status.FAILED, b"broken")]
    served.on_reply_seen("base", call_head(number=2))
    assert replies(served.tick(10.0))
    served.on_reply_seen("base", call_head())
    assert served.tick(30.0) == []
    assert served.on_call("base", ADD, call_head(sent_at=30.0), b"", 30.0) == [], "even then, it is not called again"
    (service,) = served.services()
    assert (service.counts.calls, service.counts.errors, service.counts.last_error) == (1, 1, "broken")


def test_a_reply_for_which_nobody_waits(served: ServedServices) -> None:
    served.on_call("base", ADD, call_head(left=5.0), b"", 0.0)
    served.on_result(CallId("base", THEIR, 0, 1), Status.OK, b"late", 4.0)
    assert served.tick(5.0) == []


def test_a_call_dated_in_the_future(served: ServedServices) -> None:
    (call,) = running(served.on_call("base", ADD, call_head(sent_at=1e9, left=5.0), b"", 1.0))
    assert call.timeout == 5.0
    served.on_result(CallId("base", THEIR, 0, 1), Status.OK, b"x", 2.0)
    assert replies(served.tick(5.9)) and served.tick(6.0) == []
    assert served.on_call("base", ADD, call_head(sent_at=1e9, left=5.0), b"", 7.0) == [], "its reply is gone"


def test_old_numbers_and_late_packets(served: ServedServices) -> None:
    assert running(served.on_call("base", ADD, call_head(number=5), b"", 0.0))
    assert served.on_call("base", ADD, call_head(number=4), b"", 0.0) == []
    assert running(served.on_call("base", ADD, call_head(slot=1, number=4), b"", 0.0))
    assert served.on_call("base", ADD, call_head(slot=2, left=3.0), b"", 4.0) == [], "whoever called waits no longer"
    assert served.on_call("base", ADD, call_head(slot=2), b"", 17.0) == [], "it was too long on its way"
    assert running(served.on_call("base", ADD, call_head(slot=2, sent_at=16.0), b"", 17.0))


def test_a_result_of_an_earlier_call_of_a_slot(served: ServedServices) -> None:
    served.on_call("base", ADD, call_head(number=1), b"", 0.0)
    served.on_call("base", ADD, call_head(number=2), b"", 0.0)
    assert served.on_result(CallId("base", THEIR, 0, 1), Status.OK, b"old", 1.0) == []
    assert replies(served.on_result(CallId("base", THEIR, 0, 2), Status.OK, b"new", 1.0)) == [(Status.OK, b"new")]


def test_slots_outlive_the_absence_of_a_site() -> None:
    peers = {"base": present("base")}
    served = make("serve: [/add]", peers=peers)
    served.on_call("base", ADD, call_head(), b"", 0.0)
    del peers["base"]
    assert served.on_result(CallId("base", THEIR, 0, 1), Status.OK, b"x", 1.0) == [] and served.tick(2.0) == []
    peers["base"] = present("base", 3.0)
    assert not running(served.on_call("base", ADD, call_head(sent_at=3.0), b"", 3.0))
    peers["base"] = present("base", 4.0, epoch=99)
    assert running(served.on_call("base", ADD, call_head(sent_at=4.0)._replace(epoch=99), b"", 4.0)), "another run"
    assert served.on_result(CallId("base", THEIR, 0, 1), Status.OK, b"x", 5.0) == []


def test_results_for_an_earlier_run_of_a_site() -> None:
    """Its new run counts its calls anew, and would take them for its own."""
    peers = {"base": present("base")}
    served = make("serve: [/add]", peers=peers)
    for slot in (0, 1):
        served.on_call("base", ADD, call_head(slot), b"", 0.0)
    served.on_result(CallId("base", THEIR, 0, 1), Status.OK, b"x", 0.5)
    peers["base"] = present("base", 1.0, epoch=99)
    assert served.on_result(CallId("base", THEIR, 1, 1), Status.OK, b"x", 1.0) == []
    assert served.tick(5.0) == []


def test_nothing_is_sent_to_a_site_that_is_lost() -> None:
    peers = {"base": present("base")}
    served = make("serve: [/add]", peers=peers)
    served.on_call("base", ADD, call_head(), b"", 0.0)
    assert peers["base"].tick(10.0)
    assert served.on_result(CallId("base", THEIR, 0, 1), Status.OK, b"x", 10.0) == [] and served.tick(20.0) == []


def test_what_is_refused(served: ServedServices, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("/other", "/none"):
        ((status, text),) = replies(served.on_call("base", SharedName("red", name), call_head(5), b"", 0.0))
        assert (status, text) == (Status.REFUSED, b"site red does not serve it, or no longer does")
        served = make()
    ((_, text),) = replies(served.on_call("base", ADD, call_head(6), bytes(MAX_CALL_SIZE + 1), 0.0))
    assert text == b"the request is larger than 16 MB"
    monkeypatch.setattr(served_module, "MAX_RUNNING_BYTES", 100)
    ((_, text),) = replies(served.on_call("base", ADD, call_head(7), bytes(101), 0.0))
    assert text == b"too many large requests at once at site red"


def test_a_site_that_may_not_call() -> None:
    served = make("serve: [{service: /add, sites: [blue]}]", "base", "blue")
    assert not running(served.on_call("base", ADD, call_head(), b"", 0.0))
    assert running(served.on_call("blue", ADD, call_head(), b"", 0.0))


def test_too_many_calls_at_once() -> None:
    names = [f"s{number}" for number in range(4)]
    served = make("serve: [/add]", *names)
    for number in range(MAX_SLOTS):
        assert running(served.on_call("s0", ADD, call_head(number), b"", 0.0))
    abandoned = served.on_call("s0", ADD, call_head(0, 2), b"", 0.0)
    assert replies(abandoned) == [(Status.REFUSED, b"too many calls at once at site red")]
    for name, number in (("s1", MAX_RUNNING // 4), ("s2", MAX_RUNNING // 8)):
        assert [len(running(served.on_call(name, ADD, call_head(slot), b"", 0.0))) for slot in range(number + 1)] == [
            *[1] * number,
            0,
        ], "always something is left for another site"
    assert running(served.on_call("s3", ADD, call_head(), b"", 0.0))
    for slot in range(MAX_RUNNING // 4):
        served.on_result(CallId("s1", THEIR, slot, 1), Status.OK, b"", 0.0)
    assert running(served.on_call("s1", ADD, call_head(0, 2), b"", 0.0))


def test_large_requests_of_several_sites(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(served_module, "MAX_RUNNING_BYTES", 100)
    served = make("serve: [/add]", "liar", "base")
    assert running(served.on_call("liar", ADD, call_head(0), bytes(50), 0.0))
    assert not running(served.on_call("liar", ADD, call_head(1), bytes(10), 0.0))
    assert running(served.on_call("base", ADD, call_head(0), bytes(50), 0.0))


def test_large_responses(served: ServedServices, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(3):
        served.on_call("base", ADD, call_head(number), b"", 0.0)
    ids = [CallId("base", THEIR, number, 1) for number in range(3)]
    assert replies(served.on_result(ids[0], Status.OK, bytes(MAX_CALL_SIZE + 1), 0.0)) == [
        (Status.REFUSED, b"the response is larger than 16 MB")
    ]
    monkeypatch.setattr(served_module, "MAX_REPLY_BYTES", 100)
    assert replies(served.on_result(ids[1], Status.OK, bytes(60), 0.0)) == [(Status.OK, bytes(60))]
    assert replies(served.on_result(ids[2], Status.OK, bytes(60), 0.0)) == [
        (Status.REFUSED, b"too many large responses at once")
    ]


def test_large_responses_for_many_sites(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(served_module, "MAX_ALL_REPLY_BYTES", 1000)
    served = make("serve: [/add]", "a", "b", "c")
    sizes = {"a": 500, "b": 251, "c": 230}
    for name in sizes:
        served.on_call(name, ADD, call_head(), b"", 0.0)
    results = [served.on_result(CallId(name, THEIR, 0, 1), Status.OK, bytes(sizes[name]), 0.0) for name in sizes]
    assert [status for result in results for status, _ in replies(result)] == [Status.OK, Status.REFUSED, Status.OK]


def test_replies_for_a_site_that_has_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(served_module, "MAX_ALL_REPLY_BYTES", 100)
    served = make("serve: [/add]", "base", "blue")
    for slot in (0, 1):
        served.on_call("base", ADD, call_head(slot), b"", 0.0)
    assert replies(served.on_result(CallId("base", THEIR, 0, 1), Status.OK, bytes(50), 0.0))
    served.drop_peer("base")
    assert served.tick(2.0) == []
    assert served.on_result(CallId("base", THEIR, 1, 1), Status.OK, bytes(50), 2.0) == [], "nobody waits"
    assert served.on_call("base", ADD, call_head(), b"", 3.0) == [], "even now, it is not called again"
    served.on_call("blue", ADD, call_head(), b"", 3.0)
    assert replies(served.on_result(CallId("blue", THEIR, 0, 1), Status.OK, bytes(50), 3.0)) == [
        (Status.OK, bytes(50))
    ], "replies that nobody waits for take no room"


def test_the_time_of_a_rule() -> None:
    served = make("serve: [{service: /add, timeout: 2}]")
    (call,) = running(served.on_call("base", ADD, call_head(), b"", 0.0))
    assert call.timeout == 2.0


def test_slots_of_many_sites(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(served_module, "MAX_SITES", 2)
    peers = {name: present(name) for name in ("a", "b", "c")}
    served = make("serve: [/add]", peers=peers)
    for name in ("a", "b"):
        served.on_call(name, ADD, call_head(), b"", 0.0)
    del peers["b"]
    served.on_call("c", ADD, call_head(), b"", 0.0)
    assert [*served.callers] == ["a", "c"]
