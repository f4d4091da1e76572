"""Services of a site as a whole: packets that go to the right part, and sites that come and go."""

from __future__ import annotations

import pytest

from pyros1.bridge.exchange.actions import Action, CallService, Return, Send, StopProviding
from pyros1.bridge.exchange.services.served import LocalService
from pyros1.bridge.exchange.services.services import Services
from pyros1.bridge.exchange.site import Site
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.calls import CallHead, Status, decode_services, encode_call_head
from pyros1.bridge.protocol.key_expressions import Channel, Key, parse_key
from pyros1.bridge.protocol.packet_values import PacketError
from pyros1.bridge.protocol.packets import Kind

from ..test_site import Liar
from .call_parts import ADD, MD5, OWN, THEIR, call_head, offered, packets, present, rules


@pytest.fixture
def services() -> Services:
    """The services of base, which calls those of red, and serves /add."""
    found = Services(rules("{serve: [/add], call: ['red:**']}"), OWN, {"red": present("red")})
    found.served.set_services([LocalService("/add", "a/B", MD5, "a/B", "a/B", "/node")])
    found.calls.set_taken({})
    found.calls.set_offers("red", [offered()])
    return found


def test_packets_of_third_sites_services(services: Services) -> None:
    for kind, site in ((Kind.CALL, "red"), (Kind.CALL, "blue"), (Kind.REPLY, "base"), (Kind.REPLY_SEEN, "red")):
        with pytest.raises(PacketError, match="third site"):
            services.on_packet("red", SharedName(site, "/add"), call_head()._replace(kind=kind), b"", 0.0)


def test_packets_go_to_the_right_part(services: Services) -> None:
    ((call, _),) = packets(services.calls.call(1, "/red/add", b"", 0.0))
    services.on_packet("red", ADD, call._replace(kind=Kind.CALL_SEEN), b"", 0.0)
    assert services.calls.tick(2.0) == []
    actions = services.on_packet("red", ADD, call._replace(kind=Kind.REPLY), b"x", 0.0)
    assert isinstance(actions[0], Return)
    own = SharedName("base", "/add")
    running = services.on_packet("red", own, call_head(), b"", 0.0)[0]
    assert isinstance(running, CallService)
    assert services.served.on_result(running.call, call.status, b"", 0.0)
    services.on_packet("red", own, call_head()._replace(kind=Kind.REPLY_SEEN), b"", 0.0)
    assert services.tick(5.0) == []


def test_a_run_of_a_site_ends(services: Services) -> None:
    services.calls.call(1, "/red/add", b"", 0.0)
    failed, gone = services.drop_peer("red", "site red has left")
    assert isinstance(failed, Return) and failed.body.startswith(b"site red has left; ")
    assert gone == StopProviding("/red/add")
    assert services.on_lost("red") == []


def test_replies_for_a_run_of_a_site_end_with_it(services: Services) -> None:
    own = SharedName("base", "/add")
    (running,) = services.on_packet("red", own, call_head(), b"", 0.0)
    assert isinstance(running, CallService)
    assert packets(services.served.on_result(running.call, Status.OK, b"x", 0.0)) and packets(services.tick(2.0))
    services.drop_peer("red", "site red has left")
    assert services.tick(10.0) == []


def test_keys() -> None:
    assert parse_key("pyros1/1/base/call/red/red/a/add") == Key(
        "base", Channel.CALL, "red", SharedName("red", "/a/add")
    )
    for text in ("call", "call/red", "call/red/red", "call//red/add", "again//red/add"):
        assert parse_key(f"pyros1/1/base/{text}") is None


def test_calls_of_sites_that_are_not_present() -> None:
    site = Site(rules("serve: ['/**']"), OWN, 0.0)
    head = encode_call_head(CallHead(Kind.CALL, THEIR, OWN, 0, 1, left=9.0))
    key = Key("red", Channel.CALL, "base", SharedName("base", "/add"))
    assert site.on_packet(key, head, b"", 0.0) == []
    assert site.on_packet(key, b"?", b"", 0.0) == []
    assert site.ignored == {"red: calls from a run that is not current": 1, "red: not the head of a call": 1}
    assert not [each for each in site.tick(0.1) if isinstance(each, Send) and each.key.startswith("call")]


def test_calls_of_a_present_site_and_its_next_run() -> None:
    site = Site(rules("{serve: [/add], call: ['red:**']}"), OWN, 0.0)
    liar = Liar(site)
    liar.meet()
    (sent,) = site.set_services([LocalService("/add", "a/B", MD5, "a/B", "a/B", "/node")], {}, 0.0)
    assert isinstance(sent, Send) and decode_services(sent.body).entries[0].service == ("base", "/add")
    site.services.calls.set_offers("red", [offered()])
    key = Key("red", Channel.CALL, "base", SharedName("base", "/add"))

    def call(to_epoch: int) -> list[Action]:
        head = call_head(sent_at=5000.0)._replace(to_epoch=to_epoch)
        return site.on_packet(key, encode_call_head(head), b"", 0.0)

    assert call(0) == [] and call(OWN + 1) == [], "a call is for one run of this site"
    assert [type(action) for action in call(OWN)] == [CallService]
    site.services.calls.call(1, "/red/add", b"", 0.0)
    liar.epoch, liar.now = THEIR + 1, 1.0
    liar.number = 0
    liar.heartbeat()
    (failed,) = [action for action in liar.heartbeat() if isinstance(action, Return)]
    assert failed.body.startswith(b"site red has started again; ")


def test_calls_of_a_site_that_is_lost() -> None:
    site = Site(rules("call: ['red:**']"), OWN, 0.0)
    liar = Liar(site)
    liar.meet()
    site.set_services([], {}, 0.0)
    site.services.calls.set_offers("red", [offered()])
    site.services.calls.call(1, "/red/add", b"", 0.0)
    assert not [action for action in site.tick(4.9) if isinstance(action, Return)]
    (failed,) = [action for action in site.tick(5.1) if isinstance(action, Return)]
    assert failed.body.startswith(b"site red does not respond; ")
